//! FBX, compared with another reader, and a file that is small enough to compute by hand.

mod time;

use std::fs;

use crate::sample::Sample;
use mocap::glam::{DVec3, Vec2, Vec3, Vec4};
use mocap::scene::{AlphaMode, Mesh, NodeId, NodeKind, RotationOrder, Scene, UpAxis};
use mocap::{Code, Importer, Limits, Pose, SkeletonMesh};

fn position(scene: &Scene, pose: &Pose, name: &str) -> Vec3 {
    let node = scene.nodes.iter().position(|node| node.name == name).unwrap();
    pose.position(NodeId::new(node))
}

/// Frames, bones and positions in centimetres, from Assimp 5.2.4 with collapsed pivots. The file has a key in every
/// second frame. Between keys Assimp interpolates linearly, but the file has curves.
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
    let scene = mocap::import("../../fixtures/real/run.fbx").unwrap();
    assert_eq!(scene.warnings, []);
    assert_eq!(scene.metadata.metres_per_unit, Some(1.0));
    let [animation] = scene.animations.as_slice() else {
        panic!("{} animations", scene.animations.len());
    };
    assert_eq!((animation.name.as_str(), animation.ticks_per_second), ("run", 30.0));
    assert_eq!(animation.duration, 20.0);
    // Cameras and lights are skipped.
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

/// Files, frames, and the boxes around the skinned vertices in centimetres: the least and the largest x, y, z. Assimp
/// 5.2.5 gives bones, weights and keys, without post-processing. Each vertex moves by the sum of its bones over the sum
/// of its weights.
const SKINNED: [(&str, f64, [f32; 3], [f32; 3]); 6] = [
    (
        "huesitos",
        0.0,
        [-105.841_47, 0.349_109, -528.864_9],
        [429.930_76, 544.186_3, -207.329_86],
    ),
    (
        "huesitos",
        20.0,
        [-103.499_12, 0.349_109, -425.370_18],
        [354.658_75, 438.652_77, -207.329_88],
    ),
    (
        "huesitos",
        36.0,
        [-107.877_12, -19.807_552, -407.384_9],
        [446.457_03, 345.248_02, 122.478_85],
    ),
    (
        "animation_with_skeleton",
        0.0,
        [-3_642.014_2, -91.666_94, -91.666_29],
        [3_479.131, 91.666_61, 91.670_93],
    ),
    (
        "animation_with_skeleton",
        8.0,
        [-3_642.014_2, -176.503_05, -91.666_29],
        [3_479.131, 361.104_74, 91.670_93],
    ),
    (
        "animation_with_skeleton",
        20.0,
        [-3_642.014_2, -200.076_77, -91.666_29],
        [3_479.131, 438.501_65, 91.670_93],
    ),
];

/// The positions of the vertices of a skinned mesh in a pose.
fn skinned(mesh: &Mesh, pose: &Pose) -> Vec<Vec3> {
    let mut places = vec![DVec3::ZERO; mesh.vertices.len()];
    for bone in &mesh.bones {
        let matrix = (pose.node_to_world[bone.node.index()] * bone.offset_matrix).as_dmat4();
        for tie in &bone.weights {
            let vertex = mesh.vertices[tie.vertex_id as usize].as_dvec3();
            places[tie.vertex_id as usize] += f64::from(tie.weight) * matrix.transform_point3(vertex);
        }
    }
    places.into_iter().map(DVec3::as_vec3).collect()
}

