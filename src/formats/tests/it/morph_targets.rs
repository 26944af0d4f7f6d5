//! Morph targets: how they are read, and that steps change them like vertices.

use mocap::glam::Vec3;
use mocap::scene::{Mesh, UpAxis};
use mocap::{Code, Importer, Scene};

fn character() -> Scene {
    let importer = Importer::new().gltf_meshes(true).morph_targets(true);
    importer.import("../../fixtures/characters/human_vrm0.vrm").unwrap()
}

/// The scene with its targets at weight 1 added to its vertices, as a modelling program bakes them.
fn baked(mut scene: Scene) -> Scene {
    for mesh in &mut scene.meshes {
        for target in std::mem::take(&mut mesh.morph_targets) {
            for (vertex, offset) in std::iter::zip(target.vertex_ids, target.offsets) {
                mesh.vertices[vertex as usize] += offset;
            }
        }
    }
    scene
}

fn size(mesh: &Mesh) -> f32 {
    let length = |vertex: &Vec3| vertex.length();
    mesh.vertices.iter().map(length).fold(0.0, f32::max)
}

#[test]
fn steps_move_targets_as_vertices() {
    type Change = fn(&mut Scene);
    let changes: [(&str, Change); 4] = [
        ("convert_units", |scene| scene.convert_units(0.01, UpAxis::Z)),
        ("set_rest_pose_at", |scene| scene.set_rest_pose_at(0.0)),
        ("join_identical_vertices", Scene::join_identical_vertices),
        ("debone", Scene::debone),
    ];
    for (name, change) in changes {
        let mut with_targets = character();
        let mut plain = baked(with_targets.clone());
        assert!(with_targets != plain);
        change(&mut with_targets);
        change(&mut plain);
        assert_eq!(with_targets.validate(), [], "{name}");
        let moved = baked(with_targets);
        if name == "join_identical_vertices" {
            // The function does not change meshes with targets.
            assert_eq!(moved.meshes.len(), character().meshes.len());
            continue;
        }
        assert_eq!(moved.meshes.len(), plain.meshes.len(), "{name}");
        for (a, b) in std::iter::zip(&moved.meshes, &plain.meshes) {
            let far = std::iter::zip(&a.vertices, &b.vertices).map(|(a, b)| a.distance(*b));
            assert!(far.fold(0.0, f32::max) < 1e-5 * size(b), "{name}");
        }
    }
}

#[test]
fn targets_are_read_where_they_are_asked_for() {
    let scene = character();
    let names: Vec<_> = scene.meshes.iter().flat_map(|mesh| &mesh.morph_targets).collect();
    assert!(names.iter().any(|target| target.name == "mouth_open"));
    assert!(names.iter().all(|target| !target.vertex_ids.is_empty()));
    let without = Importer::new().gltf_meshes(true);
    let without = without.import("../../fixtures/characters/human_vrm0.vrm").unwrap();
    assert!(without.meshes.iter().all(|mesh| mesh.morph_targets.is_empty()));
    let text = serde_json::to_string(&scene.meshes).unwrap();
    assert_eq!(serde_json::from_str::<Vec<Mesh>>(&text).unwrap(), scene.meshes);
}

