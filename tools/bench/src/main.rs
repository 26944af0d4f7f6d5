//! Compares the speed of `mocap` with lower bounds and with its peers, on one thread and on two.
//!
//! All stages of one block of the table are measured in turns, round by round, so that a busy machine slows all of them
//! alike. The table has the least time and the median of each stage. Other work on the machine only adds time, so the
//! targets are compared with ratios of least times.

mod edit;
mod feet;
mod floors;
mod inputs;
mod packed;
mod peers;
mod retarget;

use std::error::Error;
use std::fs;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use mocap::gltf::GltfOptions;
use mocap::{Conversion, Exporter, Importer, Scene, SkeletonMesh, Updater};

/// The stage that compresses within a largest error.
const PACKING: &str = "mocap convert --compress meshopt --max-error 1mm, 1 thread";

type Result<T, E = Box<dyn Error>> = std::result::Result<T, E>;

fn main() -> Result<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    if let [command, threads, input, output] = args.as_slice()
        && command == "convert"
    {
        return convert_and_tell_memory(threads.parse()?, input.as_ref(), output.as_ref());
    }
    match args.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["edit"] => return edit::measure(15),
        ["feet"] => return feet::measure(),
        ["packed", ref files @ ..] => return packed::measure(files),
        ["retarget"] => return retarget::measure(7),
        _ => {}
    }
    let sizes: Vec<usize> = match args.as_slice() {
        [] => vec![1, 20, 200],
        given => given
            .iter()
            .map(|size| size.parse())
            .collect::<std::result::Result<_, _>>()?,
    };
    let folder = tempfile::tempdir()?;
    let small = inputs::small(folder.path())?;
    measure("2 KB", &small, 41)?;
    for size in sizes {
        let path = inputs::tile(folder.path(), &format!("{size}.bvh"), size * 1_000_000)?;
        measure(&format!("{size} MB"), &path, if size > 50 { 7 } else { 21 })?;
        fs::remove_file(path)?;
    }
    Ok(())
}

/// One measured stage: its seconds in each round.
struct Stage<'a> {
    name: String,
    run: Box<dyn FnMut() -> Result<()> + 'a>,
    seconds: Vec<f64>,
    /// CPU time of the measuring thread, without other threads and programs.
    cpu_seconds: Vec<f64>,
}

/// The CPU time of this thread, if the system provides it.
pub(crate) fn cpu_seconds() -> Option<f64> {
    // The kernel updates the count when it schedules.
    std::thread::yield_now();
    let text = fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    Some(text.split(' ').next()?.parse::<f64>().ok()? / 1e9)
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
            cpu_seconds: Vec::new(),
        });
    }

    fn measure(&mut self, rounds: usize) -> Result<()> {
        for _ in 0..rounds {
            for stage in &mut self.0 {
                let cpu_start = cpu_seconds();
                let start = Instant::now();
                (stage.run)()?;
                stage.seconds.push(start.elapsed().as_secs_f64());
                stage
                    .cpu_seconds
                    .extend(cpu_seconds().zip(cpu_start).map(|(end, start)| end - start));
            }
        }
        Ok(())
    }

    /// The least time and the median of a stage.
    fn seconds(&self, name: &str) -> Option<(f64, f64)> {
        let stage = self.0.iter().find(|stage| stage.name == name)?;
        let mut seconds = stage.seconds.clone();
        seconds.sort_by(f64::total_cmp);
        Some((seconds[0], seconds[seconds.len() / 2]))
    }

    /// The least CPU time of a stage with one thread.
    fn cpu_seconds(&self, name: &str) -> Option<f64> {
        let stage = self.0.iter().find(|stage| stage.name == name)?;
        stage.cpu_seconds.iter().copied().min_by(f64::total_cmp)
    }

    /// The ratio of the least times of `a` and `b`.
    fn ratio(&self, a: &str, b: &str) -> Option<f64> {
        Some(self.seconds(a)?.0 / self.seconds(b)?.0)
    }
}

/// The target of a figure.
#[derive(Clone, Copy)]
enum Wanted {
    AtLeast(f64),
    AtMost(f64),
}

/// Prints a figure beside its target, if there is one for inputs of this size.
fn print_figure(what: &str, measured: Option<f64>, wanted: Option<Wanted>) {
    let Some(measured) = measured else { return };
    let (bound, is_reached) = match wanted {
        Some(Wanted::AtLeast(least)) => (format!("at least {least}"), measured >= least),
        Some(Wanted::AtMost(most)) => (format!("at most {most}"), measured <= most),
        None => {
            println!("| {what} | {measured:.2} | - |");
            return;
        }
    };
    let verdict = if is_reached { "reached" } else { "missed" };
    println!("| {what} | {measured:.2} | {bound}: {verdict} |");
}

