//! Meshes, materials and blend shapes that `usd-core` wrote, with the positions that its UsdSkel computes.

use mocap::glam::{Vec2, Vec3, Vec4};
use mocap::scene::report::{DataKind, DataLoss};
use mocap::scene::{AlphaMode, Keys, Mesh};
use mocap::{Code, Importer, Pose, Scene, SkeletonMesh};

const FACE: &str = "../../fixtures/made/face.usda";

/// World positions of points in metres with +Z up, by `usd-core` 26.11, as `tools/usd/face.py` prints them, with the
/// tick of each time code. Code 7 is between keys.
const HEAD: [(f64, [[f32; 3]; 8]); 4] = [
    (
        0.0,
        [
            [0.023771, -0.094569, 1.536108],
            [0.14458, -0.023817, 1.531184],
            [-0.055882, 0.043394, 1.554044],
            [0.064927, 0.114145, 1.54912],
            [0.039399, -0.121638, 1.713374],
            [0.160208, -0.050886, 1.70845],
            [-0.040254, 0.016325, 1.731309],
            [0.080555, 0.087076, 1.726385],
        ],
    ),
    (
        6.0,
        [
            [0.04962, -0.108448, 1.542447],
            [0.154535, -0.01568, 1.543554],
            [-0.06004, 0.02224, 1.554864],
            [0.046944, 0.112542, 1.551775],
            [0.046855, -0.105153, 1.739996],
            [0.154102, -0.015163, 1.736871],
            [-0.055991, 0.017414, 1.733746],
            [0.051256, 0.107404, 1.730621],
        ],
    ),
    (
        12.0,
        [
            [0.078329, -0.11515, 1.550096],
            [0.163077, -0.003505, 1.556902],
            [-0.060015, 0.000935, 1.556093],
            [0.029892, 0.108251, 1.554862],
            [0.044396, -0.086676, 1.762365],
            [0.134552, 0.020431, 1.761134],
            [-0.075977, 0.014329, 1.732119],
            [0.01418, 0.121435, 1.730888],
        ],
    ),
    (
        24.0,
        [
            [0.122438, -0.100858, 1.563506],
            [0.161395, 0.033948, 1.57311],
            [-0.048139, -0.038773, 1.55495],
            [-0.000256, 0.092784, 1.55495],
            [0.015799, -0.062044, 1.781331],
            [0.063682, 0.069513, 1.781331],
            [-0.114409, -0.014653, 1.701331],
            [-0.066526, 0.116904, 1.701331],
        ],
    ),
];

const TEETH: [(f64, [[f32; 3]; 4]); 4] = [
    (
        0.0,
        [
            [0.064019, -0.084282, 1.59],
            [0.115981, -0.054282, 1.59],
            [0.09, -0.069282, 1.61],
            [0.08, -0.051962, 1.6],
        ],
    ),
    (
        6.0,
        [
            [0.080955, -0.083563, 1.608168],
            [0.126918, -0.044995, 1.608168],
            [0.101704, -0.061619, 1.627864],
            [0.087786, -0.045032, 1.613892],
        ],
    ),
    (
        12.0,
        [
            [0.095399, -0.077256, 1.62737],
            [0.133966, -0.031294, 1.62737],
            [0.109443, -0.049878, 1.646164],
            [0.092267, -0.035466, 1.627362],
        ],
    ),
    (
        24.0,
        [
            [0.106169, -0.052369, 1.663046],
            [0.12669, 0.004012, 1.663046],
            [0.104349, -0.019781, 1.678367],
            [0.088794, -0.01412, 1.651423],
        ],
    ),
];

fn import() -> Scene {
    Importer::new().morph_targets(true).import(FACE).unwrap()
}

fn named<'a>(scene: &'a Scene, name: &'a str) -> impl Iterator<Item = &'a Mesh> {
    scene.meshes.iter().filter(move |mesh| mesh.name == name)
}

/// The positions of the vertices of a mesh in the first animation, with its morph targets.
fn vertices(scene: &Scene, mesh: &Mesh, tick: f64) -> Vec<Vec3> {
    let mut moved = mesh.clone();
    moved.vertices = mesh.vertices_without_targets().into_owned();
    for target in &mesh.morph_targets {
        let keys = target.weight_keys.first();
        let weight = keys.and_then(|keys| keys.sample(tick)).unwrap_or(target.weight);
        for (vertex, offset) in std::iter::zip(&target.vertex_ids, &target.offsets) {
            moved.vertices[*vertex as usize] += weight * *offset;
        }
    }
    Pose::at_tick(scene, 0, tick).unwrap().skin(&moved)
}