#[test]
fn skinned_vertices_are_where_another_reader_puts_them() {
    for (name, tick, least, most) in SKINNED {
        let scene = mocap::import(format!("../../fixtures/real/{name}.fbx")).unwrap();
        assert_eq!((scene.warnings.as_slice(), scene.meshes.len()), (&[][..], 1), "{name}");
        assert_eq!(scene.nodes[0].meshes, [0], "{name}");
        let places = skinned(&scene.meshes[0], &Pose::at_tick(&scene, 0, tick).unwrap());
        let found = (
            places.iter().copied().reduce(Vec3::min).unwrap(),
            places.iter().copied().reduce(Vec3::max).unwrap(),
        );
        for (found, expected) in [(found.0, least), (found.1, most)] {
            let expected = Vec3::from(expected) * 0.01;
            // The tolerance is for numbers of single precision up to 36 m, multiplied along a chain of eight.
            assert!(
                found.abs_diff_eq(expected, 2e-5),
                "{name} at {tick}: {found}, {expected}"
            );
        }
    }
}

#[test]
fn a_mesh_is_written_to_gltf_with_its_weights() {
    let scene = mocap::import("../../fixtures/real/huesitos.fbx").unwrap();
    let [mesh] = scene.meshes.as_slice() else {
        panic!("{} meshes", scene.meshes.len());
    };
    assert_eq!(mesh.name, "Cylinder");
    let glb = mocap::gltf::GltfOptions::default().write_glb(&scene).unwrap();
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&glb).unwrap();
    let buffer = blob.unwrap();
    let written = document.meshes().next().unwrap();
    assert_eq!(written.name(), Some("Cylinder"));
    let primitive = written.primitives().next().unwrap();
    let reader = primitive.reader(|_| Some(&buffer));
    assert_eq!(reader.read_indices().unwrap().into_u32().count(), mesh.indices.len());
    for weights in reader.read_weights(0).unwrap().into_u8() {
        assert_eq!(weights.iter().map(|&weight| u32::from(weight)).sum::<u32>(), 255);
    }
}

#[test]
fn meshes_are_left_out_where_none_is_asked_for() {
    let none = Importer::new().skeleton_mesh(SkeletonMesh::None);
    let scene = none.import("../../fixtures/real/run.fbx").unwrap();
    assert_eq!((scene.meshes.len(), scene.materials.len()), (0, 0));
    assert_eq!(
        scene.nodes.len(),
        mocap::import("../../fixtures/real/run.fbx").unwrap().nodes.len()
    );
}

#[test]
fn rest_rotations_can_be_inverted() {
    let mut scene = mocap::import("../../fixtures/real/run.fbx").unwrap();
    for node in &mut scene.nodes {
        node.meshes.clear();
    }
    scene.meshes.clear();
    scene.add_skeleton_mesh(SkeletonMesh::Skinned);
    assert_eq!(scene.validate(), []);
    for bone in &scene.meshes[0].bones {
        let rest = Pose::rest(&scene).node_to_world[bone.node.index()];
        let product = bone.offset_matrix * rest;
        assert!(product.abs_diff_eq(mocap::glam::Mat4::IDENTITY, 1e-5), "{}", bone.name);
    }
}

#[test]
fn another_rate_keeps_the_frames() {
    let plain = mocap::import("../../fixtures/real/run.fbx").unwrap();
    let scene = Importer::new()
        .retime(60.0)
        .import("../../fixtures/real/run.fbx")
        .unwrap();
    let (was, is) = (&plain.animations[0], &scene.animations[0]);
    assert_eq!((was.ticks_per_second, was.duration), (30.0, 20.0));
    assert_eq!((is.ticks_per_second, is.duration), (60.0, 20.0));
    assert!(was.channels == is.channels);
}

/// Three bones in centimetres with +Z up. A pre-rotation rotates the second.
const TINY: &str = include_str!("../../../../fixtures/made/tiny.fbx");

fn read(bytes: &[u8]) -> mocap::Result<Scene> {
    Importer::new()
        .format(mocap::Format::Fbx)
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
        // The pre-rotation rotates the link from x to y. After the change of the up axis from z, y lies along -z.
        ("toe", Vec3::new(0.1, 1.0, -0.1)),
    ] {
        let found = position(&scene, &pose, name);
        assert!(found.abs_diff_eq(expected, 1e-6), "{name}: {found}");
    }
    // FBX's Z X Y names the axis of the first rotation first. It is the product Ry Rx Rz.
    assert_eq!(scene.nodes[2].rotation_order, Some(RotationOrder::Yxz));
    let warnings: Vec<Code> = scene.warnings.iter().map(|warning| warning.code).collect();
    assert_eq!(warnings, [Code::NoMotion]);
}

