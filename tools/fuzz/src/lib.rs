//! The properties that must hold for any bytes, in each format. A panic is a finding.

mod inputs;
mod written;

use std::collections::BTreeSet;

use mocap::{Diagnostic, Pose, SkeletonMesh};

pub use self::inputs::{BVH, FORMATS, Input, fixture};

const MESHES: [SkeletonMesh; 3] = [SkeletonMesh::None, SkeletonMesh::Segmented, SkeletonMesh::Skinned];

impl Input {
    /// An error, or a valid scene. A valid scene keeps every rule, with each kind of skeleton mesh, can be posed at any
    /// tick, and is equal after it is written and read back. Returns whether there was a scene.
    pub fn hold(&self, bytes: &[u8]) -> bool {
        for mesh in MESHES {
            let Ok(scene) = self.read(bytes, mesh) else {
                return false;
            };
            let violations = scene.validate();
            assert!(violations.is_empty(), "{mesh:?}: {violations:?}");
            for tick in [0.0, 0.5, f64::MAX, f64::NAN] {
                // The positions are not specified here; the call must only end without a panic.
                let _ = Pose::at_tick(&scene, 0, tick);
            }
            let choice = bytes.iter().fold(0u8, |sum, byte| sum.wrapping_add(*byte));
            written::hold(&scene, mesh, self.outputs, choice);
        }
        true
    }

    /// Checks for an error, or for a scene that keeps every rule and can be posed. This part of [`hold`](Self::hold) is
    /// quick enough for millions of inputs.
    pub fn survive(&self, bytes: &[u8]) {
        let Ok(scene) = self.read(bytes, SkeletonMesh::Segmented) else {
            return;
        };
        let violations = scene.validate();
        assert!(violations.is_empty(), "{violations:?}");
        let _ = Pose::at_tick(&scene, 0, 0.5);
    }

    /// The codes of an input's warnings, and the text of its error without names and numbers. They distinguish inputs.
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
                // A code may be a warning in one file and an error in another.
                let said = error.diagnostic().message.split('"').step_by(2).collect::<String>();
                codes.insert("error".to_owned());
                codes.insert(said.replace(|c: char| !c.is_alphabetic() && c != ' ', ""));
                codes
            }
        }
    }
}
