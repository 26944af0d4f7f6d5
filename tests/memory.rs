//! The memory of an import depends on the bytes that the file has, not on the counts that the file states.
//!
//! The allocator counts for the whole process, so all cases are in one test.

#[path = "memory/containers.rs"]
mod containers;
#[path = "memory/long_takes.rs"]
mod long_takes;

use std::fs;

use mocap::compress::PackedClip;
use mocap::{Importer, Limits, Scene, SkeletonMesh, Trs};
use peak_alloc::PeakAlloc;

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// Bytes of memory for each byte of input, without and with a skeleton mesh.
///
/// The densest input is a joint in 20 characters, `ROOT a{OFFSET 0 1 0}`. The reader makes a node and a channel of some
/// 500 bytes from it. The mesh adds a pointer on the joint's parent (12 vertices with normals and indices, 336 bytes)
/// and the joint's own knob (24 vertices, 672 bytes). During the construction of the mesh, the corners of both are also
/// in memory.
const FACTORS: [(SkeletonMesh, usize); 2] = [(SkeletonMesh::None, 32), (SkeletonMesh::Segmented, 128)];

/// Bytes of memory for each byte of any input, as `SECURITY.md` promises.
const PROMISED: usize = 64;

/// Bytes of memory for a value of the motion and for a node. `SECURITY.md` promises this in addition, because few bytes
/// can state many values and nodes.
const OF_VALUE: usize = 64;
const OF_NODE: usize = 1024;

/// Bytes that every import may use, however small the file: tables, messages, and the growth of the first lists.
const BASE: usize = 64 * 1024;

/// Imports `bytes`. Returns the peak of the additional memory, and the memory that the values and nodes of the motion
/// may use.
fn peak(importer: &Importer, bytes: &[u8], name: &str) -> (usize, usize) {
    let before = ALLOCATOR.current_usage();
    ALLOCATOR.reset_peak_usage();
    let result = importer.read(bytes, name);
    let peak = ALLOCATOR.peak_usage() - before;
    (peak, result.as_ref().map_or(0, allowed))
}

/// The memory that the values and the nodes of a motion may use.
fn allowed(scene: &Scene) -> usize {
    let channels = scene.animations.iter().flat_map(|animation| &animation.channels);
    let keys = channels.map(|channel| {
        [
            channel.position_keys.values.len(),
            channel.rotation_keys.values.len(),
            channel.scaling_keys.values.len(),
        ]
    });
    // A key has three numbers of the file.
    let values = 3 * keys.flatten().sum::<usize>();
    OF_VALUE * values + OF_NODE * scene.nodes.len()
}

