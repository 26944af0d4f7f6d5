//! FBX: against another reader, and a file small enough to work out by hand.

#![cfg(feature = "fbx")]
#![allow(clippy::unwrap_used, reason = "a failed assumption in a test is the test's failure")]

use std::fs;

use mocap::glam::Vec3;
use mocap::pose::Pose;
use mocap::scene::{NodeId, NodeKind, RotationOrder, Scene};
use mocap::{Code, Importer, Limits, SkeletonMesh};

fn position(scene: &Scene, pose: &Pose, name: &str) -> Vec3 {
    let node = scene.nodes.iter().position(|node| node.name == name).unwrap();
    pose.position(NodeId::new(node))
}

/// Frame, bone and place in centimetres, as Assimp 5.2.4 has it with its pivots collapsed. The file has a key every
/// second frame; between keys Assimp goes straight, where the curves of the file bend.
const RUN: [(f64, &str, [f32; 3]); 12] = [
    (0.0, "Hips", [1.832_059, 94.877_61, -4.481_497]),
    (0.0, "Head", [5.379_74, 150.692_92, 13.816_896]),
    (0.0, "Bip01LFinger1Nub", [24.124_544, 91.883_11, 22.643_93]),
    (0.0, "RightHand", [-23.293_716, 109.159_67, 13.780_604]),
    (10.0, "Hips", [-0.141_423, 94.902_56, 163.564_07]),
    (10.0, "Head", [-0.965_31, 150.161_1, 184.027_59]),
    (10.0, "Bip01LFinger1Nub", [19.567_392, 104.007_01, 196.314_24]),
    (10.0, "LeftFoot", [1.604_592, 61.796_555, 136.123_44]),
    (20.0, "Hips", [1.832_059, 94.877_61, 330.149_93]),
    (20.0, "Head", [5.379_74, 150.692_92, 348.448_33]),
    (20.0, "RightHand", [-23.293_715, 109.159_65, 348.412_05]),
    (20.0, "LeftFoot", [4.517_172, 13.928_787, 326.661_56]),
];

#[test]
fn bones_stand_where_another_reader_puts_them() {
    let scene = mocap::import("fixtures/real/run.fbx").unwrap();
    assert_eq!(scene.warnings, []);
    assert_eq!(scene.metadata.metres_per_unit, Some(1.0));
    let [animation] = scene.animations.as_slice() else {
        panic!("{} animations", scene.animations.len());
    };
    assert_eq!((animation.name.as_str(), animation.ticks_per_second), ("run", 30.0));
    assert_eq!(animation.duration, 20.0);
    // Cameras, lights and the skinned mesh are left out.
    let bones = scene.nodes.iter().filter(|node| node.kind == NodeKind::Joint).count();
    assert_eq!((bones, scene.nodes.len()), (67, 68));
    for (tick, name, centimetres) in RUN {
        let pose = Pose::at_tick(&scene, 0, tick).unwrap();
        let found = position(&scene, &pose, name);
        let expected = Vec3::from(centimetres) * 0.01;
        assert!(
            found.abs_diff_eq(expected, 2e-6),
            "{name} at {tick}: {found}, {expected}"
        );
    }
}

#[test]
fn rest_rotations_can_be_inverted() {
    let skinned = Importer::new().skeleton_mesh(SkeletonMesh::Skinned);
    let scene = skinned.import("fixtures/real/run.fbx").unwrap();
    assert_eq!(mocap::process::validate(&scene), []);
    for bone in &scene.meshes[0].bones {
        let rest = Pose::rest(&scene).node_to_world[bone.node.index()];
        let product = bone.offset_matrix * rest;
        assert!(product.abs_diff_eq(mocap::glam::Mat4::IDENTITY, 1e-5), "{}", bone.name);
    }
}

#[test]
fn the_frame_rate_can_be_chosen() {
    let scene = Importer::new()
        .frame_rate(60.0)
        .import("fixtures/real/run.fbx")
        .unwrap();
    let animation = &scene.animations[0];
    assert_eq!((animation.ticks_per_second, animation.duration), (60.0, 40.0));
    let pose = Pose::at_tick(&scene, 0, 20.0).unwrap();
    let hips = position(&scene, &pose, "Hips");
    assert!(hips.abs_diff_eq(Vec3::from(RUN[4].2) * 0.01, 2e-6), "{hips}");
}

