//! The properties that must hold for any bytes, in each format. A panic is a finding.

mod inputs;
mod written;

use std::collections::BTreeSet;

use mocap::{Diagnostic, Pose, SkeletonMesh};

pub use self::inputs::{BVH, FORMATS, Input, fixture};

const MESHES: [SkeletonMesh; 3] = [SkeletonMesh::None, SkeletonMesh::Segmented, SkeletonMesh::Skinned];

impl Input {
    /// An error, or a valid scene. Such a scene keeps every rule, with each kind of skeleton mesh, can be posed at any
    /// tick, and is the same after it is written and read back. Whether there was a scene.
    pub fn hold(&self, bytes: &[u8]) -> bool {
        for mesh in MESHES {
            let Ok(scene) = self.read(bytes, mesh) else {
                return false;
            };
            let violations = scene.validate();
            assert!(violations.is_empty(), "{mesh:?}: {violations:?}");
            for tick in [0.0, 0.5, f64::MAX, f64::NAN] {
                // The positions are not specified then; it must only end without a panic.
                let _ = Pose::at_tick(&scene, 0, tick);
            }
            let choice = bytes.iter().fold(0u8, |sum, byte| sum.wrapping_add(*byte));
            written::hold(&scene, mesh, self.outputs, choice);
        }
        true
    }

    /// An error; or a scene that keeps every rule and can be posed. The part of [`hold`](Self::hold) that is quick
    /// enough for millions of inputs.
    pub fn survive(&self, bytes: &[u8]) {
        let Ok(scene) = self.read(bytes, SkeletonMesh::Segmented) else {
            return;
        };
        let violations = scene.validate();
        assert!(violations.is_empty(), "{violations:?}");
        let _ = Pose::at_tick(&scene, 0, 0.5);
    }

    /// The codes of an input's warnings and what its error says, but for names and numbers, by which inputs are
    /// distinguished.
    pub fn outcome(&self, bytes: &[u8]) -> BTreeSet<String> {
        let codes = |warnings: &[Diagnostic]| {
            warnings
                .iter()
                .map(|warning| warning.code.as_str().to_owned())
                .collect()
        };
        match self.read(bytes, SkeletonMesh::None) {
            Ok(scene) => codes(&scene.warnings),
            Err(error) => {
                let mut codes: BTreeSet<_> = codes(error.warnings());
                // A code may be a warning in one file and the error of another.
                let said = error.diagnostic().message.split('"').step_by(2).collect::<String>();
                codes.insert("error".to_owned());
                codes.insert(said.replace(|c: char| !c.is_alphabetic() && c != ' ', ""));
                codes
            }
        }
    }
}
