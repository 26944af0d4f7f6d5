//! Assimp's post-processing flags, and which steps of `mocap` they are.

use mocap::Scene;
use mocap::process::{self, KeyTolerance};

const JOIN_IDENTICAL_VERTICES: u32 = 0x2;
const VALIDATE_DATA_STRUCTURE: u32 = 0x400;
const FIND_DEGENERATES: u32 = 0x1_0000;
const FIND_INVALID_DATA: u32 = 0x2_0000;
const DEBONE: u32 = 0x400_0000;

/// Flags that would change a skeleton's scene in a way that is not offered here. All others change nothing in it: they
/// are about texture coordinates, polygons, materials or large meshes, which it does not have.
const REFUSED: &[(u32, &str)] = &[
    (0x4, "aiProcess_MakeLeftHanded"),
    (0x10, "aiProcess_RemoveComponent"),
    (0x100, "aiProcess_PreTransformVertices"),
    (0x4000, "aiProcess_PopulateArmatureData"),
    (0x100_0000, "aiProcess_FlipWindingOrder"),
    (0x200_0000, "aiProcess_SplitByBoneCount"),
    (0x2000_0000, "aiProcess_ForceGenNormals"),
    (0x4000_0000, "aiProcess_DropNormals"),
    (0x8000_0000, "aiProcess_GenBoundingBoxes"),
];

/// `AI_SCENE_FLAGS_NON_VERBOSE_FORMAT`: faces share vertices.
const SCENE_NON_VERBOSE: u32 = 8;

/// Whether all of these flags can be honoured.
pub(crate) fn check(flags: u32) -> Result<(), String> {
    match REFUSED.iter().find(|(flag, _)| flags & flag != 0) {
        Some((_, name)) => Err(format!("{name} is not supported")),
        None => Ok(()),
    }
}

/// Runs the steps in Assimp's order.
pub(crate) fn run(scene: &mut Scene, flags: u32) -> Result<(), String> {
    if flags & VALIDATE_DATA_STRUCTURE != 0
        && let Some(violation) = process::validate(scene).first()
    {
        return Err(format!("Validation failed: {violation}"));
    }
    if flags & FIND_DEGENERATES != 0 {
        process::find_degenerates(scene);
    }
    if flags & FIND_INVALID_DATA != 0 {
        process::remove_sizeless_meshes(scene);
        process::collapse_keys(scene, KeyTolerance::default());
    }
    if flags & JOIN_IDENTICAL_VERTICES != 0 {
        process::join_identical_vertices(scene);
    }
    if flags & DEBONE != 0 {
        process::debone(scene);
    }
    Ok(())
}

/// What `aiScene::mFlags` says after these steps.
pub(crate) fn of_scene(flags: u32) -> u32 {
    if flags & JOIN_IDENTICAL_VERTICES == 0 {
        0
    } else {
        SCENE_NON_VERBOSE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_accepted_and_other_worlds_refused() {
        // aiProcessPreset_TargetRealtime_MaxQuality | aiProcess_Debone, and aiProcess_ConvertToLeftHanded.
        assert_eq!(check(0x37_9ecb | DEBONE), Ok(()));
        assert_eq!(
            check(0x180_0004),
            Err("aiProcess_MakeLeftHanded is not supported".to_owned())
        );
    }
}
