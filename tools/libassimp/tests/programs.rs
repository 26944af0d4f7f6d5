//! Compiles programs once against Assimp's headers and library, and runs them with Debian's library and with this
//! library.

mod program;

use std::path::Path;
use std::process::Command;

use program::{Library, compile, our_folder, run, run_under_valgrind, succeed, text, with};

const LECTURE: &str = "lecture_Test";

/// Real files, from five programs that write BVH, that both libraries read without a known difference.
const REAL: [&str; 5] = [
    "cmu_short",
    "biovision_example1",
    "makehuman_zombie_walk",
    "slimevr_headset_root",
    "z_up_dab",
];

fn fixture(name: &str) -> String {
    format!("{}/../../fixtures/real/{name}.bvh", env!("CARGO_MANIFEST_DIR"))
}

/// Asserts that two strings have the same words in the same lines. Numbers may differ by `tolerance` of the line and
/// the number.
fn assert_same_words(name: &str, expected: &str, found: &str, tolerance: impl Fn(&str, f64) -> f64) {
    assert_eq!(expected.lines().count(), found.lines().count(), "{name}: lines");
    for (number, (expected, found)) in expected.lines().zip(found.lines()).enumerate() {
        let is_same_word = |(left, right): (&str, &str)| {
            let numbers = left.parse::<f64>().ok().zip(right.parse::<f64>().ok());
            left == right || numbers.is_some_and(|(left, right)| (left - right).abs() <= tolerance(expected, left))
        };
        let same = expected.split_whitespace().count() == found.split_whitespace().count()
            && std::iter::zip(expected.split_whitespace(), found.split_whitespace()).all(is_same_word);
        assert!(same, "{name}, line {}:\n  {expected}\n  {found}", number + 1);
    }
}

/// One unit of the sixth digit, the last that C++ prints. Numbers below 1 have the tolerance of 0.1, because sums of
/// larger numbers leave this error. The tolerance is slightly more, because decimals are not exact in binary.
fn sixth_digit(_line: &str, number: f64) -> f64 {
    let digits_before_point = number.abs().max(0.1).log10().floor() as i32 + 1;
    1.001 * 10f64.powi(digits_before_point - 6)
}

/// 1e-5, relative to numbers above 1. The components of a world position are sums of terms as large as the largest
/// component, so there the tolerance is relative to the largest component.
fn share(line: &str, number: f64) -> f64 {
    let is_in_world = line.starts_with("  ") && line.split_whitespace().count() == 20;
    let numbers = line.split_whitespace().filter_map(|word| word.parse::<f64>().ok());
    let greatest = numbers.fold(1.0, |greatest: f64, number| greatest.max(number.abs()));
    1e-5 * if is_in_world { greatest } else { number.abs().max(1.0) }
}

#[test]
fn the_course_sees_the_same_lecture() {
    let program = compile("course", &[]);
    let debian = run(&program, Library::Debian, &fixture(LECTURE));
    let ours = run(&program, Library::Ours, &fixture(LECTURE));
    assert!(ours.contains("tick 9\n"), "{ours}");
    assert_same_words(LECTURE, &debian, &ours, sixth_digit);
}

#[test]
fn the_course_sees_the_same_real_files() {
    let program = compile("course", &[]);
    for name in REAL {
        let debian = run(&program, Library::Debian, &fixture(name));
        let ours = run(&program, Library::Ours, &fixture(name));
        assert!(debian.contains("tick 1\n"), "{name}: {debian}");
        assert_same_words(name, &debian, &ours, share);
    }
}

#[test]
fn everything_else_is_the_same() {
    let program = compile("everything", &[]);
    for name in [LECTURE].iter().chain(&REAL[..2]) {
        let debian = run(&program, Library::Debian, &fixture(name));
        let ours = run(&program, Library::Ours, &fixture(name));
        assert_same_words(name, &debian, &ours, share);
    }
}

/// Sums have Assimp's order, so only the compiler's rounding remains.
#[test]
fn mathematics_is_the_same() {
    let program = compile("math", &[]);
    let debian = program::run_with(&program, Library::Debian, &[]);
    let mut command = Command::new(&program);
    let ours = text(succeed(
        with(&mut command, Library::Ours).env("MOCAP_ASSIMP_FORWARD", "off"),
    ));
    assert_eq!(ours.lines().count(), 78 * 200);
    assert_same_words("math", &debian, &ours, |_, number| 1e-6 * number.abs().max(1.0));
}

#[test]
fn the_class_of_cpp_programs_is_the_same() {
    let program = compile("importer", &[]);
    let debian = run(&program, Library::Debian, &fixture(LECTURE));
    let ours = run(&program, Library::Ours, &fixture(LECTURE));
    // Assimp's BVH importer keeps nodes of the last motion, so it fails in the last line.
    let (debian, _) = debian.split_once("again: ").unwrap();
    let (ours, again) = ours.split_once("again: ").unwrap();
    assert_eq!(ours, debian);
    assert!(ours.ends_with(&format!("file: {again}")), "{ours}, {again}");
}