/// A point with several normals becomes several vertices, so each list must contain all positions of the other list.
#[track_caller]
fn assert_are(found: &[Vec3], expected: &[[f32; 3]], what: &str) {
    let expected: Vec<Vec3> = expected.iter().copied().map(Vec3::from).collect();
    let is_among = |point: Vec3, all: &[Vec3]| all.iter().any(|other| 0.01 * other.distance(point) < 2e-6);
    let metres: Vec<Vec3> = expected.iter().map(|point| 100.0 * *point).collect();
    let off = found.iter().find(|point| !is_among(**point, &metres));
    assert_eq!(off, None, "{what}");
    let absent = metres.iter().find(|point| !is_among(**point, found));
    assert_eq!(absent, None, "{what}");
}

#[test]
fn points_move_as_pixars_library_moves_them() {
    let scene = import();
    assert_eq!(scene.validate(), []);
    assert_eq!(scene.warnings, []);
    for (tick, points) in HEAD {
        let found: Vec<Vec3> = named(&scene, "Head")
            .flat_map(|mesh| vertices(&scene, mesh, tick))
            .collect();
        assert_are(&found, &points, &format!("Head at tick {tick}"));
    }
    for (tick, points) in TEETH {
        let teeth = named(&scene, "Teeth").next().unwrap();
        assert_are(
            &vertices(&scene, teeth, tick),
            &points,
            &format!("Teeth at tick {tick}"),
        );
    }
}

/// A quadrangle becomes two triangles, whose corners have the file's orientation around their normals. The left-handed
/// mesh has the opposite orientation.
#[test]
fn faces_normals_and_places_on_textures_are_those_of_corners() {
    let scene = import();
    let [skin, hair] = [0, 1].map(|index| named(&scene, "Head").nth(index).unwrap());
    assert_eq!([skin.indices.len(), hair.indices.len()], [5 * 6, 6]);
    for mesh in [skin, hair] {
        let plain = mesh.vertices_without_targets();
        for face in mesh.faces() {
            let [a, b, c] = [0, 1, 2].map(|corner| plain[face[corner] as usize]);
            let normal = (b - a).cross(c - a).normalize();
            for corner in face {
                assert!(mesh.normals[*corner as usize].distance(normal) < 1e-6);
            }
        }
        // The origin is the upper left corner of an image in a scene, and the lower left corner in USD.
        let corners = [(0.0, 1.0), (1.0, 1.0), (1.0, 0.25), (0.0, 0.25)].map(Vec2::from);
        assert!(mesh.texture_coords.iter().all(|coords| corners.contains(coords)));
    }
    // The corners of the top, in the order of the points in the file.
    assert_eq!(hair.vertices.len(), 4);
    let teeth = named(&scene, "Teeth").next().unwrap();
    assert_eq!(teeth.indices, [0, 1, 2, 0, 2, 3]);
    let looks = [skin, hair].map(|mesh| (&scene.materials[mesh.material_index], mesh));
    let colors = [Vec4::new(0.8, 0.4, 0.2, 1.0), Vec4::new(0.1, 0.1, 0.3, 0.5)];
    let alphas = [AlphaMode::Opaque, AlphaMode::Blend];
    for ((material, _), (color, alpha)) in std::iter::zip(looks, std::iter::zip(colors, alphas)) {
        let surface = material.surface.unwrap();
        assert!(surface.base_color.abs_diff_eq(color, 1e-6), "{surface:?}");
        assert_eq!(surface.alpha, alpha);
    }
    assert_eq!(teeth.material_index, skin.material_index);
}

#[test]
fn weights_are_those_of_names_in_each_animation() {
    let scene = import();
    let clips: Vec<_> = scene.animations.iter().map(|clip| clip.name.as_str()).collect();
    assert_eq!(clips, ["Talk", "Nod"]);
    let keys = |values: [f32; 3]| vec![Keys::at_ticks(values.to_vec(), vec![0.0, 12.0, 24.0]), Keys::default()];
    let expected = [
        ("smile", keys([0.0, 0.75, 1.0])),
        ("frown", keys([1.0, 0.25, 0.0])),
        ("puff", vec![]),
    ];
    let targets = named(&scene, "Head").flat_map(|mesh| &mesh.morph_targets);
    for target in targets.chain(named(&scene, "Teeth").flat_map(|mesh| &mesh.morph_targets)) {
        let (_, expected) = expected.iter().find(|(name, _)| *name == target.name).unwrap();
        assert_eq!(&target.weight_keys, expected, "{}", target.name);
        assert_eq!(target.weight, 0.0);
    }
    // The chair, and the in-between shape.
    let lost = [(DataKind::Meshes, 1), (DataKind::MorphTargets, 1)].map(|(kind, count)| DataLoss::new(kind, count));
    assert_eq!(scene.metadata.lost, lost);
}

