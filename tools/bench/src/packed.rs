//! Measures packed clips: their bytes and errors, and the time to decode a pose.

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use mocap::compress::PackedClip;
use mocap::glam::{DQuat, DVec3};
use mocap::gltf::{self, Compression, GltfOptions};
use mocap::scene::Animation;
use mocap::{Binding, Conversion, Importer, Scene, SkeletonMesh, Trs};

use crate::Result;

/// The largest errors, in metres.
const BOUNDS: [f64; 3] = [0.0001, 0.001, 0.005];

/// The number of clips in the round with cold caches, and the number of poses in a round.
const CLIPS: usize = 64;
const POSES: usize = 100_000;

/// Bytes of a joint in one of ACL's raw samples: rotation, translation and scale as floats.
const RAW: usize = 40;

/// The forms of glTF whose encoding is timed.
#[cfg(feature = "meshopt")]
const FORMS: &[Compression] = &[Compression::Int16, Compression::Meshopt, Compression::MeshoptKhr];
#[cfg(not(feature = "meshopt"))]
const FORMS: &[Compression] = &[Compression::Int16];

/// Prints a row for each file and bound with the time of a pose, and then how fast all files are encoded.
pub(crate) fn measure(files: &[&str]) -> Result<()> {
    println!(
        "| clip | frames | nodes | bound, mm | bytes | error, mm | encode, s | poses in order, us | random poses, us | random clips, us |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|");
    for file in files {
        let scene = import(Path::new(file))?;
        if scene.animations.is_empty() {
            continue;
        }
        for bound in BOUNDS {
            let start = Instant::now();
            let clip = PackedClip::encode(&scene, 0, bound)?;
            let seconds = start.elapsed().as_secs_f64();
            let name = Path::new(file).file_stem().unwrap_or_default().to_string_lossy();
            let [ordered, random, cold] = times(&clip)?;
            println!(
                "| {name} | {} | {} | {} | {} | {:.6} | {seconds:.3} | {ordered:.3} | {random:.3} | {cold:.3} |",
                clip.frame_count(),
                clip.node_count(),
                1e3 * bound,
                clip.bytes().len(),
                1e3 * error(&scene, &clip),
            );
        }
    }
    encoding(files)
}

/// Prints how many bytes are encoded in a second of processor time: bytes of raw samples, and bytes of the files.
fn encoding(files: &[&str]) -> Result<()> {
    println!("\n| form | bound, mm | MB of raw samples a second | MB of files a second |");
    println!("|---|--:|--:|--:|");
    let mut scenes = Vec::new();
    for file in files {
        let scene = import(Path::new(file))?;
        let frames = scene.animations.first().map_or(0, Animation::frame_count);
        scenes.push((RAW * frames * scene.nodes.len(), std::fs::metadata(file)?.len(), scene));
    }
    for form in FORMS.iter().map(Some).chain([None]) {
        for bound in BOUNDS {
            let (mut raw, mut bytes) = (0, 0);
            let start = crate::cpu_seconds();
            for (raw_of_scene, bytes_of_file, scene) in &scenes {
                let encoded = match form {
                    Some(compression) => {
                        let options = GltfOptions::new()
                            .compression(*compression)
                            .error_bound(Some(bound.into()));
                        gltf::Document::new(scene, &options).and_then(|document| document.to_glb().map(drop))
                    }
                    None => PackedClip::encode(scene, 0, bound).map(drop),
                };
                // A file without motion is not encoded, nor is a form that is too coarse for the bound.
                if encoded.is_ok() {
                    raw += raw_of_scene;
                    bytes += bytes_of_file;
                }
            }
            let seconds = crate::cpu_seconds()
                .zip(start)
                .map_or(f64::NAN, |(end, start)| end - start);
            println!(
                "| {} | {} | {:.1} | {:.1} |",
                form.map_or("mclip".to_owned(), |form| format!("{form:?}").to_lowercase()),
                1e3 * bound,
                raw as f64 / seconds / 1e6,
                bytes as f64 / seconds / 1e6,
            );
        }
    }
    Ok(())
}

fn import(path: &Path) -> Result<Scene> {
    let mut scene = Importer::new().skeleton_mesh(SkeletonMesh::None).import(path)?;
    Conversion::new().apply(&mut scene)?;
    Ok(scene)
}

/// Positions of all nodes, in double precision.
fn places(parents: &[Option<usize>], pose: &[Trs]) -> Vec<DVec3> {
    let mut world: Vec<(DVec3, DQuat, f64)> = Vec::with_capacity(pose.len());
    for (parent, local) in std::iter::zip(parents, pose) {
        let (translation, rotation) = (local.translation.as_dvec3(), local.rotation.as_dquat().normalize());
        let scale = f64::from(local.scale.x);
        world.push(match parent.map(|parent| world[parent]) {
            None => (translation, rotation, scale),
            Some((place, turn, size)) => (place + turn * (translation * size), turn * rotation, size * scale),
        });
    }
    world.into_iter().map(|(place, ..)| place).collect()
}

/// The largest distance of a joint from its position in the scene, at any frame, in metres.
fn error(scene: &Scene, clip: &PackedClip<'_>) -> f64 {
    let animation = &scene.animations[0];
    let binding = Binding::new(scene, animation);
    let parents: Vec<Option<usize>> = scene
        .nodes
        .iter()
        .map(|node| node.parent.map(mocap::scene::NodeId::index))
        .collect();
    let rest: Vec<Trs> = scene
        .nodes
        .iter()
        .map(|node| Trs::from_matrix(node.transform))
        .collect();
    let mut found = rest.clone();
    let mut largest = 0.0;
    for frame in 0..animation.frame_count() {
        let mut expected = rest.clone();
        binding.sample(animation, frame as f64, |node, trs| expected[node.index()] = trs);
        clip.sample(frame as f64, &mut found);
        for (a, b) in std::iter::zip(places(&parents, &expected), places(&parents, &found)) {
            largest = f64::max(largest, a.distance(b));
        }
    }
    largest
}

/// Microseconds per pose: of one clip in order, of one clip in random order, and of 64 copies of the clip in random
/// order.
fn times(clip: &PackedClip<'_>) -> Result<[f64; 3]> {
    let mut copies = Vec::new();
    for _ in 0..CLIPS {
        copies.push(PackedClip::new(clip.bytes().to_vec())?);
    }
    let mut pose = vec![Trs::IDENTITY; clip.node_count()];
    let mut seed = 1u64;
    let mut random = move || {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (seed >> 33) as f64 / (1u64 << 31) as f64
    };
    let places: Vec<(usize, f64)> = (0..POSES)
        .map(|_| ((random() * CLIPS as f64) as usize, random() * clip.duration()))
        .collect();
    let mut least = [f64::INFINITY; 3];
    for _ in 0..5 {
        for (mode, least) in least.iter_mut().enumerate() {
            let start = Instant::now();
            for (index, (copy, tick)) in places.iter().enumerate() {
                match mode {
                    0 => clip.sample(index as f64 * 0.37 % clip.duration().max(1.0), &mut pose),
                    1 => clip.sample(*tick, &mut pose),
                    _ => copies[*copy].sample(*tick, &mut pose),
                }
                black_box(&mut pose);
            }
            *least = least.min(1e6 * start.elapsed().as_secs_f64() / POSES as f64);
        }
    }
    Ok(least)
}
