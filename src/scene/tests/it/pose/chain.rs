//! The separate matrices of a chain, compared with matrices that the tests compute from the text of the file.

use std::fs;

use mocap::glam::{Mat4, Vec3};
use mocap::process::SkeletonMesh;
use mocap::scene::{Node, NodeId, NodeKind, RotationOrder};
use mocap::{ChainMatrix, Code, Importer, Pose, Scene};

use crate::kinematics::{Capture, Column, Matrix, Placement, Root, multiply, turn};

/// One part in a million for numbers of single precision. Each factor has one rounding.
const ROUNDING: f64 = 2e-6;

fn import(name: &str) -> (Scene, Capture) {
    let path = format!("../../fixtures/real/{name}.bvh");
    let importer = Importer::new().skeleton_mesh(SkeletonMesh::None);
    (
        importer.import(&path).unwrap(),
        Capture::parse(&fs::read(path).unwrap()),
    )
}

fn assert_matrix(part: &ChainMatrix, found: Mat4, expected: Placement, scale: f64) {
    let rows = found.transpose().to_cols_array_2d();
    for (row, found) in rows.iter().enumerate() {
        let last = [0.0, 0.0, 0.0, 1.0];
        let expected = expected
            .rotation
            .get(row)
            .map_or(last, |[x, y, z]| [*x, *y, *z, expected.position[row]]);
        for (column, (found, expected)) in std::iter::zip(*found, expected).enumerate() {
            let off = (f64::from(found) - expected).abs();
            let most = if column == 3 {
                ROUNDING * scale.max(1.0)
            } else {
                ROUNDING
            };
            assert!(
                off <= most,
                "{} row {row} column {column}: {found}, not {expected}",
                part.symbol
            );
        }
    }
}

const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Six orders of channels, moving positions and end sites. Each L, each J and each partial product equals the values of
/// the columns, and the angles give the rotation again.
#[test]
fn each_matrix_is_that_of_its_columns() {
    for name in ["lecture_Test", "cmu_mixed_rotation_orders", "mocopi_jump_six_channels"] {
        let (scene, capture) = import(name);
        let scale = 10.0 * capture.height(Root::Replace);
        let frame = capture.rows.len() / 2;
        let pose = Pose::at_tick(&scene, 0, frame as f64).unwrap();
        for (end, node) in scene.nodes.iter().enumerate() {
            let mut nodes = vec![end];
            while let Some(parent) = capture.nodes[nodes[0]].parent {
                nodes.insert(0, parent);
            }
            let mut expected: Vec<(String, Placement)> = Vec::new();
            for (index, &at) in nodes.iter().enumerate() {
                let own = &capture.nodes[at];
                let first: usize = capture.nodes[..at].iter().map(|node| node.columns.len()).sum();
                let (mut position, mut rotation) = (own.offset, IDENTITY);
                for (column, value) in own.columns.iter().zip(&capture.rows[frame][first..]) {
                    match *column {
                        Column::Position(axis) => position[axis] = *value,
                        Column::Rotation(axis) => rotation = multiply(rotation, turn(axis, *value)),
                    }
                }
                let origin = [0.0; 3];
                if index > 0 {
                    let link = Placement {
                        rotation: IDENTITY,
                        position,
                    };
                    expected.push((format!("L{index}"), link));
                    position = origin;
                }
                if scene.nodes[at].kind == NodeKind::Joint {
                    expected.push((format!("J{index}"), Placement { rotation, position }));
                }
            }
            let chain = pose.chain(&scene, &node.name).unwrap();
            assert_eq!(chain.len(), expected.len(), "{name}: {}", node.name);
            let mut product = Placement {
                rotation: IDENTITY,
                position: [0.0; 3],
            };
            for (part, (symbol, matrix)) in chain.iter().zip(expected) {
                assert_eq!(part.symbol, symbol, "{name}: {}", node.name);
                product = product.then(matrix);
                assert_matrix(part, part.matrix, matrix, scale);
                assert_matrix(part, part.product, product, scale);
                assert_eq!(part.degrees.is_some(), symbol.starts_with('J'));
                if let (Some(order), Some(degrees)) = (part.order, part.degrees) {
                    let turns = order.axes().into_iter().zip(degrees);
                    let again = turns.fold(IDENTITY, |so_far, (axis, degrees)| {
                        multiply(so_far, turn(axis, degrees))
                    });
                    let matrix = Placement {
                        rotation: again,
                        ..matrix
                    };
                    assert_matrix(part, part.matrix, matrix, scale);
                    assert_eq!(Some(order), scene.nodes[part.node.index()].rotation_order);
                }
            }
        }
    }
}

