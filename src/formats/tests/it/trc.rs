//! TRC: dialects computed by hand, errors with their location, and written files, read by splitting lines.

use glam::Vec3;
use mocap::{Code, Conversion, Exporter, Format, Importer, Scene};

const HEADER: &str = "PathFileType\t4\t(X/Y/Z)\ttake.trc\n\
    DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n\
    60.00\t60.00\t3\t2\tmm\t60.00\t1\t3\n\
    Frame#\tTime\tR.ASIS\t\t\tV Sacral\t\t\n\
    \t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n";

fn read(text: &str) -> mocap::Result<Scene> {
    Importer::new().collapse_keys(false).read(text.as_bytes(), "take.trc")
}

#[test]
fn markers_gaps_names_with_blanks_and_the_unit() {
    let scene = read(&format!(
        "{HEADER}1\t0.0\t1\t2\t3\t4\t5\t6\n2\t0.017\t1.5\t2\t3\t\t\t\n3\t0.033\t0\t0\t0\t4\t5\t7\r\n"
    ))
    .unwrap();
    assert_eq!(scene.metadata.format, Some(Format::Trc));
    assert_eq!(scene.metadata.metres_per_unit, Some(0.001));
    assert_eq!(scene.metadata.up, None);
    let animation = &scene.animations[0];
    assert_eq!((animation.ticks_per_second, animation.duration), (60.0, 2.0));
    let keys = |channel: usize| &animation.channels[channel].position_keys;
    assert_eq!(
        (scene.nodes[1].name.as_str(), scene.nodes[2].name.as_str()),
        ("R.ASIS", "V Sacral")
    );
    // 0, 0, 0 means that the marker is hidden.
    assert_eq!(keys(0).values, [Vec3::new(1.0, 2.0, 3.0), Vec3::new(1.5, 2.0, 3.0)]);
    assert_eq!(
        (&keys(1).values[1], &keys(1).ticks),
        (&Vec3::new(4.0, 5.0, 7.0), &Some(vec![0.0, 2.0]))
    );
    let gaps = scene
        .warnings
        .iter()
        .filter(|warning| warning.code == Code::Gap)
        .count();
    assert_eq!(gaps, 2, "{:?}", scene.warnings);
}