#[test]
fn units_and_axes_of_the_file_can_be_kept() {
    for (stated, metres) in [("1", 0.01), ("2.54", 0.0254), ("100", 1.0)] {
        let unit = "\"UnitScaleFactor\", \"double\", \"Number\", \"\",";
        let text = TINY.replace(&format!("{unit}1"), &format!("{unit}{stated}"));
        let scene = Importer::new()
            .file_units(true)
            .read(text.as_bytes(), "tiny.fbx")
            .unwrap();
        let found = scene.metadata.metres_per_unit.unwrap();
        assert!((found - metres).abs() < 1e-12, "{stated}: {found}");
        assert_eq!(scene.metadata.up, Some(UpAxis::Z));
        let pose = Pose::rest(&scene);
        for (name, expected) in [
            ("hip", Vec3::new(0.0, 0.0, 100.0)),
            ("knee", Vec3::new(10.0, 0.0, 100.0)),
            // The pre-rotation rotates the link from x to y.
            ("toe", Vec3::new(10.0, 10.0, 100.0)),
        ] {
            let found = position(&scene, &pose, name);
            assert!(found.abs_diff_eq(expected, 1e-4), "{name}: {found}");
        }
    }
}

#[test]
fn broken_files_are_refused_with_their_message() {
    let binary = fs::read("../../fixtures/real/run.fbx").unwrap();
    for (bytes, message) in [
        (&b""[..], "tiny.fbx: error[empty-file]: the file is empty"),
        (
            &binary[..binary.len() / 2],
            "tiny.fbx: error[unexpected-end]: the file is cut off inside the section \"Objects\"; expected the section \
             from byte 18218 to byte 612954; found 331696 bytes; help: export or download the file again",
        ),
        (
            // A header without any section.
            &binary[..27],
            "tiny.fbx: error[unexpected-end]: the file is cut off; expected the rest of an FBX file; found 27 bytes; \
             help: export or download the file again",
        ),
        (
            TINY.split_once("\"UnitScaleFactor").unwrap().0.as_bytes(),
            "tiny.fbx:15:5: error[unexpected-end]: the file ends inside the section \"Properties70\"; expected }; found \
             the end of the file; help: the section that begins in line 8 is not closed; the file is cut off or closing \
             braces are missing",
        ),
        (
            &b"1, 2, 3\n".repeat(100),
            "tiny.fbx: error[invalid-fbx]: the file is not FBX; expected \"Kaydara FBX Binary\" or \"; FBX\" at its \
             beginning; found \"1, 2, 3\\n1, 2, 3\\n1,\"; help: check that the extension matches the contents of the file, and that the \
             file is not compressed",
        ),
    ] {
        assert_eq!(read(bytes).unwrap_err().to_string(), message);
    }
}

#[test]
fn a_place_that_is_not_finite_is_told() {
    let far = TINY.replacen("\"A\",10,0,0", "\"A\",1e300,0,0", 1);
    let scene = read(far.as_bytes()).unwrap();
    let warnings: Vec<String> = scene.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(
        warnings[0],
        "the position in the rest pose is not finite, or beyond 1e18, or its scale is below 1e-12; the node was put at its parent; joint \"knee\""
    );
}

#[test]
fn claims_beyond_the_limits_are_refused() {
    let limited = |limits: Limits| {
        let bytes = fs::read("../../fixtures/real/run.fbx").unwrap();
        Importer::new()
            .limits(limits)
            .read(&bytes, "run.fbx")
            .map_err(|error| error.code())
    };
    let limits = Limits::default();
    assert!(limited(limits.max_nodes(68).max_values(10 * 21 * 68)).is_ok());
    assert_eq!(limited(limits.max_nodes(67)), Err(Code::LimitExceeded));
    assert_eq!(limited(limits.max_values(10 * 21 * 68 - 1)), Err(Code::LimitExceeded));
    assert_eq!(limited(limits.max_depth(3)), Err(Code::LimitExceeded));
}

