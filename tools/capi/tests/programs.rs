//! Compiles, links and runs the programs in C and C++ like a user, under valgrind.

#[path = "../../succeed.rs"]
mod succeed;

use std::path::{Path, PathBuf};
use std::process::Command;

use succeed::succeed;

const LECTURE: &str = "../../fixtures/real/lecture_Test.bvh";
const SHORT: &str = "../../fixtures/real/cmu_short.bvh";
const WALK: &str = "../../fixtures/real/cmu_12_01_walk.bvh";

/// Compilers with additional warnings, so that the header compiles without warnings for all users.
const C: &[&str] = &["cc", "-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror"];
const CPP: &[&str] = &["c++", "-std=c++11", "-Wall", "-Wextra", "-Wpedantic", "-Werror"];

/// Installs the library into a new folder named after the test, in the profile of the tests.
fn installed(test: &str) -> PathBuf {
    let prefix = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test);
    let mut install = Command::new("./install");
    install.arg(&prefix).arg("dev");
    // Use the profile of the tests, so that the library is not compiled again.
    if cfg!(feature = "meshopt") {
        install.args(["--features", "meshopt"]);
    }
    succeed(&mut install);
    prefix
}

/// The output of `pkg-config` for the library at `prefix`.
fn flags(prefix: &Path, more: &[&str]) -> Vec<String> {
    let output = succeed(
        Command::new("pkg-config")
            .args(["--cflags", "--libs", "mocap"])
            .args(more)
            .env("PKG_CONFIG_PATH", prefix.join("lib/pkgconfig")),
    );
    let flags = String::from_utf8(output.stdout).unwrap();
    flags.split_whitespace().map(str::to_owned).collect()
}

fn compile(compiler: &[&str], source: &str, program: &Path, flags: &[String]) {
    let (name, options) = compiler.split_first().unwrap();
    succeed(
        Command::new(name)
            .args(options)
            .args(["-g", "-pthread", source, "-o"])
            .arg(program)
            .args(flags)
            .arg("-lm"),
    );
}