fn measure(title: &str, path: &Path, rounds: usize) -> Result<()> {
    let text = fs::read(path)?;
    let rows = floors::rows(&text);
    let output = path.with_extension("glb");
    let importer = |threads| {
        Importer::new()
            .skeleton_mesh(SkeletonMesh::Skinned)
            .threads(threads)
            .hash(false)
    };
    let mut scene = importer(1).import(path)?;
    let glb = GltfOptions::default().write_glb(&scene)?;
    let convert = |threads| -> Result<()> {
        let mut scene = importer(threads).import(path)?;
        Conversion::new().apply(&mut scene)?;
        Exporter::new().overwrite(true).export(&scene, &output)?;
        Ok(())
    };

    let mocap = peers::mocap();
    let (from, to) = (path.to_string_lossy(), output.to_string_lossy());
    // `mocap` refuses this option if it was built without meshopt.
    let packed = [
        "convert",
        &from,
        &to,
        "--threads",
        "1",
        "--compress",
        "meshopt",
        "--max-error",
        "1mm",
    ];
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
    for threads in [1, 2] {
        let name = |stage: &str| format!("{stage}, {threads} thread{}", if threads > 1 { "s" } else { "" });
        stages.add(name("import"), move || {
            black_box(importer(threads).import(path)?);
            Ok(())
        });
        stages.add(name("import with SHA-256"), move || {
            black_box(importer(threads).hash(true).import(path)?);
            Ok(())
        });
        stages.add(name("convert"), move || convert(threads));
    }
    stages.add("export", || {
        black_box(GltfOptions::default().write_glb(&scene)?);
        Ok(())
    });
    if peers::run(&mocap, &["convert", &from, &to]) {
        stages.add("mocap convert", || {
            Ok(require(peers::run(&mocap, &["convert", &from, &to]))?)
        });
    }
    if peers::run(&mocap, &packed) {
        stages.add(PACKING, || Ok(require(peers::run(&mocap, &packed))?));
    }
    if small_enough && peers::run(Path::new("assimp"), &["export", &from, &to]) {
        stages.add("assimp export", || {
            Ok(require(peers::run(Path::new("assimp"), &["export", &from, &to]))?)
        });
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

    println!("\n{title} ({} bytes, {} out), {rounds} rounds\n", text.len(), glb.len());
    println!("| stage | least ms | median ms | MB/s | of fast-float2's speed |");
    println!("|---|--:|--:|--:|--:|");
    let floor = stages.seconds("floor: fast-float2").ok_or("no floor")?.0;
    let print = |name: &str, least: Option<f64>, median: f64| {
        let seconds = least.unwrap_or(median);
        let rate = text.len() as f64 / seconds / 1e6;
        let least = least.map_or("-".to_owned(), |least| format!("{:.3}", least * 1e3));
        println!(
            "| {name} | {least} | {:.3} | {rate:.0} | {:.2} |",
            median * 1e3,
            floor / seconds
        );
    };
    for stage in &stages.0 {
        let (least, median) = stages.seconds(&stage.name).ok_or("a stage was not measured")?;
        print(&stage.name, Some(least), median);
    }
    if let Some((import, _)) = assimp {
        print("aiImportFile", None, import);
    }
    if let Some(three) = three {
        print("three.js BVHLoader", None, three);
    }
    println!("\n| figure | measured | wanted |\n|---|--:|--:|");
    // A small file measures only start-up.
    let wanted = |figure: f64| (text.len() > 10_000_000).then_some(Wanted::AtLeast(figure));
    let floor = "floor: fast-float2";
    print_figure(
        "import with 1 thread, of the floor",
        stages.ratio(floor, "import, 1 thread"),
        wanted(0.5),
    );
    for (stage, figure) in [("import", Some(1.6)), ("import with SHA-256", None), ("convert", None)] {
        let (one, two) = (format!("{stage}, 1 thread"), format!("{stage}, 2 threads"));
        let figure = figure.and_then(wanted);
        print_figure(&format!("{stage}, 2 threads to 1"), stages.ratio(&one, &two), figure);
    }
    // For a small file, the target is not to be slower.
    let not_slower = (text.len() < 10_000).then_some(Wanted::AtLeast(1.0));
    print_figure(
        "times as fast as `assimp export`",
        stages.ratio("assimp export", "mocap convert"),
        wanted(8.0).or(not_slower),
    );
    // The whole program, reading and writing included.
    let packing = stages
        .seconds(PACKING)
        .map(|(least, _)| text.len() as f64 / least / 1e6);
    print_figure("within 1 mm in streams, 1 thread, MB/s", packing, wanted(80.0));
    for threads in [1, 2] {
        let peak = peak_memory(threads, path, &output)? as f64;
        let name = format!(
            "peak memory of convert --threads {threads}, {:.1} MB, of the input",
            peak / 1e6
        );
        // The program itself uses a few MB.
        let most = (text.len() > 100_000_000).then_some(Wanted::AtMost(1.3));
        print_figure(&name, Some(peak / text.len() as f64), most);
    }
    println!();
    for stage in ["import, 1 thread", "import with SHA-256, 1 thread"] {
        if let (Some(ours), Some(floor)) = (stages.cpu_seconds(stage), stages.cpu_seconds(floor)) {
            println!("- {stage}, in time of the processor: {:.2} of the floor", floor / ours);
        }
    }
    drop(stages);
    if !scene.animations.is_empty() && scene.animations[0].frame_count() > 100 {
        let ours = update_seconds(&mut scene) * 1e9;
        println!("- Updater: {ours:.1} ns a channel");
        if let Some((_, update)) = assimp {
            let theirs = update * 1e9 / scene.animations[0].channels.len() as f64;
            println!(
                "- the course's loop over Assimp: {theirs:.1} ns a channel, {:.1} times ours",
                theirs / ours
            );
        }
    }
    Ok(())
}

fn require(success: bool) -> Result<(), &'static str> {
    if success {
        Ok(())
    } else {
        Err("a program failed that worked before")
    }
}

/// Seconds that one channel costs in an update of all node matrices, over every tick of the animation.
fn update_seconds(scene: &mut Scene) -> f64 {
    let Some(updater) = Updater::new(scene, 0) else {
        return f64::NAN;
    };
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

/// The peak memory of a separate process for a conversion, in bytes.
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
    let mut scene = importer.import(input)?;
    Conversion::new().apply(&mut scene)?;
    Exporter::new().overwrite(true).export(&scene, output)?;
    let status = fs::read_to_string("/proc/self/status")?;
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes: usize = peak
        .and_then(|peak| peak.trim().strip_suffix(" kB"))
        .ok_or("no VmHWM")?
        .trim()
        .parse()?;
    println!("{}", kilobytes * 1024);
    Ok(())
}