/// A mesh that Debian's library writes, with which a program tries every forwarded function.
#[test]
fn what_is_not_read_or_done_here_is_done_by_the_systems_assimp() {
    let program = compile("forward", &[]);
    let mesh = program.with_extension("obj");
    let box_of = "o box\nv 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 0\nv 0 0 3\nf 1 2 3 4\nf 1 2 5\n";
    std::fs::write(&mesh, box_of).unwrap();
    let arguments = [mesh.to_str().unwrap(), &fixture(LECTURE)];
    let debian = program::run_with(&program, Library::Debian, &arguments);
    let output = succeed(with(Command::new(&program).args(arguments), Library::Ours));
    assert!(
        String::from_utf8_lossy(&output.stderr).contains("\"none\""),
        "{output:?}"
    );
    let ours = text(output);
    assert!(ours.contains("a blob 1\n"), "{ours}");
    assert_same_words("forward", &debian, &ours, share);
}

#[test]
fn the_commands_of_debian_say_the_same() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let mesh = folder.join("command.obj");
    std::fs::write(&mesh, "v 0 0 0\nv 1 0 0\nv 1 2 0\nf 1 2 3\n").unwrap();
    let (mesh, motion) = (mesh.to_str().unwrap(), fixture(LECTURE));
    let stl = folder.join("command.stl");
    for arguments in [
        vec!["info", mesh],
        vec!["info", &motion],
        vec!["listexport"],
        vec!["knowext", "obj"],
        vec!["export", mesh, stl.to_str().unwrap()],
        vec!["export", &motion, stl.to_str().unwrap()],
    ] {
        let run = |library| {
            let mut command = Command::new("assimp");
            let output = text(succeed(with(command.args(&arguments), library)));
            // Progress, time, and memory.
            let is_said = |line: &&str| !["%", "seconds", "Memory"].iter().any(|word| line.contains(word));
            output
                .lines()
                .filter(is_said)
                .map(|line| format!("{line}\n"))
                .collect::<String>()
        };
        assert_same_words(&arguments.join(" "), &run(Library::Debian), &run(Library::Ours), share);
    }
}

/// Lists what a library exports, functions and objects with their sizes, as `tests/symbols.txt` does.
#[test]
fn every_symbol_of_assimp_is_there() {
    let mut readelf = Command::new("readelf");
    readelf
        .args(["--dyn-syms", "--wide"])
        .arg(our_folder().join("libassimp.so.5"));
    let ours = text(succeed(&mut readelf));
    let ours: std::collections::HashSet<String> = ours
        .lines()
        .filter_map(|line| {
            let words: Vec<&str> = line.split_whitespace().collect();
            match words[..] {
                [_, _, _, "FUNC", _, _, place, name] if place != "UND" => Some(format!("{name} function")),
                [_, _, size, "OBJECT", _, _, place, name] if place != "UND" => Some(format!("{name} object {size}")),
                _ => None,
            }
        })
        .collect();
    let wanted: Vec<&str> = SYMBOLS.lines().filter(|line| !line.starts_with('#')).collect();
    assert_eq!(wanted.len(), 550);
    let missing: Vec<_> = wanted.iter().filter(|symbol| !ours.contains(**symbol)).collect();
    assert!(missing.is_empty(), "{missing:?}");
}

const SYMBOLS: &str = include_str!("symbols.txt");

/// Omits nodes that only Assimp has, such as cameras.
#[test]
fn fbx_keeps_the_unit_and_the_axes_of_the_file() {
    let program = compile("units", &[]);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let fixtures = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures");
    let tiny = std::fs::read_to_string(format!("{fixtures}/made/tiny.fbx")).unwrap();
    let unit = "\"UnitScaleFactor\", \"double\", \"Number\", \"\",";
    let mut files = vec![format!("{fixtures}/real/run.fbx")];
    for stated in ["1", "2.54", "100"] {
        let file = folder.join(format!("unit_{stated}.fbx"));
        std::fs::write(&file, tiny.replace(&format!("{unit}1"), &format!("{unit}{stated}"))).unwrap();
        files.push(file.to_str().unwrap().to_owned());
    }
    for file in files {
        let ours = run(&program, Library::Ours, &file);
        let debian = run(&program, Library::Debian, &file);
        let named = |line: &str| line.split_once(": ").map(|(name, _)| format!("{name}: ")).unwrap();
        let same: Vec<&str> = ours
            .lines()
            .map(|line| {
                debian
                    .lines()
                    .find(|other| other.starts_with(&named(line)))
                    .unwrap_or("absent")
            })
            .collect();
        assert!(same.len() >= 8, "{ours}");
        assert_same_words(&file, &same.join("\n"), &ours, |_, number| {
            1e-5 * number.abs().max(100.0)
        });
    }
}