/// Runs a program under valgrind, which fails on invalid accesses and memory leaks.
fn run(program: &Path, prefix: &Path, files: &[&str]) -> String {
    let output = succeed(
        Command::new("valgrind")
            .args(["--quiet", "--error-exitcode=99", "--leak-check=full"])
            .args([
                "--show-leak-kinds=definite,indirect,possible",
                "--errors-for-leak-kinds=definite,indirect,possible",
            ])
            .arg(program)
            .args(files)
            .env("LD_LIBRARY_PATH", prefix.join("lib")),
    );
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn a_c_program_sees_the_motion_of_the_lecture() {
    let prefix = installed("shared");
    let program = prefix.join("lecture");
    compile(C, "tests/lecture.c", &program, &flags(&prefix, &[]));
    assert_eq!(
        run(&program, &prefix, &[LECTURE]),
        "the arm stands where the lecture puts it\n"
    );
}

#[test]
fn a_c_program_links_the_static_library() {
    let prefix = installed("static");
    let program = prefix.join("lecture");
    for shared in ["libmocap.so", "libmocap.so.0"] {
        std::fs::remove_file(prefix.join("lib").join(shared)).unwrap();
    }
    compile(C, "tests/lecture.c", &program, &flags(&prefix, &["--static"]));
    assert_eq!(
        run(&program, &prefix, &[LECTURE]),
        "the arm stands where the lecture puts it\n"
    );
}

#[test]
fn a_cpp_program_reads_from_memory() {
    let prefix = installed("memory");
    let program = prefix.join("memory");
    compile(CPP, "tests/memory.cpp", &program, &flags(&prefix, &[]));
    assert_eq!(run(&program, &prefix, &[LECTURE]), path_of_the_wrist(1));
}

/// Tests everything in `mocap.hpp`, in the oldest supported C++ and in a newer version.
#[test]
fn a_cpp_program_leaves_freeing_to_owners() {
    let prefix = installed("owners");
    let packed = prefix.join("walk.mclip");
    let mut scene = mocap::import(SHORT).unwrap();
    mocap::Conversion::new().apply(&mut scene).unwrap();
    let clip = mocap::compress::PackedClip::encode(&scene, 0, 0.00099).unwrap();
    std::fs::write(&packed, clip.bytes()).unwrap();
    let newer = CPP
        .iter()
        .map(|&word| if word == "-std=c++11" { "-std=c++20" } else { word });
    let (newer, program) = (newer.collect::<Vec<_>>(), prefix.join("owners"));
    for compiler in [&newer[..], CPP] {
        compile(compiler, "tests/owners.cpp", &program, &flags(&prefix, &[]));
    }
    let hero = "../../fixtures/skeletons/human_default.gltf";
    let output = prefix.join("mirrored.bvh");
    let _ = std::fs::remove_file(&output);
    let robot = "../../fixtures/robots/h1.urdf";
    let [packed, output] = [&packed, &output].map(|file| file.to_str().unwrap());
    let files = [LECTURE, SHORT, packed, hero, output, robot];
    let expected = path_of_the_wrist(1) + "all is as it should be\n";
    assert_eq!(run(&program, &prefix, &files), expected);
}

/// Builds `examples/cmake` with the shared library and with the static library.
#[test]
fn cmake_finds_the_library() {
    let prefix = installed("cmake");
    for target in ["mocap::mocap", "mocap::static"] {
        let (source, build) = (prefix.join("source"), prefix.join(target.replace("::", "_")));
        for folder in [&source, &build] {
            let _ = std::fs::remove_dir_all(folder);
        }
        std::fs::create_dir_all(&source).unwrap();
        std::fs::copy("examples/cmake/path_of_a_hand.cpp", source.join("path_of_a_hand.cpp")).unwrap();
        let lists = std::fs::read_to_string("examples/cmake/CMakeLists.txt").unwrap();
        let link = "PRIVATE mocap::mocap)";
        assert!(lists.contains(link));
        std::fs::write(
            source.join("CMakeLists.txt"),
            lists.replace(link, &format!("PRIVATE {target})")),
        )
        .unwrap();
        let root = format!(
            "-DCMAKE_PREFIX_PATH={}",
            std::path::absolute(&prefix).unwrap().display()
        );
        succeed(
            Command::new("cmake")
                .arg("-S")
                .arg(&source)
                .arg("-B")
                .arg(&build)
                .arg(root),
        );
        succeed(Command::new("cmake").arg("--build").arg(&build));
        // A tick is 0.1 s. The inferred unit scales the arm to 0.9 m.
        let printed = succeed(Command::new(build.join("path_of_a_hand")).args([LECTURE, "EndSite_Wrist"]));
        let printed = String::from_utf8(printed.stdout).unwrap();
        let found: Vec<f64> = printed.split_whitespace().map(|word| word.parse().unwrap()).collect();
        let expected = path_of_the_wrist(0);
        let expected: Vec<f64> = expected.split_whitespace().map(|word| word.parse().unwrap()).collect();
        let scale = found[0] / expected[0];
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(&expected) {
            assert!(
                (found - scale * expected).abs() < 0.002 * scale.max(1.0),
                "{found} {expected} {scale}"
            );
        }
    }
}

/// The positions of the end of the lecture's arm, from the closed form of its motion; see tests/lecture.c. With `ticks`
/// 1, each line begins with its tick.
fn path_of_the_wrist(ticks: usize) -> String {
    let mut expected = String::new();
    for tick in 0..10u8 {
        let count = f64::from(tick) + 1.0;
        let (mut x, mut y, mut degrees) = (0.1 * count, 0.02 * f64::from(tick), 0.0);
        for (length, turn) in [(2.0, 5.0), (1.5, 10.0), (0.5, 8.0)] {
            degrees += turn * count;
            x += length * f64::to_radians(degrees).cos();
            y += length * f64::to_radians(degrees).sin();
        }
        let tick = [String::new(), format!("{tick} ")][ticks].clone();
        expected += &format!("{tick}{x:.3} {y:.3} 0.000\n");
    }
    expected
}

/// The file is in centimetres with +Z up, and its second bone is turned by 90 degrees; see `fixtures/README.md`.
#[test]
fn a_c_program_reads_fbx() {
    let prefix = installed("rest");
    let program = prefix.join("rest");
    compile(C, "tests/rest.c", &program, &flags(&prefix, &[]));
    let expected = "RootNode -1 0 0 0\nhip 0 0 1000 0\nknee 1 100 1000 0\ntoe 2 100 1000 -100\n";
    assert_eq!(run(&program, &prefix, &["../../fixtures/made/tiny.fbx"]), expected);
}

#[test]
fn a_c_program_puts_poses_on_another_skeleton() {
    let prefix = installed("retarget");
    let program = prefix.join("retarget");
    compile(C, "tests/retarget.c", &program, &flags(&prefix, &[]));
    let files = [
        "../../fixtures/real/cmu_short.bvh",
        "../../fixtures/skeletons/human_default.gltf",
    ];
    assert_eq!(run(&program, &prefix, &files), "the limbs point where they should\n");
}

#[test]
fn a_c_program_plays_a_packed_clip() {
    let mut scene = mocap::import(WALK).unwrap();
    mocap::Conversion::new().apply(&mut scene).unwrap();
    let packed = mocap::compress::PackedClip::encode(&scene, 0, 0.00099).unwrap();
    let prefix = installed("clip");
    let (program, file) = (prefix.join("clip"), prefix.join("walk.mclip"));
    std::fs::write(&file, packed.bytes()).unwrap();
    compile(C, "tests/clip.c", &program, &flags(&prefix, &[]));
    let files = [WALK, file.to_str().unwrap()];
    assert_eq!(run(&program, &prefix, &files), "every joint is where it should be\n");
}

#[test]
fn a_c_program_leads_a_figure() {
    use mocap::matching::{Database, IndexedClip};
    let (hero, walk) = (
        "../../fixtures/real/biovision_example1.bvh",
        "../../fixtures/real/cmu_12_01_walk.bvh",
    );
    let clips = IndexedClip::packed(&mocap::import(walk).unwrap(), "walk.bvh", true).unwrap();
    let prefix = installed("controller");
    let (program, file) = (prefix.join("controller"), prefix.join("walk.mdb"));
    std::fs::write(&file, Database::new(clips).to_bytes()).unwrap();
    compile(C, "tests/controller.c", &program, &flags(&prefix, &[]));
    let files = [hero, walk, file.to_str().unwrap()];
    assert_eq!(run(&program, &prefix, &files), "the figure goes where it is asked to\n");
}

#[test]
fn a_c_program_has_tables_and_reports() {
    let prefix = installed("laboratory");
    let program = prefix.join("laboratory");
    compile(C, "tests/laboratory.c", &program, &flags(&prefix, &[]));
    // Use few frames, because valgrind is slow.
    let markers = prefix.join("markers.trc");
    let _ = std::fs::remove_file(&markers);
    let mut scene = mocap::import("../../fixtures/markers/cmu_01_01.c3d").unwrap();
    mocap::Conversion::new().frame_rate(2.0).apply(&mut scene).unwrap();
    mocap::Exporter::new().export(&scene, &markers).unwrap();
    let output = prefix.join("short.glb");
    // Remove the outputs of earlier runs, which the program would not replace.
    let _ = std::fs::remove_file(&output);
    let files = [
        "../../fixtures/made/plates.c3d",
        markers.to_str().unwrap(),
        WALK,
        SHORT,
        output.to_str().unwrap(),
    ];
    assert_eq!(run(&program, &prefix, &files), "the laboratory has what it asked for\n");
}