#[test]
fn every_damage_is_an_error_or_a_valid_scene() {
    // In builds with debug assertions, as in these tests, the importer validates its scenes.
    let text = TINY.as_bytes();
    let mut random = Sample::new();
    for position in random.some(0..text.len(), 4) {
        let _ = read(&text[..position]);
        for byte in *b"\0\n \"0-9,{}:\xff" {
            let mut bytes = text.to_vec();
            bytes[position] = byte;
            let _ = read(&bytes);
        }
    }
    // In this long file, the test changes some bytes, spread over the whole file.
    let binary = fs::read("../../fixtures/real/run.fbx").unwrap();
    for position in random.some((0..binary.len()).step_by(binary.len() / 150), 4) {
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
        "walk.bip: error[unreadable-format]: BIP, a format of 3ds Max without a public specification, cannot be read; \
         help: open it in 3ds Max, and export the motion as BVH or FBX"
    );
}

/// A skinned quad whose left half has a plain colour and whose right half has a texture. `texture` describes the image,
/// and `video` has its contents.
pub(crate) fn textured(texture: &str, video: &str) -> String {
    let identity = "1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1";
    format!(
        r#"; FBX 7.4.0 project file
FBXHeaderExtension:  {{
	FBXVersion: 7400
}}
Objects:  {{
	NodeAttribute: 11, "NodeAttribute::hip", "LimbNode" {{
		TypeFlags: "Skeleton"
	}}
	Model: 1, "Model::hip", "LimbNode" {{
		Version: 232
	}}
	Model: 2, "Model::quad", "Mesh" {{
		Version: 232
	}}
	Geometry: 3, "Geometry::quad", "Mesh" {{
		Vertices: *18 {{
			a: 0,0,0,100,0,0,200,0,0,0,100,0,100,100,0,200,100,0
		}}
		PolygonVertexIndex: *8 {{
			a: 0,1,4,-4,1,2,5,-5
		}}
		LayerElementUV: 0 {{
			Name: "map"
			MappingInformationType: "ByPolygonVertex"
			ReferenceInformationType: "Direct"
			UV: *16 {{
				a: 0,0,0.5,0,0.5,1,0,1,0.5,0,1,0,1,1,0.5,1
			}}
		}}
		LayerElementMaterial: 0 {{
			MappingInformationType: "ByPolygon"
			ReferenceInformationType: "IndexToDirect"
			Materials: *2 {{
				a: 0,1
			}}
		}}
		Layer: 0 {{
			LayerElement:  {{
				Type: "LayerElementUV"
				TypedIndex: 0
			}}
			LayerElement:  {{
				Type: "LayerElementMaterial"
				TypedIndex: 0
			}}
		}}
	}}
	Deformer: 4, "Deformer::", "Skin" {{
		Version: 101
	}}
	Deformer: 5, "SubDeformer::", "Cluster" {{
		Indexes: *6 {{
			a: 0,1,2,3,4,5
		}}
		Weights: *6 {{
			a: 1,1,1,1,1,1
		}}
		Transform: *16 {{
			a: {identity}
		}}
		TransformLink: *16 {{
			a: {identity}
		}}
	}}
	Material: 6, "Material::plain", "" {{
		ShadingModel: "phong"
		Properties70:  {{
			P: "DiffuseColor", "Color", "", "A",1,0.5,0
			P: "DiffuseFactor", "Number", "", "A",1
			P: "Opacity", "double", "Number", "",0.25
			P: "TransparencyFactor", "Number", "", "A",0.75
			P: "TransparentColor", "Color", "", "A",1,1,1
		}}
	}}
	Material: 7, "Material::painted", "" {{
		ShadingModel: "phong"
		Properties70:  {{
			P: "DiffuseColor", "Color", "", "A",0.2,0.2,0.2
		}}
	}}
	Texture: 8, "Texture::paint", "" {{
		{texture}
	}}
	Video: 9, "Video::paint", "Clip" {{
		{texture}
		{video}
	}}
	Texture: 10, "Texture::bumps", "" {{
		RelativeFilename: "bumps.png"
	}}
}}
Connections:  {{
	C: "OO",1,0
	C: "OO",2,0
	C: "OO",11,1
	C: "OO",3,2
	C: "OO",4,3
	C: "OO",5,4
	C: "OO",1,5
	C: "OO",6,2
	C: "OO",7,2
	C: "OP",8,7, "DiffuseColor"
	C: "OP",10,7, "NormalMap"
	C: "OO",9,8
}}
"#
    )
}