#[test]
fn blanks_as_separators_no_line_of_axes_and_the_rate_of_the_times() {
    let text = "PathFileType 4 (X/Y/Z) a.trc\nDataRate NumFrames NumMarkers Units\n0 3 1 m\nFrame# Time A\n\
        1 0.00 1 2 3\n2 0.02 1 2 4\n3 0.04 1 2 5\n";
    let scene = read(text).unwrap();
    assert_eq!(scene.metadata.metres_per_unit, Some(1.0));
    assert!((scene.animations[0].ticks_per_second - 50.0).abs() < 1e-9);
    assert_eq!(scene.animations[0].channels[0].position_keys.values[2].z, 5.0);
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

#[test]
fn blanks_among_tabs_in_the_header_are_read() {
    let row = "1\t0\t1\t2\t3\t4\t5\t6\n";
    let plain = read(&format!("{HEADER}{row}")).unwrap();
    // A file as OpenSim writes it, and the same file after an editor replaced some tabs by blanks.
    for (from, to) in [
        ("PathFileType\t", "PathFileType  "),
        ("\tNumMarkers\t", "  NumMarkers "),
    ] {
        assert!(HEADER.contains(from), "{from:?}");
        let scene = read(&format!("{}{row}", HEADER.replacen(from, to, 1))).unwrap();
        assert!(
            scene.nodes == plain.nodes && scene.animations == plain.animations,
            "{from:?}"
        );
        assert_eq!(scene.metadata.metres_per_unit, plain.metadata.metres_per_unit);
    }
    let error = read(&HEADER.replacen("PathFileType", "PathFileTypes", 1)).unwrap_err();
    assert_eq!(error.code(), Code::MissingKeyword);
}

#[test]
fn errors_name_their_place() {
    let place = |text: &str, code: Code| {
        let error = read(text).unwrap_err();
        assert_eq!(error.code(), code, "{error}");
        let at = error.diagnostic().location.as_ref().map(|at| (at.line, at.column));
        at.unwrap_or_else(|| panic!("{error}"))
    };
    let row = |row: &str| format!("{HEADER}{row}\n");
    assert_eq!(place(&row("1\t0\t1\t2\tx\t4\t5\t6"), Code::InvalidNumber), (7, 9));
    assert_eq!(place(&row("1\t0\t1\t2\t3\t4"), Code::RowLength).0, 7);
    assert_eq!(place("PathFileType 4\nDataRate\n60\n", Code::MissingKeyword).0, 2);
    assert_eq!(place(&HEADER[..60], Code::UnexpectedEnd).0, 2);
    let warned = read(&row("1\t0\t1e30\t2\t3\t4\t5\t6")).unwrap();
    let codes: Vec<_> = warned.warnings.iter().map(|warning| warning.code).collect();
    assert_eq!(codes, [Code::NonFiniteValue, Code::MissingFrames, Code::Gap]);
    // A file that is truncated anywhere is an error or a scene.
    let whole = row("1\t0\t1\t2\t3\t4\t5\t6");
    for end in 0..whole.len() {
        let _ = read(&whole[..end]);
    }
}

/// Columns without names, as in real files.
#[test]
fn columns_without_names_are_markers_or_are_said() {
    let names = |scene: &Scene| {
        scene.nodes[1..]
            .iter()
            .map(|node| node.name.clone())
            .collect::<Vec<_>>()
    };
    let row = |more: &str| {
        format!(
            "{HEADER}1\t0\t1\t2\t3\t4\t5\t6{more}\n2\t0.1\t1\t2\t3\t4\t5\t6{more}\n3\t0.2\t1\t2\t3\t4\t5\t7{more}\n"
        )
    };
    let codes = |scene: &Scene| {
        scene
            .warnings
            .iter()
            .map(|one| (one.code, one.count))
            .collect::<Vec<_>>()
    };
    // A complete triple, trailing tabs, and an incomplete triple.
    let triple = read(&row("\t7\t8\t9")).unwrap();
    assert_eq!(names(&triple), ["R.ASIS", "V Sacral", "Unnamed_3"]);
    assert_eq!(
        triple.animations[0].channels[2].position_keys.values,
        [Vec3::new(7.0, 8.0, 9.0); 3]
    );
    assert_eq!(codes(&triple), [(Code::HeaderCount, 1)]);
    let tabs = read(&row("\t\t\t\t")).unwrap();
    assert_eq!((names(&tabs).len(), codes(&tabs)), (2, vec![]));
    let one = read(&row("\t7")).unwrap();
    assert_eq!((names(&one).len(), codes(&one)), (2, vec![(Code::TrailingText, 3)]));
    assert_eq!(one.animations[0].channels[1].position_keys.values[2].z, 7.0);
    // A triple only in the third frame, and four numbers.
    let late = read(&row("").replacen("5\t7\n", "5\t7\t7\t8\t9\n", 1)).unwrap();
    assert_eq!(late.animations[0].channels[2].position_keys.len(), 1);
    let four = read(&row("\t7\t8\t9\t1")).unwrap();
    assert_eq!((names(&four).len(), codes(&four).len()), (3, 2));
    // A name is missing between two names. Each name is above its own columns.
    let between = HEADER.replace("R.ASIS\t\t\tV Sacral", "R.ASIS\t\t\t\t\t\tV Sacral");
    let scene = read(&format!("{between}1\t0\t1\t2\t3\t4\t5\t6\t7\t8\t9\n")).unwrap();
    assert_eq!(names(&scene), ["R.ASIS", "Unnamed_2", "V Sacral"]);
    assert_eq!(
        scene.animations[0].channels[2].position_keys.values[0],
        Vec3::new(7.0, 8.0, 9.0)
    );
    // The names follow each other without gaps.
    let dense = HEADER.replace("R.ASIS\t\t\tV Sacral\t\t", "R.ASIS\tV Sacral");
    let scene = read(&format!("{dense}1\t0\t1\t2\t3\t4\t5\t6\n")).unwrap();
    assert_eq!(
        scene.animations[0].channels[1].position_keys.values[0],
        Vec3::new(4.0, 5.0, 6.0)
    );
}

fn written(scene: &Scene) -> String {
    let bytes = Exporter::new().write(scene, Format::Trc).unwrap().into_bytes();
    String::from_utf8(bytes.unwrap()).unwrap()
}

/// A marker that is always seen at the same position keeps its gaps, whichever frames they are.
#[test]
fn a_marker_at_one_place_keeps_its_gaps() {
    let importer = Importer::new();
    for seen in [vec![0], vec![2], vec![0, 1], vec![1, 2], vec![0, 2], vec![0, 1, 2]] {
        let rows: String = (0..3)
            .map(|frame| {
                let still = if seen.contains(&frame) { "7\t8\t9" } else { "\t\t" };
                format!("{}\t{frame}\t{frame}\t2\t3\t{still}\n", frame + 1)
            })
            .collect();
        let mut scene = importer.read(format!("{HEADER}{rows}").as_bytes(), "a.trc").unwrap();
        assert_eq!(scene.validate(), []);
        let text = written(&scene);
        let found: Vec<usize> = (0..3).filter(|frame| !rows_of(&text)[*frame][5].is_empty()).collect();
        assert_eq!(found, seen);
        // A part that begins at the second frame.
        scene.trim(1.0, 2.0);
        let text = written(&scene);
        let found: Vec<usize> = (0..2).filter(|frame| !rows_of(&text)[*frame][5].is_empty()).collect();
        let expected: Vec<usize> = seen.iter().filter(|frame| **frame > 0).map(|frame| frame - 1).collect();
        assert_eq!(found, expected, "{seen:?}");
    }
}

fn rows_of(text: &str) -> Vec<Vec<&str>> {
    rows(text).split_off(6)
}

/// The cells of a written file, split at line ends and tabs.
fn rows(text: &str) -> Vec<Vec<&str>> {
    text.lines().map(|line| line.split('\t').collect()).collect()
}

#[test]
fn markers_of_c3d_are_written_with_their_gaps() {
    let mut scene = mocap::import("../../fixtures/real/py_c3d_motion.c3d").unwrap();
    Conversion::new().apply(&mut scene).unwrap();
    let text = String::from_utf8(
        Exporter::new()
            .write(&scene, Format::Trc)
            .unwrap()
            .into_bytes()
            .unwrap(),
    )
    .unwrap();
    let rows = rows(&text);
    let markers = scene.nodes.len() - 1;
    assert_eq!((rows[2][3], rows[2][4]), (markers.to_string().as_str(), "mm"));
    let frames = &rows[6..];
    assert_eq!(frames.len(), scene.animations[0].frame_count());
    let mut gaps = 0;
    for (marker, channel) in scene.animations[0].channels.iter().enumerate() {
        let keys = &channel.position_keys;
        assert_eq!(rows[3][2 + 3 * marker], channel.node_name);
        for (key, position) in keys.values.iter().enumerate().step_by(17) {
            let row = &frames[keys.tick(key) as usize];
            for axis in 0..3 {
                let written: f32 = row[2 + 3 * marker + axis].parse().unwrap();
                assert!(
                    (written - position[axis] * 1000.0).abs() < 1e-3,
                    "{} {key}",
                    channel.node_name
                );
            }
        }
        let empty = frames.iter().filter(|row| row[2 + 3 * marker].is_empty()).count();
        let missing = if keys.len() == 1 { 0 } else { frames.len() - keys.len() };
        assert_eq!(empty, missing, "{}", channel.node_name);
        gaps += missing;
    }
    assert!(gaps > 0);
}

/// The reader's limit applies, whatever the header claims.
#[test]
fn counts_are_claims() {
    let claim = HEADER.replace("\t3\t2\tmm", "\t4000000000\t4000000000\tmm");
    let scene = read(&format!("{claim}1\t0\t1\t2\t3\t4\t5\t6\n")).unwrap();
    assert_eq!((scene.nodes.len(), scene.animations[0].frame_count()), (3, 1));
}
