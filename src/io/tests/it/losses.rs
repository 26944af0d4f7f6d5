//! The ledger of losses: the test writes each kind of data in each format, reads the file back, and looks for the data.

use std::fs;
use std::sync::Arc;

use mocap::bvh::{BvhOptions, Channels};
use mocap::fbx::{FbxOptions, FbxTextures};
use mocap::glam::{Mat4, Quat, Vec3};
use mocap::scene::report::{DataKind, DataLoss};
use mocap::scene::{AnalogChannel, Channel, Event, Face, ForcePlate, Keys, MorphTarget, Node, NodeId, Recording};
use mocap::{Carriage, Code, Conversion, Exporter, Format, FormatInfo, Importer, Pose, Scene, SkeletonMesh};

const DOCUMENT: &str = "../../docs/losses.md";

pub(crate) fn written() -> Vec<&'static FormatInfo> {
    FormatInfo::ALL.iter().filter(|row| row.writes()).collect()
}

/// A figure that moves, in metres.
pub(crate) fn figure() -> Scene {
    let importer = Importer::new().skeleton_mesh(SkeletonMesh::None);
    let mut scene = importer.import("../../fixtures/real/cmu_short.bvh").unwrap();
    Conversion::new().apply(&mut scene).unwrap();
    scene
}

/// A skinned mesh with a texture.
fn character() -> Scene {
    let importer = Importer::new().skeleton_mesh(SkeletonMesh::Own).gltf_meshes(true);
    let mut scene = importer.import("../../fixtures/made/two_bones_textured.gltf").unwrap();
    scene.original = None;
    scene
}

pub(crate) fn channel_of<'a>(scene: &'a mut Scene, joint: &str) -> &'a mut Channel {
    let node = scene.find_node(joint);
    let mut channels = scene.animations[0].channels.iter_mut();
    channels.find(|channel| channel.node == node).unwrap()
}

/// Adds an animated expression.
fn add_face(scene: &mut Scene) {
    let end = scene.animations[0].duration;
    let id = NodeId::new(scene.nodes.len());
    scene.nodes.push(Node {
        name: "happy".to_owned(),
        parent: Some(NodeId(0)),
        transform: Mat4::IDENTITY,
        face: Some(Face::Preset("happy".to_owned())),
        ..Node::default()
    });
    scene.animations[0].channels.push(Channel {
        node_name: "happy".to_owned(),
        node: Some(id),
        position_keys: Keys::at_ticks(vec![Vec3::ZERO, Vec3::X], vec![0.0, end]),
        rotation_keys: Keys::constant(mocap::glam::Quat::IDENTITY),
        scaling_keys: Keys::constant(Vec3::ONE),
    });
}