/// Three bones in centimetres with +Z up; the second is turned by a pre-rotation.
const TINY: &str = r#"; FBX 7.4.0 project file
FBXHeaderExtension:  {
	FBXHeaderVersion: 1003
	FBXVersion: 7400
}
GlobalSettings:  {
	Version: 1000
	Properties70:  {
		P: "UpAxis", "int", "Integer", "",2
		P: "UpAxisSign", "int", "Integer", "",1
		P: "FrontAxis", "int", "Integer", "",1
		P: "FrontAxisSign", "int", "Integer", "",-1
		P: "CoordAxis", "int", "Integer", "",0
		P: "CoordAxisSign", "int", "Integer", "",1
		P: "UnitScaleFactor", "double", "Number", "",1
	}
}
Objects:  {
	NodeAttribute: 11, "NodeAttribute::hip", "LimbNode" {
		TypeFlags: "Skeleton"
	}
	NodeAttribute: 12, "NodeAttribute::knee", "LimbNode" {
		TypeFlags: "Skeleton"
	}
	NodeAttribute: 13, "NodeAttribute::toe", "LimbNode" {
		TypeFlags: "Skeleton"
	}
	Model: 1, "Model::hip", "LimbNode" {
		Version: 232
		Properties70:  {
			P: "Lcl Translation", "Lcl Translation", "", "A",0,0,100
		}
	}
	Model: 2, "Model::knee", "LimbNode" {
		Version: 232
		Properties70:  {
			P: "RotationOrder", "enum", "", "",4
			P: "RotationActive", "bool", "", "",1
			P: "PreRotation", "Vector3D", "Vector", "",0,0,90
			P: "Lcl Translation", "Lcl Translation", "", "A",10,0,0
		}
	}
	Model: 3, "Model::toe", "LimbNode" {
		Version: 232
		Properties70:  {
			P: "Lcl Translation", "Lcl Translation", "", "A",10,0,0
		}
	}
}
Connections:  {
	C: "OO",1,0
	C: "OO",2,1
	C: "OO",3,2
	C: "OO",11,1
	C: "OO",12,2
	C: "OO",13,3
}
"#;

fn read(bytes: &[u8]) -> mocap::Result<Scene> {
    Importer::new()
        .format("fbx")
        .skeleton_mesh(SkeletonMesh::None)
        .read(bytes, "tiny.fbx")
}

#[test]
fn units_axes_and_pre_rotations_are_resolved() {
    let scene = Importer::new().read(TINY.as_bytes(), "named otherwise").unwrap();
    let pose = Pose::rest(&scene);
    for (name, expected) in [
        ("hip", Vec3::new(0.0, 1.0, 0.0)),
        ("knee", Vec3::new(0.1, 1.0, 0.0)),
        // The pre-rotation turns the link from x to y, which lies along -z when z is up no more.
        ("toe", Vec3::new(0.1, 1.0, -0.1)),
    ] {
        let found = position(&scene, &pose, name);
        assert!(found.abs_diff_eq(expected, 1e-6), "{name}: {found}");
    }
    // FBX's Z X Y, the axis that turns first first, is the product Ry Rx Rz.
    assert_eq!(scene.nodes[2].rotation_order, Some(RotationOrder::Yxz));
    let warnings: Vec<Code> = scene.warnings.iter().map(|warning| warning.code).collect();
    assert_eq!(warnings, [Code::NoMotion]);
}

#[test]
fn broken_files_are_refused_with_their_message() {
    let binary = fs::read("fixtures/real/run.fbx").unwrap();
    for (bytes, message) in [
        (&b""[..], "tiny.fbx: error[empty-file]: the file holds nothing"),
        (
            &binary[..binary.len() / 2],
            "tiny.fbx: error[unexpected-end]: the file is cut off",
        ),
        (
            &b"1, 2, 3\n".repeat(100),
            "tiny.fbx: error[invalid-fbx]: the FBX file cannot be read: Not an FBX file",
        ),
    ] {
        assert_eq!(read(bytes).unwrap_err().to_string(), message);
    }
}

#[test]
fn claims_beyond_the_limits_are_refused() {
    let limited = |limits: Limits| {
        let bytes = fs::read("fixtures/real/run.fbx").unwrap();
        Importer::new()
            .limits(limits)
            .read(&bytes, "run.fbx")
            .map_err(|error| error.code())
    };
    let limits = Limits::default();
    assert!(
        limited(Limits {
            max_nodes: 68,
            max_values: 10 * 21 * 68,
            ..limits
        })
        .is_ok()
    );
    assert_eq!(
        limited(Limits {
            max_nodes: 67,
            ..limits
        }),
        Err(Code::LimitExceeded)
    );
    assert_eq!(
        limited(Limits {
            max_values: 10 * 21 * 68 - 1,
            ..limits
        }),
        Err(Code::LimitExceeded)
    );
    assert_eq!(limited(Limits { max_depth: 3, ..limits }), Err(Code::LimitExceeded));
}

#[test]
fn every_damage_is_an_error_or_a_valid_scene() {
    // The importer validates what it returns in builds with debug assertions; these tests are one.
    let text = TINY.as_bytes();
    for position in 0..text.len() {
        let _ = read(&text[..position]);
        for byte in *b"\0\n \"0-9,{}:\xff" {
            let mut bytes = text.to_vec();
            bytes[position] = byte;
            let _ = read(&bytes);
        }
    }
    // A long file: some of its bytes, spread over all of it.
    let binary = fs::read("fixtures/real/run.fbx").unwrap();
    for position in (0..binary.len()).step_by(binary.len() / 150) {
        let _ = read(&binary[..position]);
        let mut bytes = binary.clone();
        bytes[position] ^= 0x55;
        let _ = read(&bytes);
    }
}

#[test]
fn biped_files_are_told_apart() {
    let error = Importer::new().read(&[1, 2, 3, 4], "walk.bip").unwrap_err();
    assert_eq!(
        error.to_string(),
        "walk.bip: error[unreadable-format]: BIP is a format of 3ds Max alone, and is not read here; \
         help: open it in 3ds Max, and export the motion as BVH or FBX"
    );
}
