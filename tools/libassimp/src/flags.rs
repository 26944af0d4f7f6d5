//! Assimp's post-processing flags, and the corresponding steps of `mocap`.

use std::ffi::CStr;

use mocap::Scene;
use mocap::process::KeyTolerance;

use crate::abi::SCENE_NON_VERBOSE;
use crate::properties::Properties;

const JOIN_IDENTICAL_VERTICES: u32 = 0x2;
const GEN_NORMALS: u32 = 0x20;
const GEN_SMOOTH_NORMALS: u32 = 0x40;
const PRE_TRANSFORM_VERTICES: u32 = 0x100;
const LIMIT_BONE_WEIGHTS: u32 = 0x200;
const VALIDATE_DATA_STRUCTURE: u32 = 0x400;
const SORT_BY_P_TYPE: u32 = 0x8000;
const FIND_DEGENERATES: u32 = 0x1_0000;
const FIND_INVALID_DATA: u32 = 0x2_0000;
const OPTIMIZE_GRAPH: u32 = 0x40_0000;
const DEBONE: u32 = 0x400_0000;
const GLOBAL_SCALE: u32 = 0x800_0000;

/// Flags that change the scene of a skeleton in a way that this library lacks; the system's Assimp runs them. Other
/// flags change nothing: they affect texture coordinates, polygons, materials or large meshes, which the scene does not
/// have.
const FOREIGN: &[(u32, &str)] = &[
    (0x4, "aiProcess_MakeLeftHanded"),
    (0x10, "aiProcess_RemoveComponent"),
    (PRE_TRANSFORM_VERTICES, "aiProcess_PreTransformVertices"),
    (0x4000, "aiProcess_PopulateArmatureData"),
    (0x100_0000, "aiProcess_FlipWindingOrder"),
    (0x200_0000, "aiProcess_SplitByBoneCount"),
    (0x2000_0000, "aiProcess_ForceGenNormals"),
    (0x4000_0000, "aiProcess_DropNormals"),
    (0x8000_0000, "aiProcess_GenBoundingBoxes"),
];

/// Settings of steps for which this library supports only the default values.
const SETTINGS: &[(u32, &CStr, &str)] = &[
    (SORT_BY_P_TYPE, c"PP_SBP_REMOVE", "PP_SBP_REMOVE"),
    (FIND_DEGENERATES, c"PP_FD_REMOVE", "PP_FD_REMOVE"),
    (FIND_INVALID_DATA, c"PP_FID_ANIM_ACCURACY", "PP_FID_ANIM_ACCURACY"),
    (DEBONE, c"PP_DB_THRESHOLD", "PP_DB_THRESHOLD"),
    (DEBONE, c"PP_DB_ALL_OR_NONE", "PP_DB_ALL_OR_NONE"),
    (GLOBAL_SCALE, c"GLOBAL_SCALE_FACTOR", "GLOBAL_SCALE_FACTOR"),
];

/// The largest number of bones that move a vertex after `aiProcess_LimitBoneWeights`.
const MOST_WEIGHTS: usize = 4;

/// The first of these flags that is no step of this library, if any.
pub(crate) fn foreign(flags: u32) -> Option<&'static str> {
    FOREIGN
        .iter()
        .find(|(flag, _)| flags & flag != 0)
        .map(|(_, name)| *name)
}

/// The work on this scene that only the system's Assimp can do, if any.
pub(crate) fn foreign_for(flags: u32, properties: &Properties, scene: &Scene) -> Option<&'static str> {
    let setting = SETTINGS
        .iter()
        .find(|(flag, name, _)| flags & flag != 0 && properties.has_number(name))
        .map(|(_, _, name)| *name);
    let too_many_weights =
        || (flags & LIMIT_BONE_WEIGHTS != 0 && has_many_weights(scene)).then_some("aiProcess_LimitBoneWeights");
    foreign(flags).or(setting).or_else(too_many_weights)
}

fn has_many_weights(scene: &Scene) -> bool {
    scene.meshes.iter().any(|mesh| {
        let mut counts = vec![0; mesh.vertices.len()];
        for weight in mesh.bones.iter().flat_map(|bone| &bone.weights) {
            counts[weight.vertex_id as usize] += 1;
        }
        counts.iter().any(|&count| count > MOST_WEIGHTS)
    })
}

/// Whether all of these flags are compatible with each other.
pub(crate) fn validate(flags: u32) -> bool {
    let both = |left, right| flags & left != 0 && flags & right != 0;
    !both(GEN_NORMALS, GEN_SMOOTH_NORMALS) && !both(OPTIMIZE_GRAPH, PRE_TRANSFORM_VERTICES)
}

/// Runs the steps in Assimp's order.
pub(crate) fn run(scene: &mut Scene, flags: u32) -> Result<(), String> {
    if flags & VALIDATE_DATA_STRUCTURE != 0
        && let Some(violation) = scene.validate().first()
    {
        return Err(format!("Validation failed: {violation}"));
    }
    if flags & FIND_DEGENERATES != 0 {
        scene.find_degenerates();
    }
    if flags & FIND_INVALID_DATA != 0 {
        scene.remove_sizeless_meshes();
        scene.collapse_keys(KeyTolerance::default());
    }
    if flags & JOIN_IDENTICAL_VERTICES != 0 {
        scene.join_identical_vertices();
    }
    if flags & DEBONE != 0 {
        scene.debone();
    }
    Ok(())
}

/// The value of `aiScene::mFlags` after these steps.
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
    fn presets_are_run_here_and_other_steps_by_the_system() {
        // aiProcessPreset_TargetRealtime_MaxQuality | aiProcess_Debone, and aiProcess_ConvertToLeftHanded.
        assert_eq!(foreign(0x37_9ecb | DEBONE), None);
        assert_eq!(foreign(0x180_0004), Some("aiProcess_MakeLeftHanded"));
        assert!(validate(0x37_9ecb | DEBONE));
        assert!(!validate(GEN_NORMALS | GEN_SMOOTH_NORMALS));
    }

    #[test]
    fn settings_of_steps_are_for_the_system() {
        let mut properties = Properties::default();
        let scene = Scene::default();
        assert_eq!(foreign_for(DEBONE, &properties, &scene), None);
        properties.floats.insert(c"PP_DB_THRESHOLD".into(), 0.5);
        assert_eq!(foreign_for(DEBONE, &properties, &scene), Some("PP_DB_THRESHOLD"));
        assert_eq!(foreign_for(FIND_INVALID_DATA, &properties, &scene), None);
    }
}