fn claims() -> Vec<(&'static str, String)> {
    let motion =
        |channels: &str, motion: &str| format!("HIERARCHY\nROOT a\n{{\nOFFSET 0 1 0\n{channels}\n}}\nMOTION\n{motion}");
    let rows = "1 2 3 4 5 6\n".repeat(1000);
    let six = "CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation";
    vec![
        (
            "frames without rows",
            motion(six, "Frames: 4000000000\nFrame Time: .1\n"),
        ),
        (
            "frames within the limit",
            motion(six, "Frames: 170000000\nFrame Time: .1\n1 2 3 4 5 6\n"),
        ),
        (
            "frames of nothing",
            motion("CHANNELS 0", "Frames: 100000000\nFrame Time: .1\n"),
        ),
        (
            "frames of nothing at all",
            motion("", "Frames: 18446744073709551615\nFrame Time: .1\n"),
        ),
        (
            "frames beyond any number",
            motion(six, &format!("Frames: 1{}\nFrame Time: .1\n", "0".repeat(400))),
        ),
        (
            "channels without names",
            motion("CHANNELS 1000000000", "Frames: 1\nFrame Time: .1\n1\n"),
        ),
        (
            "channels beyond any number",
            motion("CHANNELS 99999999999999999999", "Frames: 1\nFrame Time: .1\n1\n"),
        ),
        (
            "rows, and a claim of many more",
            motion(six, &format!("Frames: 100000000\nFrame Time: .1\n{rows}")),
        ),
        (
            "rows of one digit",
            motion(
                "CHANNELS 1 Zrotation",
                &format!("Frames: 50000\nFrame Time: 1\n{}", "7\n".repeat(50_000)),
            ),
        ),
        (
            "rows of wrong length",
            motion(
                six,
                &format!("Frames: 20000\nFrame Time: 1\n{}", "7\n7 7\n".repeat(10_000)),
            ),
        ),
        (
            "rows of NaN",
            motion(
                six,
                &format!(
                    "Frames: 9000\nFrame Time: 1\n{}",
                    "nan nan nan nan nan nan\n".repeat(9000)
                ),
            ),
        ),
        (
            "nested joints",
            format!("HIERARCHY\nROOT r{{{}", "JOINT a{OFFSET 0 1 0 ".repeat(100_000)),
        ),
        (
            "sibling joints",
            format!("HIERARCHY\nROOT r{{{}}}", "JOINT a{OFFSET 0 1 0}".repeat(60_000)),
        ),
        (
            "end sites",
            format!("HIERARCHY\nROOT r{{{}}}", "End Site{OFFSET 0 1 0}".repeat(60_000)),
        ),
        (
            "one name of a megabyte",
            format!("HIERARCHY\nROOT {}\n{{", "a".repeat(1 << 20)),
        ),
        (
            "a long name with end sites",
            format!(
                "HIERARCHY\nROOT {}\n{{{}}}",
                "a".repeat(20_000),
                "End Site{}".repeat(5_000)
            ),
        ),
        (
            "one word of a megabyte",
            motion(six, &format!("Frames: 1\nFrame Time: 1\n{}", "9".repeat(1 << 20))),
        ),
        (
            "channels of one joint",
            motion(
                &format!("CHANNELS 50000{}", " Zrotation".repeat(50_000)),
                "Frames: 0\nFrame Time: 1\n",
            ),
        ),
        (
            "offsets of one joint",
            motion(&"OFFSET 0 1 0\n".repeat(50_000), "Frames: 0\nFrame Time: 1\n"),
        ),
        (
            "roots",
            format!("HIERARCHY\n{}", "ROOT a{OFFSET 0 1 0}\n".repeat(50_000)),
        ),
        ("closing braces", format!("HIERARCHY\nROOT a{{{}", "}".repeat(500_000))),
        ("blank lines", "\n".repeat(1 << 20)),
        ("comments", "#\n".repeat(1 << 19)),
        ("no text at all", "\0".repeat(1 << 20)),
    ]
}

/// A packed clip without motion that states this number of frames.
fn frames_of_a_still_clip(frames: u32) -> Vec<u8> {
    let text = "HIERARCHY ROOT a { OFFSET 0 1 0 CHANNELS 1 Zrotation } MOTION Frames: 2 Frame Time: 1 5 5";
    let scene = Importer::new().read(text.as_bytes(), "still.bvh").unwrap();
    let clip = PackedClip::encode(&scene, 0, 0.001).unwrap();
    let mut bytes = clip.bytes().to_vec();
    bytes[12..16].copy_from_slice(&frames.to_le_bytes());
    bytes[24..32].copy_from_slice(&f64::from(frames - 1).to_le_bytes());
    bytes
}

/// A dance with few keys that state many frames.
fn few_keys_of_many_frames() -> Vec<u8> {
    let mut dance = fs::read("fixtures/made/dancer.vmd").unwrap();
    // The keys of bones follow the header and the number of keys. Each key has 111 bytes: the name, then the frame.
    let keys = usize::from(dance[50]);
    for key in dance[54..].chunks_exact_mut(111).take(keys) {
        let frame = u32::from_le_bytes(key[15..19].try_into().unwrap());
        key[15..19].copy_from_slice(&(100 * frame).to_le_bytes());
    }
    dance
}

/// An open packed clip uses less than 64 KiB in addition to its file, and sampling allocates nothing.
fn hold_a_packed_clip(failures: &mut String) {
    let mut scene = mocap::import("fixtures/real/cmu_short.bvh").unwrap();
    mocap::Conversion::new().apply(&mut scene).unwrap();
    let packed = PackedClip::encode(&scene, 0, 0.005).unwrap();
    let bytes = packed.bytes().to_vec();
    drop((packed, scene));
    let before = ALLOCATOR.current_usage();
    ALLOCATOR.reset_peak_usage();
    let clip = PackedClip::new(&*bytes).unwrap();
    let mut pose = [Trs::IDENTITY; 100];
    for tick in 0..100 {
        clip.sample(f64::from(tick) * 0.7, &mut pose);
    }
    let peak = ALLOCATOR.peak_usage() - before;
    if peak > 64 * 1024 {
        *failures += &format!("cmu_short.mclip takes {peak} bytes\n");
    }
}