/// A scene with data of a kind, and the number of items.
fn planted(kind: DataKind) -> (Scene, u64) {
    let mut scene = figure();
    let end = scene.animations[0].duration;
    let count = match kind {
        DataKind::Clips => {
            let mut second = scene.animations[0].clone();
            "second".clone_into(&mut second.name);
            scene.animations.push(second);
            2
        }
        DataKind::MovingJoints => {
            let moves = |channel: &&Channel| channel.rotation_keys.len() > 1 || channel.position_keys.len() > 1;
            scene.animations[0].channels.iter().filter(moves).count()
        }
        DataKind::ScaleCurves => {
            let keys = Keys::at_ticks(vec![Vec3::ONE, Vec3::splat(2.0)], vec![0.0, end]);
            channel_of(&mut scene, "LeftHand").scaling_keys = keys;
            1
        }
        DataKind::PositionCurves => {
            let channel = channel_of(&mut scene, "LeftHandIndex1");
            let offset = channel.position_keys.values[0];
            channel.position_keys = Keys::at_ticks(vec![offset, 2.0 * offset], vec![0.0, end]);
            1
        }
        DataKind::RestScales => {
            let arm = scene.find_node("LeftForeArm").unwrap().index();
            scene.nodes[arm].transform *= Mat4::from_scale(Vec3::splat(2.0));
            channel_of(&mut scene, "LeftForeArm").scaling_keys = Keys::constant(Vec3::splat(2.0));
            1
        }
        // Data that the file states.
        DataKind::Units => {
            scene.metadata.format = Some(Format::Fbx);
            scene.metadata.assumptions.clear();
            1
        }
        DataKind::FaceCurves => {
            add_face(&mut scene);
            1
        }
        DataKind::MarkerGaps => {
            let text = "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\t\
                        OrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n10\t10\t3\t2\tmm\t10\t1\t3\nFrame#\tTime\tA\t\t\tB\n\
                        \t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n1\t0\t1\t2\t3\t4\t5\t6\n2\t0.1\t1\t2\t4\t\t\t\n3\t0.2\t1\t2\t5\t4\t5\t8\n";
            scene = Importer::new().read(text.as_bytes(), "a.trc").unwrap();
            Conversion::new().apply(&mut scene).unwrap();
            1
        }
        DataKind::Meshes | DataKind::Skins | DataKind::UvSets | DataKind::Materials | DataKind::Textures => {
            scene = character();
            1
        }
        DataKind::MorphTargets => {
            scene = character();
            scene.meshes[0].morph_targets.push(MorphTarget {
                name: "smile".to_owned(),
                vertex_ids: vec![0],
                offsets: vec![Vec3::X],
                normal_offsets: vec![Vec3::ZERO],
                ..MorphTarget::default()
            });
            1
        }
        DataKind::Events | DataKind::AnalogChannels | DataKind::ForcePlates => {
            scene.metadata.recorded = Some(Arc::new(Recording {
                events: vec![Event::default(); 2],
                channels: vec![AnalogChannel::default(); 2],
                plates: vec![ForcePlate::default(); 2],
                ..Recording::default()
            }));
            2
        }
        // Data that a reader skipped.
        _ => {
            scene.lose(kind, 2);
            2
        }
    };
    (scene, count as u64)
}

/// The number of items of a kind in a file: in its scene, or outside the scene.
fn found(kind: DataKind, scene: &Scene) -> u64 {
    let beside = scene.metadata.lost.iter().filter(|loss| loss.kind == kind);
    kind.count(scene) + beside.map(|loss| loss.count).sum::<u64>()
}

/// The length of a forearm in the first frame, relative to the upper arm.
fn forearm(scene: &Scene) -> f32 {
    let joints = Pose::at_tick(scene, 0, 0.0).unwrap().node_to_world;
    let names = ["LeftArm", "LeftForeArm", "LeftHand"];
    let [shoulder, elbow, hand] = names.map(|name| joints[scene.find_node(name).unwrap().index()].w_axis);
    elbow.distance(hand) / shoulder.distance(elbow)
}

/// The distance of a finger joint at the end, relative to the distance at the start.
fn growth(scene: &Scene) -> f32 {
    let [hand, finger] = ["LeftHand", "LeftHandIndex1"].map(|name| scene.find_node(name).unwrap().index());
    let [start, end] = [0.0, scene.animations[0].duration].map(|tick| {
        let joints = Pose::at_tick(scene, 0, tick).unwrap().node_to_world;
        joints[hand].w_axis.distance(joints[finger].w_axis)
    });
    end / start
}