#[test]
fn a_broken_target_leaves_the_mesh() {
    // A triangle on one node. Its target names a missing accessor, or an accessor of bytes.
    let numbers: Vec<u8> = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, f32::NAN, 0.0, 0.0]
        .iter()
        .flat_map(|number| number.to_le_bytes())
        .collect();
    use base64::Engine;
    let buffer = base64::engine::general_purpose::STANDARD.encode(&numbers);
    let file = |target: &str| {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"nodes":[{{"name":"a","mesh":0}}],"scenes":[{{"nodes":[0]}}],
            "meshes":[{{"extras":{{"targetNames":["up"]}},"primitives":[{{"attributes":{{"POSITION":0}},"targets":[{target}]}}]}}],
            "buffers":[{{"byteLength":48,"uri":"data:application/octet-stream;base64,{buffer}"}}],
            "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":12,"byteLength":36}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"type":"VEC3","count":3}},
            {{"bufferView":1,"componentType":5126,"type":"VEC3","count":3}}]}}"#
        )
    };
    let importer = Importer::new().gltf_meshes(true).morph_targets(true);
    let good = importer
        .read(file(r#"{"POSITION":0}"#).as_bytes(), "triangle.gltf")
        .unwrap();
    let [up] = &good.meshes[0].morph_targets[..] else {
        panic!("{:?}", good.warnings)
    };
    assert_eq!((up.name.as_str(), up.vertex_ids.as_slice()), ("up", &[1, 2][..]));
    assert_eq!(up.offsets, [Vec3::X, Vec3::Y]);
    for target in [r#"{"POSITION":7}"#, r#"{"POSITION":1}"#] {
        let scene = importer.read(file(target).as_bytes(), "triangle.gltf").unwrap();
        assert!(scene.meshes[0].morph_targets.is_empty());
        assert_eq!(scene.meshes[0].vertices.len(), 3, "{target}");
        let told = scene.warnings.iter().find(|warning| warning.code == Code::IgnoredMesh);
        assert!(
            told.unwrap().message.starts_with("its morph targets were dropped"),
            "{:?}",
            scene.warnings
        );
    }
}

/// A triangle with the targets "up" and "down". An animation has these weights at 0, 0.1 and 0.2 s.
fn moving(weights: &[f32], interpolation: &str) -> Scene {
    let corners = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let numbers: Vec<u8> = corners
        .iter()
        .chain(&[0.0, 0.1, 0.2])
        .chain(weights)
        .flat_map(|number| number.to_le_bytes())
        .collect();
    use base64::Engine;
    let buffer = base64::engine::general_purpose::STANDARD.encode(&numbers);
    let (bytes, count) = (4 * weights.len(), weights.len());
    let file = format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{{"name":"a","mesh":0}}],"scenes":[{{"nodes":[0]}}],
        "meshes":[{{"weights":[0.5,0],"extras":{{"targetNames":["up","down"]}},
        "primitives":[{{"attributes":{{"POSITION":0}},"targets":[{{"POSITION":0}},{{"POSITION":0}}]}}]}}],
        "animations":[{{"channels":[{{"sampler":0,"target":{{"node":0,"path":"weights"}}}}],
        "samplers":[{{"input":1,"output":2,"interpolation":"{interpolation}"}}]}},{{"channels":[],"samplers":[]}}],
        "buffers":[{{"byteLength":{},"uri":"data:application/octet-stream;base64,{buffer}"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":12}},
        {{"buffer":0,"byteOffset":48,"byteLength":{bytes}}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"type":"VEC3","count":3}},
        {{"bufferView":1,"componentType":5126,"type":"SCALAR","count":3,"min":[0],"max":[0.2]}},
        {{"bufferView":2,"componentType":5126,"type":"SCALAR","count":{count}}}]}}"#,
        numbers.len()
    );
    let importer = Importer::new().gltf_meshes(true).morph_targets(true);
    importer.read(file.as_bytes(), "triangle.gltf").unwrap()
}

/// The weights of both targets at a time, in seconds, of the first animation.
fn weights_at(scene: &Scene, seconds: f64) -> [f32; 2] {
    let tick = seconds * scene.animations[0].ticks_per_second;
    let targets = &scene.meshes[0].morph_targets;
    [0, 1].map(|target| targets[target].weight_keys[0].sample(tick).unwrap())
}