/// One grey pixel.
fn png() -> Vec<u8> {
    use base64::Engine;
    let text = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGNoAAAAggCBd81ytgAAAABJRU5ErkJggg==";
    base64::engine::general_purpose::STANDARD.decode(text).unwrap()
}

/// An untrusted file must not choose which pictures of a disk an output contains.
#[test]
fn a_texture_outside_of_the_folder_is_not_opened() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("in/quad.fbx");
    fs::create_dir(folder.path().join("in")).unwrap();
    let outside = folder.path().join("paint.png");
    fs::write(&outside, png()).unwrap();
    for named in [
        "..\\\\paint.png",
        "../paint.png",
        "..\\\\in\\\\..\\\\paint.png",
        &outside.display().to_string(),
    ] {
        fs::write(&path, textured(&format!("RelativeFilename: \"{named}\""), "")).unwrap();
        assert_eq!(mocap::import(&path).unwrap().textures, [], "{named}");
    }
}

#[test]
fn a_material_has_its_colour_and_its_texture() {
    use base64::Engine;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("quad.fbx");
    let embedded = format!(
        "Content: , \"{}\"",
        base64::engine::general_purpose::STANDARD.encode(png())
    );
    let places: [(&str, &str, &str); 4] = [
        ("RelativeFilename: \"none\\\\paint.png\"", &embedded, ""),
        ("RelativeFilename: \"paint.png\"", "", "paint.png"),
        (
            "RelativeFilename: \"C:\\\\of\\\\its\\\\maker\\\\paint.png\"",
            "",
            "quad.fbm/paint.png",
        ),
        ("RelativeFilename: \"..\\\\paint.png\"", "", "textures/paint.png"),
    ];
    for (texture, video, file) in places {
        fs::write(&path, textured(texture, video)).unwrap();
        if !file.is_empty() {
            let file = folder.path().join(file);
            fs::create_dir_all(file.parent().unwrap()).unwrap();
            fs::write(&file, png()).unwrap();
        }
        let scene = mocap::import(&path).unwrap();
        assert_eq!(
            scene.warnings.iter().map(|warning| warning.code).collect::<Vec<_>>(),
            [Code::NoMotion],
            "{file}"
        );
        if !file.is_empty() {
            fs::remove_file(folder.path().join(file)).unwrap();
        }
        let [texture] = scene.textures.as_slice() else {
            panic!("{} textures", scene.textures.len());
        };
        assert_eq!((texture.media_type.as_str(), &texture.bytes), ("image/png", &png()));
        let surface = |name: &str| {
            let material = scene.materials.iter().find(|material| material.name == name).unwrap();
            material.surface.unwrap()
        };
        let (plain, painted) = (surface("plain"), surface("painted"));
        // The sRGB value 0.5 is 0.214 in linear light.
        assert!(
            plain.base_color.abs_diff_eq(Vec4::new(1.0, 0.214_041, 0.0, 0.25), 1e-5),
            "{plain:?}"
        );
        assert_eq!((plain.texture, plain.alpha), (None, AlphaMode::Blend));
        assert_eq!((painted.base_color, painted.texture), (Vec4::ONE, Some(0)));
        // A mesh for each material, with texture coordinates from the top.
        let [left, right] = scene.meshes.as_slice() else {
            panic!("{} meshes", scene.meshes.len());
        };
        assert_eq!(
            (
                left.vertices.len(),
                left.texture_coords.len(),
                right.texture_coords.len()
            ),
            (4, 4, 4)
        );
        for (vertex, place) in right.vertices.iter().zip(&right.texture_coords) {
            let expected = Vec2::new(vertex.x / 2.0, 1.0 - vertex.y);
            assert!(place.abs_diff_eq(expected, 1e-6), "{vertex} is at {place}");
        }
        let said = scene
            .metadata
            .assumptions
            .iter()
            .map(ToString::to_string)
            .collect::<Vec<_>>();
        assert!(
            said.iter()
                .any(|text| text.contains("mocap did not read the textures of NormalMap")),
            "{said:?}"
        );

        let glb = mocap::gltf::GltfOptions::default().write_glb(&scene).unwrap();
        let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&glb).unwrap();
        let buffer = blob.unwrap();
        let image = document.images().next().unwrap();
        let gltf::image::Source::View { view, mime_type } = image.source() else {
            panic!("the image is not in the buffer");
        };
        assert_eq!(
            (mime_type, &buffer[view.offset()..view.offset() + view.length()]),
            ("image/png", &*png())
        );
        let painted = document
            .materials()
            .find(|material| material.name() == Some("painted"))
            .unwrap();
        assert!(painted.pbr_metallic_roughness().base_color_texture().is_some());
        let right = document.meshes().nth(1).unwrap();
        let primitive = right.primitives().next().unwrap();
        let coords = primitive
            .reader(|_| Some(&buffer))
            .read_tex_coords(0)
            .unwrap()
            .into_f32();
        assert_eq!(coords.count(), 4);
    }
}