#[test]
fn without_the_systems_assimp_motion_is_read_and_the_rest_refused_with_a_text() {
    let run = |arguments: &[&str]| {
        let mut command = Command::new("assimp");
        let command = with(command.args(arguments), Library::Ours);
        let output = command.env("MOCAP_ASSIMP_FORWARD", "off").output().unwrap();
        String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned()
    };
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let (mesh, skeleton) = (folder.join("refused.obj"), folder.join("no_motion.bvh"));
    std::fs::write(&mesh, "v 0 0 0\n").unwrap();
    std::fs::write(&skeleton, "HIERARCHY\nROOT a\n{\n  OFFSET 0 0 0\n  CHANNELS 0\n}\n").unwrap();
    assert!(run(&["info", &fixture(LECTURE)]).contains("Animations:         1"));
    assert!(run(&["info", mesh.to_str().unwrap()]).contains("MOCAP_ASSIMP_FORWARD is off"));
    assert!(run(&["info", skeleton.to_str().unwrap()]).contains("the file has no motion"));
}

/// Assimp also opens the files of a glTF scene for its meshes and skins, so a scene without these files is an error.
#[test]
fn gltf_whose_buffer_is_missing_is_refused_with_the_text_of_assimp() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let fixture = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../fixtures/made/two_bones_textured.gltf"
    );
    let whole: serde_json::Value = serde_json::from_slice(&std::fs::read(fixture).unwrap()).unwrap();
    let mut gone = whole;
    gone["buffers"][0]["uri"] = "gone.bin".into();
    let with_motion = folder.join("gone_with_motion.gltf");
    std::fs::write(&with_motion, gone.to_string()).unwrap();
    gone.as_object_mut().unwrap().remove("animations");
    let still = folder.join("gone_still.gltf");
    std::fs::write(&still, gone.to_string()).unwrap();
    for file in [with_motion, still] {
        let error = |library, forward: Option<&str>| {
            let mut command = Command::new("assimp");
            let command = with(command.arg("info").arg(&file), library);
            command.envs(forward.map(|forward| ("MOCAP_ASSIMP_FORWARD", forward)));
            let said = String::from_utf8(command.output().unwrap().stdout).unwrap();
            let error = said.lines().find(|line| line.starts_with("ERROR: "));
            error.unwrap_or_else(|| panic!("{said}")).to_owned()
        };
        let debian = error(Library::Debian, None);
        assert!(
            debian.ends_with("could not open referenced file \"gone.bin\""),
            "{debian}"
        );
        assert_eq!(error(Library::Ours, None), debian);
        // The message ends with the reason why no other library was used.
        let alone = error(Library::Ours, Some("off"));
        assert_eq!(alone, format!("{debian} (MOCAP_ASSIMP_FORWARD is off)"));
    }
}

#[test]
fn memory_is_sound_under_valgrind() {
    for source in ["course", "everything", "export", "importer"] {
        run_under_valgrind(&compile(source, &[]), &fixture(LECTURE));
    }
}

#[test]
fn memory_is_sound_under_the_address_sanitizer() {
    for source in ["course", "everything", "export", "importer"] {
        let program = compile(source, &["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]);
        run(&program, Library::Ours, &fixture(LECTURE));
    }
}

/// Uses pyassimp 5.2.5, which `check` installs into `target/python` of the workspace.
#[test]
fn python_sees_the_same_scene() {
    let see = |library, name: &str| {
        let mut python = Command::new("python3");
        python
            .args(["tests/scene.py", &fixture(name)])
            .env("PYTHONPATH", "../../target/python");
        let output = succeed(with(&mut python, library));
        // The script prints the library's path on standard error.
        let path = String::from_utf8_lossy(&output.stderr).into_owned();
        let is_ours = path.starts_with(our_folder().to_str().unwrap());
        assert_eq!(is_ours, library == Library::Ours, "{path}");
        text(output)
    };
    for name in [LECTURE].iter().chain(&REAL[..2]) {
        let (debian, ours) = (see(Library::Debian, name), see(Library::Ours, name));
        assert!(ours.ends_with("exported glTF True\n"), "{ours}");
        assert_same_words(name, &debian, &ours, share);
    }
}

#[test]
fn an_exported_scene_can_be_imported_again() {
    // Assimp reads our files: the program exports with this library, and imports with Debian's.
    let program = compile("export", &[]);
    let folder = program.with_extension("written");
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("lecture");
    program::run_with(&program, Library::Ours, &[&fixture(LECTURE), file.to_str().unwrap()]);
    for extension in ["glb", "gltf", "blob.glb", "blob.gltf"] {
        let file = folder.join(format!("lecture.{extension}"));
        let seen = run(&program, Library::Debian, file.to_str().unwrap());
        for name in ["Shoulder", "Elbow", "Wrist", "EndSite_Wrist"] {
            assert!(
                seen.lines().any(|line| line == format!("node {name}")),
                "{extension}: {seen}"
            );
        }
        assert!(seen.contains("seconds 0.9"), "{extension}: {seen}");
    }
}
