//! Compares the kinematics that other tests trust with closed forms.

use crate::kinematics::{Capture, Root, distance, multiply, turn};

const LECTURE: &[u8] = include_bytes!("../../fixtures/real/lecture_Test.bvh");

#[test]
fn the_lecture_chain_stands_where_the_sum_of_angles_puts_it() {
    let capture = Capture::parse(LECTURE);
    let names: Vec<&str> = capture.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(names, ["Shoulder", "Elbow", "Wrist", "EndSite_Wrist"]);
    assert_eq!(capture.rows.len(), 10);
    assert_eq!(capture.frame_time, 0.1);

    // All rotations are about z, so the links are in a plane. Each link adds l (cos, sin), with its length l and the
    // sum of the angles so far.
    for frame in 0..10 {
        let n = (frame + 1) as f64;
        let (mut x, mut y, mut angle) = (0.1 * n, 0.02 * frame as f64, 0.0_f64);
        let mut expected = vec![[x, y, 0.0]];
        for (step, length) in [(5.0, 2.0), (10.0, 1.5), (8.0, 0.5)] {
            angle += f64::to_radians(step * n);
            x += length * angle.cos();
            y += length * angle.sin();
            expected.push([x, y, 0.0]);
        }
        for (placement, expected) in capture.placements(frame, Root::Replace).iter().zip(&expected) {
            assert!(
                distance(placement.position, *expected) < 1e-12,
                "frame {frame}: {placement:?}, {expected:?}"
            );
        }
    }
}

#[test]
fn a_turn_takes_each_axis_to_the_next() {
    // A rotation by 90 degrees about z moves x to y, about x moves y to z, and about y moves z to x. These are the
    // columns of the matrices.
    let quarter = |axis, column: usize| turn(axis, 90.0).map(|row: [f64; 3]| row[column].round());
    assert_eq!(quarter(2, 0), [0.0, 1.0, 0.0]);
    assert_eq!(quarter(0, 1), [0.0, 0.0, 1.0]);
    assert_eq!(quarter(1, 2), [1.0, 0.0, 0.0]);
}

#[test]
fn rotations_multiply_in_the_order_written() {
    // Z then X, both by 90 degrees. X is applied first and moves (0, 1, 0) to (0, 0, 1), which Z does not change. In
    // the other order, Z moves the vector to (-1, 0, 0), which X does not change.
    let y = |matrix: [[f64; 3]; 3]| matrix.map(|row| row[1].round());
    assert_eq!(y(multiply(turn(2, 90.0), turn(0, 90.0))), [0.0, 0.0, 1.0]);
    assert_eq!(y(multiply(turn(0, 90.0), turn(2, 90.0))), [-1.0, 0.0, 0.0]);

    let tip = |order: &str| {
        let text = format!(
            "HIERARCHY\nROOT a\n{{\nOFFSET 0 0 0\nCHANNELS 3 {order}\nEnd Site\n{{\nOFFSET 0 1 0\n}}\n}}\n\
             MOTION\nFrames: 1\nFrame Time: 1\n90 90 0\n"
        );
        Capture::parse(text.as_bytes()).placements(0, Root::Replace)[1].position
    };
    assert!(distance(tip("Zrotation Xrotation Yrotation"), [0.0, 0.0, 1.0]) < 1e-15);
    assert!(distance(tip("Xrotation Zrotation Yrotation"), [-1.0, 0.0, 0.0]) < 1e-15);
}

#[test]
fn position_channels_replace_the_offset_or_are_added_to_a_root() {
    let text = b"HIERARCHY\nROOT a\n{\nOFFSET 10 20 30\nCHANNELS 2 Xposition Zposition\nJOINT b\n{\nOFFSET 1 2 3\n\
                 CHANNELS 1 Yposition\n}\n}\nMOTION\nFrames: 1\nFrame Time: 1\n4 6 5\n";
    let capture = Capture::parse(text);
    let positions = |root| {
        capture
            .placements(0, root)
            .iter()
            .map(|placement| placement.position)
            .collect::<Vec<_>>()
    };
    assert_eq!(positions(Root::Replace), [[4.0, 20.0, 6.0], [5.0, 25.0, 9.0]]);
    assert_eq!(positions(Root::Add), [[14.0, 20.0, 36.0], [15.0, 25.0, 39.0]]);
    assert_eq!(
        capture
            .rest()
            .iter()
            .map(|placement| placement.position)
            .collect::<Vec<_>>(),
        [[10.0, 20.0, 30.0], [11.0, 22.0, 33.0]]
    );
    assert_eq!(capture.height(Root::Replace), 5.0);
}
