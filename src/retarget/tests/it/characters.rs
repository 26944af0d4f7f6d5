//! Reads characters and motions of the fixtures, for other tests.

use mocap::{Conversion, Scene};

pub(crate) fn character(name: &str) -> Scene {
    mocap::import(format!("../../fixtures/skeletons/{name}.gltf")).unwrap()
}

/// A motion in metres with +Y up, with few of its frames.
pub(crate) fn motion(file: &str) -> Scene {
    let mut scene = mocap::Importer::new()
        .skeleton_mesh(mocap::SkeletonMesh::None)
        .import(format!("../../fixtures/{file}"))
        .unwrap();
    Conversion::new().apply(&mut scene).unwrap();
    scene
}
