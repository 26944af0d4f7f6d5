//! The properties that must hold for any bytes, in each format. A panic is a finding.

mod inputs;

use std::collections::BTreeSet;

use mocap::process::validate;
use mocap::{Code, Diagnostic, Importer, Pose, Scene, SkeletonMesh, bvh, gltf};

pub use self::inputs::{AMC, ASF, BVH, C3D, FBX, FORMATS, GLB, Input, fixture};

const MESHES: [SkeletonMesh; 3] = [SkeletonMesh::None, SkeletonMesh::Segmented, SkeletonMesh::Skinned];

impl Input {
    /// An error; or a scene that keeps every rule, with each kind of skeleton mesh, can be posed at any tick, and is
    /// the same once it is written as glTF or BVH.
    pub fn hold(&self, bytes: &[u8]) {
        for mesh in MESHES {
            let Ok(scene) = self.read(bytes, mesh) else { return };
            let violations = validate(&scene);
            assert!(violations.is_empty(), "{mesh:?}: {violations:?}");
            for tick in [0.0, 0.5, f64::MAX, f64::NAN] {
                // The positions are not specified then; it must only end without a panic.
                let _ = Pose::at_tick(&scene, 0, tick);
            }
            export_gltf(&scene);
            if mesh == SkeletonMesh::None {
                export_bvh(&scene);
            }
        }
    }

    /// An error; or a scene that keeps every rule and can be posed. The part of [`hold`](Self::hold) that is quick enough
    /// for millions of inputs.
    pub fn survive(&self, bytes: &[u8]) {
        let Ok(scene) = self.read(bytes, SkeletonMesh::Segmented) else {
            return;
        };
        let violations = validate(&scene);
        assert!(violations.is_empty(), "{violations:?}");
        let _ = Pose::at_tick(&scene, 0, 0.5);
    }

    /// The codes of an input's error and warnings, by which inputs are distinguished.
    pub fn outcome(&self, bytes: &[u8]) -> BTreeSet<&'static str> {
        let codes = |warnings: &[Diagnostic]| warnings.iter().map(|warning| warning.code.as_str()).collect();
        match self.read(bytes, SkeletonMesh::None) {
            Ok(scene) => codes(&scene.warnings),
            Err(error) => {
                let mut codes: BTreeSet<_> = codes(error.warnings());
                // A code may be a warning in one file and the error of another.
                codes.extend(["error", error.code().as_str()]);
                codes
            }
        }
    }
}

/// An error, or a glTF file that holds the same nodes.
fn export_gltf(scene: &Scene) {
    // Not every scene can be written: links of 1e38 add up to infinity. An error is an answer.
    let Ok(glb) = gltf::write_glb(scene, &gltf::GltfOptions::default()) else {
        return;
    };
    let file = ::gltf::Gltf::from_slice(&glb).expect("what was exported is valid glTF");
    assert!(file.nodes().len() >= scene.nodes.len());
    let written = file.animations().len();
    assert!(written <= scene.animations.len() && (written >= 1 || !moves(scene)));
}

/// An error, or a BVH file that is read back to as many frames, and without a warning but of names and roots.
fn export_bvh(scene: &Scene) {
    let Ok(text) = bvh::write(scene, &bvh::BvhOptions::default()) else {
        return;
    };
    let importer = Importer::new()
        .format(mocap::Format::Bvh)
        .skeleton_mesh(SkeletonMesh::None);
    let again = match importer.read(&text, "written.bvh") {
        Ok(again) => again,
        // A name becomes longer where it had no letters that text has, and a group is a node of its own.
        Err(error) if error.code() == Code::LimitExceeded => return,
        Err(error) => panic!("what was written is refused: {error}"),
    };
    let said: Vec<_> = (again.warnings.iter())
        .filter(|warning| !matches!(warning.code, Code::DuplicateName | Code::SeveralRoots))
        .collect();
    assert!(said.is_empty(), "what was written deviates from the format: {said:?}");
    // Durations that were computed from seconds fall a little short of a whole tick.
    let frames = |scene: &Scene| {
        scene
            .animations
            .first()
            .map_or(0.0, |animation| (animation.duration + 1e-6).floor())
    };
    assert_eq!(frames(&again), frames(scene), "frames were lost");
}

/// Whether any track has more than one key: glTF stores the others in their nodes.
fn moves(scene: &Scene) -> bool {
    scene
        .animations
        .iter()
        .flat_map(|animation| &animation.channels)
        .any(|channel| {
            channel.position_keys.len() > 1 || channel.rotation_keys.len() > 1 || channel.scaling_keys.len() > 1
        })
}
