//! `mocap chain` with the numbers of the lecture's file, computed by hand.

use crate::program::{run, words};

const FILE: &str = "fixtures/real/lecture_Test.bvh";

/// The last row: angles of 50, 100 and 80 degrees about z, the shoulder at (1, 0.18).
#[test]
fn each_matrix_is_printed_apart() {
    let output = run(&["chain", FILE, "Wrist", "--tick", "9", "--point", "0.5,0,0"]);
    assert!(output.status.success(), "{}", words(&output));
    let text = String::from_utf8(output.stdout).unwrap();
    let (sin, cos) = 50_f64.to_radians().sin_cos();
    for line in [
        "T = J0 L1 J1 L2 J2, tick 9".to_owned(),
        "J0 Shoulder: Rz Ry Rx, Z 50.0000  Y 0.0000  X 0.0000 degrees, line 5".to_owned(),
        "L1 Elbow: translation to the parent, line 8".to_owned(),
        "J1 Elbow: Rz Ry Rx, Z 100.0000  Y 0.0000  X 0.0000 degrees, line 9".to_owned(),
        "J2 Wrist: Rz Ry Rx, Z 80.0000  Y 0.0000  X 0.0000 degrees, line 13".to_owned(),
        format!("  {cos:>10.4} {:>10.4}     0.0000     1.0000", -sin),
        format!("  {sin:>10.4} {cos:>10.4}     0.0000     0.1800"),
        "point in the world:      0.6651     2.0791     0.0000".to_owned(),
    ] {
        assert!(text.lines().any(|found| found.starts_with(&line)), "{line}\n{text}");
    }
}

#[test]
fn the_json_has_every_matrix() {
    let output = run(&["chain", FILE, "EndSite_Wrist", "--json", "--point", "0,1,0"]);
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&json["joint"], &json["tick"]), (&"EndSite_Wrist".into(), &0.0.into()));
    let symbols: Vec<_> = json["chain"]
        .as_array()
        .unwrap()
        .iter()
        .map(|part| part["symbol"].as_str())
        .collect();
    assert_eq!(symbols, ["J0", "L1", "J1", "L2", "J2", "L3"].map(Some));
    // The first row: 5, 15 and 23 degrees.
    let along = |length: f64, degrees: f64| (length * degrees.to_radians().cos(), length * degrees.to_radians().sin());
    let steps = [
        (0.1, 0.0),
        along(2.0, 5.0),
        along(1.5, 15.0),
        along(0.5, 23.0),
        along(1.0, 113.0),
    ];
    let (x, y) = steps.iter().fold((0.0, 0.0), |at, step| (at.0 + step.0, at.1 + step.1));
    for (axis, expected) in [x, y, 0.0].into_iter().enumerate() {
        let found = json["point_in_world"][axis].as_f64().unwrap();
        assert!((found - expected).abs() < 1e-6, "{found}, not {expected}");
    }
}

#[test]
fn the_first_tick_is_the_default() {
    for command in [vec!["pose", FILE], vec!["chain", FILE, "Wrist"]] {
        let first = run(&[&command[..], &["--tick", "0"]].concat());
        assert!(first.status.success(), "{}", words(&first));
        assert_eq!(run(&command).stdout, first.stdout);
    }
}

#[test]
fn what_cannot_be_is_said() {
    for (arguments, message) in [
        (
            ["Wirst", "--tick", "0"],
            "no joint is called \"Wirst\"\n |\n = help: did you mean \"Wrist\"?",
        ),
        (
            ["Wrist", "--point", "1,2"],
            "a point has three finite numbers, such as 0.5,0,0",
        ),
        (["Wrist", "--tick", "nan"], "--tick must be finite"),
    ] {
        let output = run(&[&["chain", FILE][..], &arguments].concat());
        assert!(
            !output.status.success() && words(&output).contains(message),
            "{}",
            words(&output)
        );
    }
}

#[test]
fn a_tick_outside_of_the_motion_is_named() {
    // The file has ten frames.
    for command in [vec!["pose", FILE], vec!["chain", FILE, "Wrist"]] {
        for (tick, taken) in [("9999", Some(9)), ("-1", Some(0)), ("9", None), ("0.5", None)] {
            let output = run(&[&command[..], &["--tick", tick]].concat());
            assert!(output.status.success(), "{}", words(&output));
            let said = taken.map(|taken| format!("tick {tick} is outside the motion, 0 to 9: tick {taken} is printed"));
            match said {
                Some(said) => assert!(words(&output).contains(&said), "{}", words(&output)),
                None => assert!(!words(&output).contains("outside"), "{}", words(&output)),
            }
        }
    }
}