/// The memory of commands with a long take, in addition to the keys.
fn hold_long_takes(failures: &mut String) {
    for (name, most, noise, run) in long_takes::CASES {
        let scene = long_takes::take(noise);
        let keys = long_takes::bytes(&scene) as f64;
        let before = ALLOCATOR.current_usage();
        ALLOCATOR.reset_peak_usage();
        run(scene);
        let times = (ALLOCATOR.peak_usage() - before) as f64 / keys;
        if times > most {
            *failures += &format!("{name} of a long take takes {times:.2} times its keys, more than {most}\n");
        }
    }
}

/// The start of a C3D file that states 65,535 points in a frame and has none of them.
fn many_points() -> Vec<u8> {
    let mut bytes = fs::read("fixtures/real/optotrak.c3d").unwrap();
    bytes.truncate(5310);
    let used = bytes.windows(4).position(|four| four == b"USED").unwrap();
    // After the name: the offset of the next parameter, the type, and the number of dimensions.
    bytes[used + 8..][..2].copy_from_slice(&[0xFF, 0xFF]);
    bytes
}

#[test]
fn memory_is_a_small_multiple_of_the_input() {
    let mut failures = String::new();
    let mut hold = |limits: Limits, name: &str, bytes: &[u8]| {
        for (mesh, factor) in FACTORS {
            let importer = Importer::new().limits(limits).skeleton_mesh(mesh);
            let (peak, allowed) = peak(&importer, bytes, "claims.bvh");
            let budget = BASE + bytes.len() * factor;
            let promised = BASE + bytes.len() * PROMISED + allowed;
            if peak > budget.min(promised) {
                failures += &format!(
                    "{name}, {mesh:?}: {} bytes take {peak}, more than {budget} or {promised}\n",
                    bytes.len()
                );
            }
        }
    };
    let endless = Limits::new()
        // A long name may occur in each child of its node, so this limit bounds the memory.
        .max_name_bytes(Limits::default().max_name_bytes)
        .max_bytes(u64::MAX)
        .max_nodes(usize::MAX)
        .max_depth(usize::MAX)
        .max_values(u64::MAX);
    for (name, text) in claims() {
        hold(Limits::default(), name, text.as_bytes());
        hold(endless, &format!("{name}, without limits"), text.as_bytes());
    }
    for name in [
        "cmu_12_01_walk",
        "kinect_openni",
        "makehuman_fly_one_frame",
        "brackets_in_numbers",
        "nan_tokens",
    ] {
        hold(
            Limits::default(),
            name,
            &fs::read(format!("fixtures/real/{name}.bvh")).unwrap(),
        );
    }
    hold(Limits::default(), "C3D points that are not there", &many_points());
    hold(
        Limits::default(),
        "frames of a packed clip that are not there",
        &frames_of_a_still_clip(1_000_000_000),
    );
    hold_a_packed_clip(&mut failures);
    hold_long_takes(&mut failures);
    let bytes = few_keys_of_many_frames();
    for mesh in [SkeletonMesh::None, SkeletonMesh::Segmented] {
        let (peak, allowed) = peak(&Importer::new().skeleton_mesh(mesh), &bytes, "dance.vmd");
        let of_bytes = BASE + PROMISED * bytes.len();
        assert!(allowed > 2 * of_bytes, "the bytes alone would allow nearly as much");
        if peak > of_bytes + allowed {
            failures += &format!(
                "dance.vmd, {mesh:?}: {} bytes take {peak}, with {allowed}\n",
                bytes.len()
            );
        }
    }
    for (word, bytes) in containers::archives() {
        let error = Importer::new().read(&bytes, "claims.npz").unwrap_err();
        assert!(format!("{error:?}").contains(word), "{error}");
    }
    for (extension, inputs) in [("pkl", containers::pickles()), ("npz", containers::archives())] {
        for (name, bytes) in inputs {
            let (peak, _) = peak(&Importer::new(), &bytes, &format!("claims.{extension}"));
            if peak > BASE + PROMISED * bytes.len() {
                failures += &format!("{name}.{extension}: {} bytes take {peak}\n", bytes.len());
            }
        }
    }
    assert!(failures.is_empty(), "\n{failures}");
}
