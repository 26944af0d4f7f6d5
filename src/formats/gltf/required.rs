//! The extensions that a file requires, and which of them affect motion.

use mocap_scene::error::{Code, Diagnostic};

use super::compression::{EXT, KHR};
use super::invalid::invalid;
use crate::Failure;

/// Prefixes of the names of extensions that do not affect nodes and animations. These extensions affect data that the
/// reader does not need: surfaces, lights, images, geometry, the rules of an avatar.
const NOT_OF_MOTION: &[&str] = &[
    "KHR_materials_",
    "KHR_texture_",
    "KHR_lights_",
    "KHR_mesh_quantization",
    "KHR_gaussian_splatting",
    "KHR_xmp",
    "KHR_technique",
    "KHR_node_",
    "KHR_audio",
    "KHR_physics",
    "KHR_interactivity",
    "EXT_texture_",
    "EXT_lights_",
    "EXT_mesh_",
    "EXT_primitive_",
    "EXT_structural_metadata",
    "EXT_instance_features",
    "MSFT_texture_dds",
    "MSFT_packing_",
    "MSFT_audio",
    "ADOBE_materials_",
    "AGI_articulations",
    "CESIUM_",
    "FB_geometry_metadata",
    "MPEG_",
    "NV_materials_mdl",
    "GRIFFEL_",
    "VRM",
];

/// The supported extensions.
const READ: &[&str] = &[EXT, KHR, "KHR_animation_pointer"];

const DRACO: &str = "KHR_draco_mesh_compression";

/// Warnings about required extensions that motion does not need.
///
/// # Errors
/// A required extension is unknown and may change the motion.
pub(super) fn check(required: &[String]) -> Result<Vec<Diagnostic>, Failure> {
    let mut warnings = Vec::new();
    for (index, name) in required.iter().enumerate() {
        let pointer = format!("/extensionsRequired/{index}");
        if name == DRACO {
            let message =
                "the meshes are compressed with Draco, which is not read here; skeleton and motion are complete";
            let help = "to read the meshes too, write the file without Draco: gltf-transform copy IN OUT";
            warnings.push(
                Diagnostic::new(Code::UnreadExtension, message)
                    .at_pointer(pointer)
                    .help(help),
            );
            continue;
        }
        let is_harmless = NOT_OF_MOTION.iter().any(|start| name.starts_with(start));
        if !is_harmless && !READ.contains(&name.as_str()) {
            return Err(
                invalid(pointer, "the file requires an extension that mocap cannot read")
                    .expected_found(
                        "extensions that do not change nodes or animations",
                        format!("\"{name}\""),
                    )
                    .help("write the file without this extension; if the extension does not affect motion, move its name from extensionsRequired to extensionsUsed")
                    .into(),
            );
        }
    }
    Ok(warnings)
}
