// Written by `MOCAP_WRITE=1 cargo test -p mocap-bindings`, from the documentation of Rust: do not edit.

/** Files that are read for themselves. */
export const MOTION = /\.(bvh|vrma|glb|gltf|amc|c3d|trc|fbx|usda|usdz|mclip|vmd|pmx|urdf|mjcf|mot|sto|vrm|xml)$/i;