#[test]
fn shapes_that_are_not_asked_for_are_counted() {
    let scene = Importer::new().import(FACE).unwrap();
    assert!(scene.meshes.iter().all(|mesh| mesh.morph_targets.is_empty()));
    let lost = |kind| {
        scene
            .metadata
            .lost
            .iter()
            .find(|loss| loss.kind == kind)
            .map(|loss| loss.count)
    };
    // The shapes of both meshes, with the in-between shape; `smile` and `frown` change.
    assert_eq!(
        (lost(DataKind::MorphTargets), lost(DataKind::FaceCurves)),
        (Some(5), Some(2))
    );
    let none = Importer::new().skeleton_mesh(SkeletonMesh::None).import(FACE).unwrap();
    assert_eq!(none.meshes, []);
}

#[test]
fn a_weight_that_stays_is_that_at_rest() {
    let text = std::fs::read_to_string(FACE).unwrap();
    let (before, rest) = text.split_once(".timeSamples = {\n            1: [1, 0, 0],").unwrap();
    let (_, after) = rest.split_once('}').unwrap();
    let still = "uniform token[] blendShapes = [\"smile\"]\nfloat[] blendShapeWeights = [0.5]\n";
    let (talk, nod) = after.split_once("def SkelAnimation \"Nod\"\n    {").unwrap();
    let text = format!("{before} = [0, 0, 0.5]{talk}def SkelAnimation \"Nod\"\n    {{{still}{nod}");
    let read = |targets: bool| {
        let importer = Importer::new().morph_targets(targets);
        importer.read(text.as_bytes(), "face.usda").unwrap()
    };
    let (with, without) = (read(true), read(false));
    let [moved, plain] = [&with, &without].map(|scene| named(scene, "Teeth").next().unwrap());
    let target = &moved.morph_targets[0];
    assert_eq!((target.weight, target.weight_keys.len()), (0.5, 0));
    for (at, vertex) in target.vertex_ids.iter().enumerate() {
        let vertex = *vertex as usize;
        assert_eq!(
            moved.vertices[vertex],
            plain.vertices[vertex] + 0.5 * target.offsets[at]
        );
    }
}

/// A mesh with contradictory numbers is dropped with a warning, and the other meshes are read.
#[test]
fn meshes_with_wrong_numbers_are_left_out() {
    let text = std::fs::read_to_string(FACE).unwrap();
    for (right, wrong) in [
        (
            "faceVertexIndices = [0, 2, 1, 0, 3, 2]",
            "faceVertexIndices = [0, 2, 1, 0, 9, 2]",
        ),
        (
            "faceVertexIndices = [0, 2, 1, 0, 3, 2]",
            "faceVertexIndices = [0, 2, 1, 0, -1, 2]",
        ),
        ("faceVertexCounts = [3, 3]", "faceVertexCounts = [3, 30]"),
        ("jointIndices = [1] (", "jointIndices = [7] ("),
        ("jointWeights = [1] (", "jointWeights = [1, 1] ("),
        ("points = [(-3, -9, 4)", "points = [(nan, -9, 4)"),
    ] {
        let broken = text.replacen(right, wrong, 1);
        assert!(broken != text, "{right}");
        let scene = Importer::new().read(broken.as_bytes(), "face.usda").unwrap();
        let said = scene.warnings.iter().find(|warning| warning.code == Code::IgnoredMesh);
        assert!(
            said.unwrap().message.starts_with("the mesh \"Teeth\" was skipped"),
            "{wrong}"
        );
        assert_eq!(
            (named(&scene, "Teeth").count(), named(&scene, "Head").count()),
            (0, 2),
            "{wrong}"
        );
        assert!(
            scene.metadata.lost.contains(&DataLoss::new(DataKind::Meshes, 2)),
            "{wrong}"
        );
    }
    let broken = text.replacen("[0.25, 0, 0.75]", "[0.25, 0]", 1);
    let scene = Importer::new()
        .morph_targets(true)
        .read(broken.as_bytes(), "face.usda")
        .unwrap();
    let said = scene
        .warnings
        .iter()
        .find(|warning| warning.code == Code::IgnoredChannel);
    assert!(
        said.unwrap()
            .message
            .contains("blendShapeWeights must have a number for each shape")
    );
    assert_eq!(scene.animations.len(), 2);
}

/// A damaged file gives an error, or a valid scene.
#[test]
fn changed_bytes_give_an_error_or_a_valid_scene() {
    let whole = std::fs::read(FACE).unwrap();
    let importer = Importer::new().morph_targets(true).hash(false);
    let mut random = 7_u32;
    for _ in 0..150 {
        let mut bytes = whole.clone();
        for _ in 0..3 {
            // The generator of Numerical Recipes.
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let at = random as usize % bytes.len();
            bytes[at] = b"0123456789-.,()[]e"[random as usize / 65_536 % 18];
        }
        if let Ok(scene) = importer.read(&bytes, "face.usda") {
            assert_eq!(scene.validate(), []);
        }
    }
}