#[test]
fn the_motion_of_targets_is_read() {
    let near = |found: [f32; 2], expected: [f32; 2]| {
        let far = |at: usize| (found[at] - expected[at]).abs();
        assert!(far(0) < 1e-5 && far(1) < 1e-5, "{found:?}, not {expected:?}");
    };
    let mut scene = moving(&[0.0, 1.0, 0.5, 0.0, 1.0, 0.25], "LINEAR");
    assert_eq!(scene.validate(), []);
    let animation = &scene.animations[0];
    assert!((animation.duration / animation.ticks_per_second - 0.2).abs() < 1e-6);
    for (seconds, expected) in [(0.0, [0.0, 1.0]), (0.05, [0.25, 0.5]), (0.2, [1.0, 0.25])] {
        near(weights_at(&scene, seconds), expected);
    }
    // The second animation moves no target.
    let targets = &scene.meshes[0].morph_targets;
    assert!(targets.iter().all(|target| target.weight_keys[1].is_empty()));
    scene.resample(40.0, &mocap::Limits::default()).unwrap();
    near(weights_at(&scene, 0.05), [0.25, 0.5]);
    let tick = |seconds: f64| seconds * scene.animations[0].ticks_per_second;
    let (first, last) = (tick(0.1), tick(0.2));
    scene.trim(first, last);
    near(weights_at(&scene, 0.0), [0.5, 0.0]);
    near(weights_at(&scene, 0.1), [1.0, 0.25]);
    let text = serde_json::to_string(&scene.meshes).unwrap();
    assert_eq!(serde_json::from_str::<Vec<Mesh>>(&text).unwrap(), scene.meshes);

    let stepped = moving(&[0.0, 1.0, 0.5, 0.0, 1.0, 0.25], "STEP");
    near(weights_at(&stepped, 0.09), [0.0, 1.0]);
    near(weights_at(&stepped, 0.1), [0.5, 0.0]);
    // With tangents of 0, a curve has half of its change after half of the time between two keys.
    let mut tangents = Vec::new();
    for pair in [[0.0, 1.0], [0.5, 0.0], [1.0, 0.25]] {
        tangents.extend([0.0, 0.0, pair[0], pair[1], 0.0, 0.0]);
    }
    let curved = moving(&tangents, "CUBICSPLINE");
    near(weights_at(&curved, 0.05), [0.25, 0.5]);
    // 0.5 * (3 t^2 - 2 t^3) at t = 1/4.
    near(weights_at(&curved, 0.025), [0.078_125, 1.0 - 0.156_25]);
}

#[test]
fn weights_that_cannot_be_read_stay_at_rest() {
    for weights in [&[0.0, 1.0, 0.5][..], &[0.0, 1.0, f32::NAN, 0.0, 1.0, 0.25]] {
        let scene = moving(weights, "LINEAR");
        let targets = &scene.meshes[0].morph_targets;
        assert!(targets.len() == 2 && targets.iter().all(|target| target.weight_keys.is_empty()));
        assert!(
            scene.warnings.iter().any(|warning| warning.code == Code::IgnoredMesh),
            "{:?}",
            scene.warnings
        );
    }
}

#[cfg(feature = "fbx")]
#[test]
fn blend_shapes_of_fbx_are_targets() {
    const SHAPE: &str = r#"	Geometry: 20, "Geometry::smile", "Shape" {
		Version: 100
		Indexes: *2 {
			a: 1,5
		}
		Vertices: *6 {
			a: 0,0,10,0,20,0
		}
		Normals: *6 {
			a: 0,0,0,0,0,0
		}
	}
	Deformer: 21, "Deformer::shapes", "BlendShape" {
		Version: 100
	}
	Deformer: 22, "SubDeformer::smile", "BlendShapeChannel" {
		Version: 100
		DeformPercent: 50
		FullWeights: *1 {
			a: 100
		}
	}
}
Connections:  {
	C: "OO",21,3
	C: "OO",22,21
	C: "OO",20,22
"#;
    let text = crate::fbx::textured("", "").replace("}\nConnections:  {\n", SHAPE);
    let scene = Importer::new()
        .morph_targets(true)
        .read(text.as_bytes(), "quad.fbx")
        .unwrap();
    let mut found = Vec::new();
    for mesh in &scene.meshes {
        for target in &mesh.morph_targets {
            assert_eq!((target.name.as_str(), target.weight), ("smile", 0.5));
            for (vertex, offset) in std::iter::zip(&target.vertex_ids, &target.offsets) {
                let [x, y, z] = mesh.vertices[*vertex as usize].to_array();
                found.push([x, y, z, offset.x, offset.y, offset.z]);
            }
        }
    }
    // The file is in centimetres, and the shape has half of its weight. Vertex 1 is in both halves.
    found.sort_by(|a, b| a.partial_cmp(b).unwrap());
    let expected = [
        [1.0, 0.0, 0.05, 0.0, 0.0, 0.1],
        [1.0, 0.0, 0.05, 0.0, 0.0, 0.1],
        [2.0, 1.1, 0.0, 0.0, 0.2, 0.0],
    ];
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (found, expected) in std::iter::zip(&found, &expected) {
        let far = std::iter::zip(found, expected).map(|(a, b): (&f32, &f32)| (a - b).abs());
        assert!(far.fold(0.0, f32::max) < 1e-6, "{found:?} {expected:?}");
    }
    let plain = Importer::new().read(text.as_bytes(), "quad.fbx").unwrap();
    assert!(plain.meshes.iter().all(|mesh| mesh.morph_targets.is_empty()));
}
