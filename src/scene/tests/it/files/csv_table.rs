//! Tests the reading of tables in CSV.

use mocap_scene::files::{Records, is_csv_of_points, is_own_csv};

#[test]
fn records_are_those_of_rfc_4180() {
    let mut records = Records::new("a,\"b \"\"x\"\", c\"\r\n\n1,,\"two\nlines\",\nlast");
    let mut cells = Vec::new();
    let mut all = Vec::new();
    while records.next(&mut cells) {
        all.push((records.line, cells.iter().map(ToString::to_string).collect::<Vec<_>>()));
    }
    let texts = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>();
    let expected = [
        (1, texts(&["a", "b \"x\", c"])),
        (2, texts(&[""])),
        (3, texts(&["1", "", "two\nlines", ""])),
        (5, texts(&["last"])),
    ];
    assert_eq!(all, expected);
}

#[test]
fn points_are_told_from_other_tables() {
    for head in [
        "frame,joint,x,y,z\n",
        "time;hip_x;hip_y;hip_z;knee_x;knee_y;knee_z;a_x;a_y;a_z\n",
        "x_a\ty_a\tz_a\tx_b\ty_b\tz_b\tx_c\ty_c\tz_c\r\n",
        "# made by hand\nA.X,A.Y,A.Z,B.X,B.Y,B.Z,C.X,C.Y,C.Z\n",
    ] {
        assert!(is_csv_of_points(head.as_bytes()), "{head}");
    }
    for head in [
        "",
        "file,format,frames,x\n",
        "root_x,root_y,root_z,root_qx,root_qy,root_qz,root_qw,left_hip,right_hip\n",
        "0.1,0.2,0.3\n",
        "\u{0}\u{1}",
    ] {
        assert!(!is_csv_of_points(head.as_bytes()), "{head}");
    }
    assert!(is_own_csv(b"# {\"frame_rate\":30.0") && is_own_csv(b"\"# {\"\"frame_rate\"\":30.0"));
}
