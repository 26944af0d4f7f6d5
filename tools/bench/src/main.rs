//! How fast `mocap` is: beside what bounds it, with one thread and two, and beside its peers. One run, one table.
//!
//! Everything in one block of the table is measured in turns, round by round, so that a busy machine slows all of it
//! alike; what is printed are medians, and ratios of medians.

mod floors;
mod inputs;
mod peers;

use std::error::Error;
use std::fs;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use mocap::gltf::{self, Options};
use mocap::{Importer, Scene, SkeletonMesh, Updater};

type Result<T, E = Box<dyn Error>> = std::result::Result<T, E>;

fn main() -> Result<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    if let [command, threads, input, output] = args.as_slice()
        && command == "convert"
    {
        return convert_and_tell_memory(threads.parse()?, input.as_ref(), output.as_ref());
    }
    let sizes: Vec<usize> = match args.as_slice() {
        [] => vec![1, 20, 200],
        given => given.iter().map(|size| size.parse()).collect::<std::result::Result<_, _>>()?,
    };
    let folder = tempfile::tempdir()?;
    let small = inputs::small(folder.path())?;
    measure("2 KB", &small, 41)?;
    for size in sizes {
        let path = inputs::tile(folder.path(), &format!("{size}.bvh"), size * 1_000_000)?;
        measure(&format!("{size} MB"), &path, if size > 50 { 5 } else { 9 })?;
        fs::remove_file(path)?;
    }
    Ok(())
}

/// One thing that is measured: its seconds, a round each.
struct Stage<'a> {
    name: String,
    run: Box<dyn FnMut() -> Result<()> + 'a>,
    seconds: Vec<f64>,
}

/// The stages of one input.
#[derive(Default)]
struct Stages<'a>(Vec<Stage<'a>>);

impl<'a> Stages<'a> {
    fn add(&mut self, name: impl Into<String>, run: impl FnMut() -> Result<()> + 'a) {
        self.0.push(Stage {
            name: name.into(),
            run: Box::new(run),
            seconds: Vec::new(),
        });
    }

    fn measure(&mut self, rounds: usize) -> Result<()> {
        for _ in 0..rounds {
            for stage in &mut self.0 {
                let start = Instant::now();
                (stage.run)()?;
                stage.seconds.push(start.elapsed().as_secs_f64());
            }
        }
        Ok(())
    }

    fn median(&self, name: &str) -> Option<f64> {
        let stage = self.0.iter().find(|stage| stage.name == name)?;
        let mut seconds = stage.seconds.clone();
        seconds.sort_by(f64::total_cmp);
        Some(seconds[seconds.len() / 2])
    }
}