#[test]
fn a_texture_that_is_missing_is_told() {
    for (texture, file, bytes, expected) in [
        (
            "gone.png",
            "other.png",
            png(),
            "the texture \"gone.png\" is not in the file and not near it",
        ),
        (
            "paint.tga",
            "paint.tga",
            b"0123".to_vec(),
            "the texture \"paint.tga\" is neither PNG nor JPEG",
        ),
        ("../paint.png", "", png(), "is not in the file"),
    ] {
        let outer = tempfile::tempdir().unwrap();
        let folder = outer.path().join("in");
        fs::create_dir(&folder).unwrap();
        // A file in the parent folder must not be read.
        fs::write(outer.path().join("paint.png"), png()).unwrap();
        if !file.is_empty() {
            fs::write(folder.join(file), bytes).unwrap();
        }
        let path = folder.join("quad.fbx");
        fs::write(&path, textured(&format!("RelativeFilename: \"{texture}\""), "")).unwrap();
        let scene = mocap::import(&path).unwrap();
        let warning = scene
            .warnings
            .iter()
            .find(|warning| warning.code == Code::IgnoredMesh)
            .unwrap();
        assert!(warning.message.contains(expected), "{warning}");
        assert_eq!((scene.textures.len(), scene.meshes.len()), (0, 2));
        assert_eq!(scene.validate(), []);
    }
}

/// The colour is stated as in ozz-animation's file: a `DiffuseColor` of 0.5 and a `DiffuseFactor` of 0.8.
#[test]
fn a_character_keeps_its_colour() {
    let scene = mocap::import("../../fixtures/characters/arnaud.fbx").unwrap();
    let [material] = scene.materials.as_slice() else {
        panic!("{} materials", scene.materials.len());
    };
    assert_eq!(material.name, "lambert2");
    let color = material.surface.unwrap().base_color;
    assert!(
        color.abs_diff_eq(Vec4::new(0.132_868, 0.132_868, 0.132_868, 1.0), 1e-5),
        "{color}"
    );
}