/// T(P) R(50) T(2,0) R(100) T(1.5,0) R(80) in a plane: the numbers of the lecture's last row, computed by hand.
#[test]
fn the_arm_of_the_lecture_has_its_own_angles() {
    let (scene, _) = import("lecture_Test");
    let pose = Pose::at_tick(&scene, 0, 9.0).unwrap();
    let chain = pose.chain(&scene, "EndSite_Wrist").unwrap();
    let symbols: Vec<&str> = chain.iter().map(|part| &*part.symbol).collect();
    assert_eq!(symbols, ["J0", "L1", "J1", "L2", "J2", "L3"]);
    for (part, expected) in chain
        .iter()
        .filter(|part| part.degrees.is_some())
        .zip([50.0, 100.0, 80.0])
    {
        let [z, y, x] = part.degrees.unwrap();
        assert_eq!(part.order, Some(RotationOrder::Zyx));
        assert!(
            (z - expected).abs() < 1e-4 && y.abs() < 1e-4 && x.abs() < 1e-4,
            "{part:?}"
        );
    }
    let tip = chain[5].product.w_axis.truncate();
    assert!(tip.abs_diff_eq(Vec3::new(0.665_143, 2.079_067, 0.0), 1e-5), "{tip}");
    let attached = chain[4].product.transform_point3(Vec3::new(0.5, 0.0, 0.0));
    assert!(attached.abs_diff_eq(tip, 1e-6), "{attached}");
}

#[test]
fn a_joint_that_is_not_there_is_said() {
    let (scene, _) = import("lecture_Test");
    let error = Pose::rest(&scene).chain(&scene, "Wirst").unwrap_err();
    assert_eq!(error.code(), Code::InvalidValue);
    assert_eq!(error.diagnostic().message, "no joint is called \"Wirst\"");
    assert_eq!(error.diagnostic().help.as_deref(), Some("did you mean \"Wrist\"?"));
}

/// A group above the root counts if it moves. A group alone is a chain.
#[test]
fn a_group_counts_where_it_moves() {
    let group = |transform: Mat4| Node {
        name: "Group".into(),
        kind: NodeKind::Group,
        transform,
        ..Node::default()
    };
    let joint = Node {
        name: "Joint".into(),
        parent: Some(NodeId(0)),
        transform: Mat4::from_translation(Vec3::X),
        ..Node::default()
    };
    for (transform, symbols) in [
        (Mat4::IDENTITY, &["J0"][..]),
        (Mat4::from_translation(Vec3::Y), &["J0", "L1", "J1"]),
    ] {
        let scene = Scene {
            nodes: vec![group(transform), joint.clone()],
            ..Scene::default()
        };
        let pose = Pose::rest(&scene);
        let chain = pose.chain(&scene, "Joint").unwrap();
        let found: Vec<&str> = chain.iter().map(|part| &*part.symbol).collect();
        assert_eq!(found, symbols);
        assert_eq!(chain.last().unwrap().product, pose.node_to_world[1]);
        assert_eq!(pose.chain(&scene, "Group").unwrap()[0].product, transform);
    }
}

/// serde writes a matrix as its rows.
#[test]
fn the_json_has_rows() {
    let (scene, _) = import("lecture_Test");
    let chain = Pose::rest(&scene).chain(&scene, "Elbow").unwrap();
    let json = serde_json::to_value(&chain).unwrap();
    assert_eq!(json[1]["symbol"], "L1");
    assert_eq!(json[1]["matrix"][0], serde_json::json!([1.0, 0.0, 0.0, 2.0]));
    assert_eq!((&json[0]["order"], json[1].get("degrees")), (&"ZYX".into(), None));
}