fn measure(title: &str, path: &Path, rounds: usize) -> Result<()> {
    let text = fs::read(path)?;
    let rows = floors::rows(&text);
    let output = path.with_extension("glb");
    let importer = |threads| Importer::new().skeleton_mesh(SkeletonMesh::Skinned).threads(threads).hash(false);
    let mut scene = importer(1).import(path)?;
    let glb = gltf::write_glb(&scene, &Options::default())?;
    let convert = |threads| -> Result<()> {
        gltf::export(&importer(threads).import(path)?, &output, &Options::default())?;
        Ok(())
    };

    let mocap = peers::mocap();
    let (from, to) = (path.to_string_lossy(), output.to_string_lossy());
    let small_enough = text.len() < 50_000_000;

    let mut stages = Stages::default();
    stages.add("floor: memchr", || {
        black_box(floors::count_lines(black_box(rows)));
        Ok(())
    });
    stages.add("floor: fast-float2", || {
        black_box(floors::tokenise(black_box(rows)));
        Ok(())
    });
    stages.add("floor: writing the output", || Ok(floors::write(&output, &glb)?));
    stages.add("scan, 1 thread", || {
        black_box(mocap::format::bvh::scan(&text)?);
        Ok(())
    });
    for threads in [1, 2] {
        let name = |stage: &str| format!("{stage}, {threads} thread{}", if threads > 1 { "s" } else { "" });
        stages.add(name("import"), move || {
            black_box(importer(threads).import(path)?);
            Ok(())
        });
        stages.add(name("convert"), move || convert(threads));
    }
    stages.add("export", || {
        black_box(gltf::write_glb(&scene, &Options::default())?);
        Ok(())
    });
    if peers::run(&mocap, &["convert", &from, &to]) {
        stages.add("mocap convert", || Ok(require(peers::run(&mocap, &["convert", &from, &to]))?));
    }
    let packed = ["convert", &from, &to, "--threads", "1", "--compress", "meshopt", "--max-error", "1mm"];
    if peers::run(&mocap, &packed) {
        stages.add("mocap convert --compress meshopt --max-error 1mm, 1 thread", || {
            Ok(require(peers::run(&mocap, &packed))?)
        });
    }
    if small_enough && peers::run(Path::new("assimp"), &["export", &from, &to]) {
        stages.add("assimp export", || Ok(require(peers::run(Path::new("assimp"), &["export", &from, &to]))?));
    }
    if bvh_anim::from_bytes(text.as_slice()).is_ok() {
        stages.add("bvh_anim", || {
            black_box(bvh_anim::from_bytes(text.as_slice()).map_err(|error| error.to_string())?);
            Ok(())
        });
    }
    stages.measure(rounds)?;
    let assimp = small_enough.then(|| peers::assimp(path, rounds)).flatten();
    let three = small_enough.then(|| peers::three(path, rounds)).flatten();

    println!("\n{title} ({} bytes, {} out), medians of {rounds}\n", text.len(), glb.len());
    println!("| stage | ms | MB/s | of fast-float2's speed |");
    println!("|---|--:|--:|--:|");
    let floor = stages.median("floor: fast-float2").unwrap_or(f64::NAN);
    let print = |name: &str, seconds: f64| {
        let rate = text.len() as f64 / seconds / 1e6;
        println!("| {name} | {:.3} | {rate:.0} | {:.2} |", seconds * 1e3, floor / seconds);
    };
    for stage in &stages.0 {
        print(&stage.name, stages.median(&stage.name).unwrap_or(f64::NAN));
    }
    if let Some((import, _)) = assimp {
        print("aiImportFile", import);
    }
    if let Some(three) = three {
        print("three.js BVHLoader", three);
    }
    println!();
    let ratio = |what: &str, a: &str, b: &str| {
        if let (Some(a), Some(b)) = (stages.median(a), stages.median(b)) {
            println!("- {what}: {:.2}", a / b);
        }
    };
    ratio("import, speed-up by a second thread", "import, 1 thread", "import, 2 threads");
    ratio("convert, speed-up by a second thread", "convert, 1 thread", "convert, 2 threads");
    ratio("times as fast as `assimp export`", "assimp export", "mocap convert");
    drop(stages);
    if !scene.animations.is_empty() && scene.animations[0].frame_count() > 100 {
        let ours = update_seconds(&mut scene) * 1e9;
        println!("- Updater: {ours:.1} ns a channel");
        if let Some((_, update)) = assimp {
            let theirs = update * 1e9 / scene.animations[0].channels.len() as f64;
            println!("- the course's loop over Assimp: {theirs:.1} ns a channel, {:.1} times ours", theirs / ours);
        }
    }
    for threads in [1, 2] {
        let peak = peak_memory(threads, path, &output)?;
        println!(
            "- peak memory of convert with {threads} threads: {:.1} MB, {:.2} of the input",
            peak as f64 / 1e6,
            peak as f64 / text.len() as f64
        );
    }
    Ok(())
}

fn require(success: bool) -> Result<(), &'static str> {
    if success { Ok(()) } else { Err("a program failed that worked before") }
}

/// Seconds that one channel costs in an update of all node matrices, over every tick of the animation.
fn update_seconds(scene: &mut Scene) -> f64 {
    let Some(updater) = Updater::new(scene, 0) else { return f64::NAN };
    let ticks = scene.animations[0].frame_count().min(2_000);
    let channels = scene.animations[0].channels.len();
    let mut seconds: Vec<f64> = (0..11)
        .map(|_| {
            let start = Instant::now();
            for tick in 0..ticks {
                updater.update(scene, tick as f64);
            }
            start.elapsed().as_secs_f64() / (ticks * channels) as f64
        })
        .collect();
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}

/// The most memory that a process of its own has needed for a conversion, in bytes.
fn peak_memory(threads: usize, input: &Path, output: &Path) -> Result<usize> {
    let child = std::process::Command::new(std::env::current_exe()?)
        .arg("convert")
        .arg(threads.to_string())
        .args([input, output])
        .output()?;
    Ok(String::from_utf8(child.stdout)?.trim().parse()?)
}

fn convert_and_tell_memory(threads: usize, input: &Path, output: &Path) -> Result<()> {
    let importer = Importer::new().skeleton_mesh(SkeletonMesh::Skinned).threads(threads);
    gltf::export(&importer.import(input)?, output, &Options::default())?;
    let status = fs::read_to_string("/proc/self/status")?;
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes: usize = peak.and_then(|peak| peak.trim().strip_suffix(" kB")).ok_or("no VmHWM")?.trim().parse()?;
    println!("{}", kilobytes * 1024);
    Ok(())
}