#[test]
fn each_kind_is_in_the_file_or_reported_as_lost() {
    let mut wrong = Vec::new();
    // A kept original file has all of the data.
    let exporter = Exporter::new().fbx(FbxOptions::default().textures(FbxTextures::Embedded));
    let of_time = [DataKind::Frames, DataKind::FrameRates, DataKind::Durations];
    // Other tests check these kinds.
    let kinds = DataKind::ALL.iter().filter(|kind| !of_time.contains(kind));
    for &kind in kinds {
        let (scene, count) = planted(kind);
        let mut formats = 0;
        for row in written() {
            let extension = row.extensions[0];
            let output = match exporter.write(&scene, row.format) {
                Ok(output) => output,
                // Humanoid formats reject other figures, and packed clips reject animated scales.
                Err(error) => {
                    let reasons = [Code::NotHumanoid, Code::Unrepresentable];
                    assert!(
                        reasons.contains(&error.code()),
                        "{} .{extension}: {error}",
                        kind.as_str()
                    );
                    continue;
                }
            };
            formats += 1;
            let lost = output
                .losses
                .iter()
                .find(|loss| loss.kind == kind)
                .map_or(0, |loss| loss.count);
            let told = |code: &mocap::Diagnostic| code.code == Code::NotCarriedOver;
            assert_eq!(
                output.warnings.iter().any(told),
                !output.losses.is_empty(),
                "{extension}"
            );
            let bytes = output.files.last().unwrap().bytes().into_owned();
            let importer = Importer::new().skeleton_mesh(SkeletonMesh::Own).gltf_meshes(true);
            let again = importer.read(&bytes, format!("scene.{extension}")).unwrap();
            let there = found(kind, &again);
            let is_right = match row.carriage(kind) {
                Carriage::Kept if kind == DataKind::Clips && row.has_one_clip => (there, lost) == (1, count - 1),
                // Rounding may make a joint constant.
                Carriage::Kept if row.is_packed => there > 0 && lost == 0,
                Carriage::Kept => (there, lost) == (count, 0),
                Carriage::Converted if kind == DataKind::ScaleCurves => {
                    lost == 0 && (growth(&again) - 2.0).abs() < 1e-3
                }
                // A VMD has the values of another body.
                Carriage::Converted if kind == DataKind::RestScales && row.format != Format::Vmd => {
                    lost == 0 && (forearm(&again) - forearm(&scene)).abs() < 1e-3 * forearm(&scene)
                }
                Carriage::Converted if kind == DataKind::RestScales => lost == 0,
                // The root of a VMD has a parent joint.
                Carriage::OfRoot => there <= 1 && lost == count,
                Carriage::Converted if kind == DataKind::PositionCurves => {
                    lost == 0 && (growth(&again) - growth(&scene)).abs() < 1e-3
                }
                // Formats with a fixed set of bones lose other joints.
                Carriage::Converted if ["vrma", "vmd"].contains(&extension) => there > 0 && there + lost <= count,
                Carriage::Converted => lost == 0 && there > 0,
                // This scene has an expression. `faces` tests morph targets.
                Carriage::OfTargets => (there, lost) == (0, count),
                Carriage::AtFrames => unreachable!("of time alone"),
                Carriage::PassedThrough | Carriage::Lost => (there, lost) == (0, count),
            };
            if !is_right {
                let word = row.carriage(kind).as_str();
                wrong.push(format!(
                    "{} .{extension}: {word}: {there} found, {lost} lost of {count}",
                    kind.as_str()
                ));
            }
        }
        assert!(formats >= 5, "{}: {formats}", kind.as_str());
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Another program may add a texture to a mesh, so the texture coordinates of the mesh are data.
#[test]
fn texture_coordinates_are_kept_without_a_texture() {
    let mut scene = character();
    scene.textures.clear();
    for surface in scene
        .materials
        .iter_mut()
        .filter_map(|material| material.surface.as_mut())
    {
        surface.texture = None;
    }
    let coords = scene.meshes[0].texture_coords.clone();
    assert!(coords.iter().any(|place| *place != coords[0]));
    for format in [Format::Fbx, Format::Gltf, Format::Usd] {
        let written = Exporter::new().write(&scene, format).unwrap();
        assert_eq!(written.losses, [], "{format:?}");
        let bytes = written.into_bytes().unwrap();
        let importer = Importer::new().gltf_meshes(true).hash(false);
        let again = importer.format(format).read(&bytes, "plain").unwrap();
        let found = &again.meshes[0].texture_coords;
        assert_eq!(found.len(), again.meshes[0].vertices.len(), "{format:?}");
        let is_among = |place: &mocap::glam::Vec2, all: &[mocap::glam::Vec2]| {
            all.iter().any(|other| other.abs_diff_eq(*place, 1e-6))
        };
        assert!(found.iter().all(|place| is_among(place, &coords)), "{format:?}");
        assert!(coords.iter().all(|place| is_among(place, found)), "{format:?}");
        // A format without meshes reports the number of lost meshes.
        let lost = Exporter::new().write(&again, Format::Bvh).unwrap().losses;
        assert!(
            lost.contains(&DataLoss::new(DataKind::UvSets, 1)),
            "{format:?}: {lost:?}"
        );
    }
}

/// A file with a camera, a light, extras and parts of a VRM: glTF keeps them, other formats report them.
#[test]
fn what_is_beside_the_scene_of_a_gltf_is_passed_through_or_reported() {
    let text = fs::read_to_string("../../fixtures/made/two_bones_textured.gltf").unwrap();
    let mut json: serde_json::Value = serde_json::from_str(&text).unwrap();
    json["cameras"] = serde_json::json!([{"type": "orthographic",
        "orthographic": {"xmag": 1.0, "ymag": 1.0, "zfar": 10.0, "znear": 0.1}}]);
    json["extensionsUsed"] = serde_json::json!(["KHR_lights_punctual"]);
    json["extensions"]["KHR_lights_punctual"]["lights"] = serde_json::json!([{"type": "point"}, {"type": "spot"}]);
    json["nodes"][1]["extras"] = serde_json::json!({"stage": "left"});
    json["nodes"][1]["extensions"]["VRMC_node_constraint"] =
        serde_json::json!({"specVersion": "1.0", "constraint": {"rotation": {"source": 0}}});
    json["extensions"]["VRMC_springBone"] = serde_json::json!({"specVersion": "1.0", "springs": [{"joints": []}]});
    json["materials"][0]["extensions"]["VRMC_materials_mtoon"] = serde_json::json!({"specVersion": "1.0"});
    let scene = Importer::new().read(json.to_string().as_bytes(), "hero.gltf").unwrap();
    let of = |extension: &str| Exporter::new().write_as(&scene, format!("hero.{extension}")).unwrap();
    let kept = of("gltf");
    assert!(kept.losses.is_empty(), "{:?}", kept.losses);
    let bytes = kept
        .files
        .iter()
        .find(|file| file.name().ends_with(".gltf"))
        .unwrap()
        .bytes()
        .into_owned();
    let kept: serde_json::Value = serde_json::from_slice(&bytes).unwrap();
    for pointer in [
        "/cameras",
        "/extensions",
        "/nodes/1/extras",
        "/nodes/1/extensions",
        "/materials",
    ] {
        assert_eq!(kept.pointer(pointer), json.pointer(pointer), "{pointer}");
    }
    for extension in ["bvh", "fbx", "usda", "trc", "mclip"] {
        let losses = of(extension).losses;
        let lost = [
            (DataKind::Meshes, 1),
            (DataKind::Skins, 1),
            (DataKind::UvSets, 1),
            (DataKind::Materials, 1),
            (DataKind::Textures, 1),
            (DataKind::Springs, 1),
            (DataKind::Constraints, 1),
            (DataKind::CharacterSettings, 1),
            (DataKind::Cameras, 1),
            (DataKind::Lights, 2),
            (DataKind::Extras, 1),
        ];
        let mut expected: Vec<DataLoss> = lost.map(|(kind, count)| DataLoss::new(kind, count)).to_vec();
        if extension == "bvh" {
            expected.insert(0, DataLoss::new(DataKind::Units, 1));
        }
        assert_eq!(losses, expected, "{extension}");
    }
    // The file lists the lost data.
    let fbx = of("fbx").into_bytes().unwrap();
    let record = FormatInfo::provenance(&fbx).unwrap();
    assert_eq!(record.losses.len(), 11);
}

/// The factors of a material are in every format with meshes. Its other textures are reported.
#[test]
fn factors_of_a_material_are_kept_and_its_other_textures_reported() {
    let text = fs::read_to_string("../../fixtures/made/two_bones_textured.gltf").unwrap();
    let mut json: serde_json::Value = serde_json::from_str(&text).unwrap();
    let material = &mut json["materials"][0];
    material["pbrMetallicRoughness"]["metallicFactor"] = 0.7.into();
    material["pbrMetallicRoughness"]["roughnessFactor"] = 0.3.into();
    material["emissiveFactor"] = serde_json::json!([0.5, 0.25, 0.0]);
    material["normalTexture"] = serde_json::json!({"index": 0});
    material["occlusionTexture"] = serde_json::json!({"index": 0});
    let importer = Importer::new().gltf_meshes(true).hash(false);
    let mut scene = importer.read(json.to_string().as_bytes(), "hero.gltf").unwrap();
    scene.original = None;
    for extension in ["fbx", "usda", "glb"] {
        let written = Exporter::new().write_as(&scene, format!("hero.{extension}")).unwrap();
        let maps = written.losses.iter().find(|loss| loss.kind == DataKind::SurfaceMaps);
        assert_eq!(maps.map(|loss| loss.count), Some(2), "{extension}");
        let main = written.files.last().unwrap().bytes().into_owned();
        let read = importer.read(&main, format!("hero.{extension}")).unwrap();
        let surface = read.materials[0].surface.unwrap();
        assert!((surface.metallic - 0.7).abs() < 1e-4, "{extension}: {surface:?}");
        assert!((surface.roughness - 0.3).abs() < 1e-4, "{extension}: {surface:?}");
        let emissive = mocap::glam::Vec3::new(0.5, 0.25, 0.0);
        assert!(surface.emissive.abs_diff_eq(emissive, 1e-4), "{extension}: {surface:?}");
    }
    // A factor multiplies its texture, so the factor alone has no meaning.
    json["materials"][0]["pbrMetallicRoughness"]["metallicRoughnessTexture"] = serde_json::json!({"index": 0});
    let scene = importer.read(json.to_string().as_bytes(), "hero.gltf").unwrap();
    assert_eq!(scene.materials[0].surface.unwrap().metallic, 0.0);
}

/// `MOCAP_WRITE=1` writes the table.
#[test]
fn the_table_of_losses_is_that_of_the_rows() {
    let rows = written();
    let mut text = String::from(
        "# What each format keeps\n\n\
         The input may contain data that the output format cannot store. mocap counts each kind of lost data in a warning,\n\
         `not-carried-over`. Some losses can be avoided. For each of these kinds, a separate warning names the remedy. With\n\
         `--strict`, each of these warnings is an error. All losses are also listed as `losses` in:\n\n\
         - the report of a job\n\
         - the provenance record in glTF, VRM animation, FBX and USD files\n\
         - the `.json` file of a BVH, written with `--sidecar`\n\n\
         The table has these values:\n\n\
         | value | meaning |\n\
         |---|---|\n\
         | kept | The data is in the file. |\n\
         | converted | The file stores the data differently. Programs compute the same motion from it. |\n\
         | kept from glTF | The data is kept if the input is glTF or VRM with meshes, and its skeleton is unchanged. Otherwise it is lost. |\n\
         | lost | The data is not in the file. A warning states the count. Packed clips refuse animated scales. |\n\
         | at frames | The file has a pose for each frame. Keys between frames are lost. |\n\
         | one is kept | The file stores one clip. |\n\
         | one rate | All clips in the file have the same frame rate. |\n\
         | root only | The hips and their ancestors keep the data. Their descendants lose it. |\n\
         | morph curves | Curves of morph targets are kept. Expressions of a motion on a VRM character become such curves. Other expressions are lost. |\n\n\
         If you write a binary FBX character as FBX, mocap [keeps the file](fbx.md#characters-in-fbx) and changes only its clips.\n\n\
         MMD always has 30 frames a second.\n\n\
         `MOCAP_WRITE=1 cargo test -p mocap-io losses` writes the table. A test writes each kind of data in each format.\n\n\
         | data |",
    );
    let names = rows.iter().map(|row| format!(" .{} |", row.extensions[0]));
    text += &names.collect::<String>();
    text += "\n|---|";
    text += &"---|".repeat(rows.len());
    for &kind in DataKind::ALL {
        text += &format!("\n| {} |", kind.as_str());
        for row in &rows {
            let word = match row.carriage(kind) {
                Carriage::Kept if kind == DataKind::Clips && row.has_one_clip => "one is kept",
                Carriage::Kept if kind == DataKind::FrameRates && row.has_one_rate => "one rate",
                carriage => carriage.as_str(),
            };
            text += &format!(" {word} |");
        }
    }
    text.push('\n');
    if std::env::var_os("MOCAP_WRITE").is_some() {
        fs::write(DOCUMENT, &text).unwrap();
        return;
    }
    let written = fs::read_to_string(DOCUMENT).unwrap_or_default();
    assert!(
        written == text,
        "MOCAP_WRITE=1 cargo test -p mocap-io losses writes {DOCUMENT}"
    );
}

/// A scene with only one kind of motion: a rotating joint, the root, a scale or a position. `faces.rs` tests curves of
/// faces.
fn still_but_for(kind: &str) -> Scene {
    let mut scene = figure();
    let end = scene.animations[0].duration;
    for channel in &mut scene.animations[0].channels {
        channel.position_keys.values.truncate(1);
        channel.rotation_keys.values.truncate(1);
    }
    let root = scene.animations[0].channels[0].node_name.clone();
    match kind {
        "joint" => {
            let turns = [0.0, 1.0].map(Quat::from_rotation_z).to_vec();
            channel_of(&mut scene, "LeftForeArm").rotation_keys = Keys::at_ticks(turns, vec![0.0, end]);
        }
        "root" | "position" => {
            let channel = channel_of(&mut scene, if kind == "root" { &root } else { "LeftHandIndex1" });
            let offset = channel.position_keys.values[0];
            channel.position_keys = Keys::at_ticks(vec![offset, 2.0 * offset], vec![0.0, end]);
        }
        _ => {
            let scales = vec![Vec3::ONE, Vec3::splat(2.0)];
            channel_of(&mut scene, "LeftForeArm").scaling_keys = Keys::at_ticks(scales, vec![0.0, end]);
        }
    }
    scene
}

/// Every output has motion, even if only one kind of motion is in its source.
#[test]
fn no_output_of_a_moving_source_stands_still() {
    let channels = BvhOptions::new().channels(Channels::Three);
    for (kind, refused) in [
        ("joint", &[][..]),
        ("root", &[]),
        // Packed clips reject animated scales.
        ("scale", &["bvh", "vrma", "mclip", "vmd"]),
        ("position", &["bvh", "vrma", "vmd"]),
    ] {
        let scene = still_but_for(kind);
        let mut refusing = Vec::new();
        for row in written() {
            let exporter = Exporter::new().bvh(channels.clone());
            match exporter.write(&scene, row.format) {
                Ok(output) => {
                    let bytes = output.files.last().unwrap().bytes().into_owned();
                    let again = Importer::new()
                        .read(&bytes, format!("a.{}", row.extensions[0]))
                        .unwrap();
                    assert!(again.moves(), "{kind} .{}", row.extensions[0]);
                }
                Err(error) => {
                    assert_eq!(error.code(), Code::Unrepresentable, "{error}");
                    refusing.push(row.extensions[0]);
                }
            }
        }
        assert_eq!(refusing, refused, "{kind}");
    }
}

/// A file with a static clip and another clip has motion.
#[test]
fn a_format_of_one_clip_takes_one_that_moves() {
    let mut scene = figure();
    let mut still = scene.animations[0].clone();
    for channel in &mut still.channels {
        channel.position_keys.values.truncate(1);
        channel.rotation_keys.values.truncate(1);
    }
    scene.animations.insert(0, still);
    for row in written().into_iter().filter(|row| row.has_one_clip) {
        let output = Exporter::new().write(&scene, row.format).unwrap();
        let bytes = output.files.last().unwrap().bytes().into_owned();
        let again = Importer::new()
            .read(&bytes, format!("a.{}", row.extensions[0]))
            .unwrap();
        assert!(DataKind::MovingJoints.count(&again) > 10, "{}", row.name);
    }
}
