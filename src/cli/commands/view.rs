//! `mocap view`: writes a page with a player, or a list of the clips in a folder.

use std::collections::BTreeMap;
use std::env;
use std::io;
use std::path::{Path, PathBuf};

use mocap::edit::ContactOptions;
use mocap::edit::report::DetectedContacts;
use mocap::figure::Figure;
use mocap::render::{Clip, ListingEntry, Page, PageClip};
use mocap::retarget::report::LimbAngles;
use mocap::retarget::robot::add_links;
use mocap::retarget::{PoseRetargetOptions, PoseRetargeter};
use mocap::retarget::{RetargetOptions, Retargeter, Target};
use mocap::scene::Animation;
use mocap::{Code, Conversion, Diagnostic, Exporter, Format, Importer, Scene, SkeletonMesh, gltf};

use super::{Place, check_json, output_format, print_report, short_name, unknown_extension};
use crate::args::ViewArgs;
use crate::batch::folder::make_folder;
use crate::batch::inputs::{self, Input};
use crate::printed::PageReport;
use crate::{Failure, batch, kinds, report, streams};

pub(crate) fn run(args: &ViewArgs) -> Result<(), Failure> {
    let options_are_sound = args.conversion().check();
    options_are_sound.map_err(|error| Failure::Usage(error.diagnostic().message.clone()))?;
    let output = match &args.output {
        Some(output) if !["html", "htm"].contains(&output_format(output, args.to.as_deref(), "html")?.as_str()) => {
            return Err(unknown_extension(output, ".html"));
        }
        Some(output) => {
            check_json(args.json, output)?;
            streams::check_output(&args.files, output, args.force.force)?;
            output.clone()
        }
        None => temporary_folder()?.join(format!("{}.html", short_name(&args.files[0]))),
    };
    let viewed = match args.files.as_slice() {
        [folder] if folder.is_dir() && streams::is_standard(&output) => {
            let message = "a folder gives one page per clip, so the output cannot be -: name an output file";
            Err(Failure::Usage(message.to_owned()))
        }
        [folder] if folder.is_dir() && args.character.is_some() => {
            let message = "--character shows files, not the clips of a folder: name the files";
            Err(Failure::Usage(message.to_owned()))
        }
        [folder] if folder.is_dir() && args.robot.is_some() => {
            let message = "--robot shows files, not the clips of a folder: name the files";
            Err(Failure::Usage(message.to_owned()))
        }
        [folder] if folder.is_dir() => view_folder(args, folder, &output),
        files => view_files(args, files, &output),
    };
    let is_written = matches!(viewed, Ok(()) | Err(Failure::Some));
    if is_written && args.json {
        let output = output.display().to_string();
        print_report(&PageReport { output }, true, Place::Message)?;
    }
    if is_written && args.output.is_none() {
        open_page(&output);
    }
    viewed
}

fn open_page(page: &Path) {
    if open::that(page).is_err() {
        report::say(&format!("no browser was found; open {} in a browser", page.display()));
    }
}

/// Opens a page with a motion before and after a change, each read with its own options.
pub(super) fn before_and_after(before: &ViewArgs, after: &ViewArgs) -> Result<(), Failure> {
    let mut clips = Vec::new();
    for (args, name) in [(before, "before"), (after, "after")] {
        let mut read = read(args, &args.files[0])?;
        read.name = format!("{} ({name})", read.name);
        clips.push(read);
    }
    let page = temporary_folder()?.join(format!("{}.html", short_name(&after.files[0])));
    let pages: Vec<_> = clips.iter().map(PageFile::page_clip).collect();
    streams::write(&page, Page::new(&pages).html.as_bytes())?;
    open_page(&page);
    Ok(())
}

/// A folder that is not removed, because the browser reads from it after this program has ended.
fn temporary_folder() -> Result<PathBuf, Failure> {
    let folder = tempfile::Builder::new().prefix("mocap-").tempdir();
    let no_folder = |error| io::Error::other(format!("no temporary folder: {error}; name an output file with -o"));
    let folder = folder.map_err(|error| Failure::Folder(env::temp_dir(), no_folder(error)))?;
    Ok(folder.keep())
}

fn view_files(args: &ViewArgs, files: &[PathBuf], output: &Path) -> Result<(), Failure> {
    let body = read_body(args)?;
    let mut clips = Vec::new();
    for file in files {
        let mut read = read(args, file)?;
        report::warnings(Some(file), &read.scene.warnings);
        report::clip_taken(&mut read.scene);
        match &body {
            Some(body) => {
                let moved = on_body(&mut read, body, file)?;
                // A robot is shown next to the source, a character instead of the source.
                if let Target::Robot(_) = body.retargeting.target() {
                    clips.push(read);
                }
                clips.push(moved);
            }
            None => clips.push(read),
        }
    }
    if let ([source, target], None) = (clips.as_mut_slice(), &body) {
        target.limb_angles = compare(source, target)?;
        if let Some(limbs) = &target.limb_angles {
            tell_limbs(target, source, limbs);
        }
    }
    let has_large_meshes = |read: &&PageFile| {
        mesh_bytes(&read.scene) > LARGEST_MESHES || (read.glb.is_none() && key_bytes(&read.scene) <= LARGEST_GLB)
    };
    for read in clips.iter().filter(has_large_meshes) {
        let (name, most) = (&read.name, LARGEST_MESHES >> 20);
        report::say(&format!(
            "{name}: the page has no .glb to download, because its meshes have more than {most} MB"
        ));
    }
    let pages: Vec<_> = clips.iter().map(PageFile::page_clip).collect();
    let page = Page::new(&pages);
    streams::write(output, page.html.as_bytes())?;
    for (file, left_out) in files.iter().zip(&page.left_out) {
        for note in left_out {
            report::say(&format!("{}: {note}", file.display()));
        }
    }
    report::say(&format!("{}: {}", output.display(), size(&page)));
    if page.html.len() > LARGE_PAGE {
        report::say("the page is large: to make it smaller, show a part with --trim, or fewer frames with --fps 30");
    }
    Ok(())
}

/// The size of a page; with skins, also the sizes of its parts.
fn size(page: &Page) -> String {
    let whole = format!("{} bytes", page.html.len());
    if page.skins + page.textures == 0 {
        return whole;
    }
    let parts = [
        ("motion", page.motion),
        ("skins", page.skins),
        ("textures", page.textures),
        ("downloads", page.downloads),
    ];
    let parts = parts.map(|(name, bytes)| format!("{name} {:.1} MB", bytes as f64 / 1e6));
    format!("{whole}: {}", parts.join(", "))
}

/// Writes the list to `output`, and the players to a folder next to it.
fn view_folder(args: &ViewArgs, folder: &Path, output: &Path) -> Result<(), Failure> {
    let inputs = inputs::find(&[folder.to_owned()], &args.inputs)?;
    let players = format!("{}_files", short_name(output));
    let link = |input: &Input| format!("{players}/{}.html", input.relative);
    for input in &inputs {
        create_folder_of(&output.with_file_name(link(input)))?;
    }
    let write_player = |input: &Input| -> Result<ListingEntry, mocap::Error> {
        let read = read(args, input.path()?)?;
        let player = output.with_file_name(link(input));
        mocap::files::remove_unfinished(&player);
        mocap::files::write_file(&player, Page::new(&[read.page_clip()]).html.as_bytes())?;
        let clip = Clip {
            name: &input.relative,
            scene: &read.scene,
        };
        Ok(ListingEntry::new(&clip, &link(input)))
    };
    // In the order of the inputs, not in the order of completion.
    let mut entries = BTreeMap::new();
    let mut failed = 0;
    let panicked = |_: &Input| Err(mocap::Error::from(Diagnostic::new(Code::Io, batch::PANICKED)));
    batch::for_each(
        &inputs,
        batch::thread_count(None),
        write_player,
        panicked,
        |index, written| {
            let entry = written.unwrap_or_else(|error| {
                failed += 1;
                report::error(&error);
                ListingEntry::failed(&inputs[index].relative, &error.diagnostic().to_string())
            });
            entries.insert(index, entry);
            Ok::<(), Failure>(())
        },
    )?;
    let entries: Vec<ListingEntry> = entries.into_values().collect();
    streams::write(output, ListingEntry::page(&title_of(folder), &entries).as_bytes())?;
    report::say(&format!("{}: {} files", output.display(), entries.len()));
    match failed {
        0 => Ok(()),
        failed if failed == inputs.len() => Err(Failure::Told),
        _ => Err(Failure::Some),
    }
}

/// The name of a folder, also for paths without one, such as `.` and `..`.
fn title_of(folder: &Path) -> String {
    let whole = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    short_name(&whole)
}

fn create_folder_of(file: &Path) -> Result<(), Failure> {
    let folder = file.parent().unwrap_or(Path::new("."));
    make_folder(folder)
}

/// The most bytes of keys in a page's GLB. A page of a longer take has no GLB.
const LARGEST_GLB: usize = 16 << 20;

/// The most bytes of a page's BVH file. A page of a larger file has no BVH file.
const LARGEST_SOURCE: u64 = 8 << 20;

/// The most bytes of meshes and textures in a page's GLB. A page with more has no GLB. A small file can repeat a mesh
/// many times.
const LARGEST_MESHES: usize = 64 << 20;

/// The bytes of a page from which a note explains how to make it smaller.
const LARGE_PAGE: usize = 60 << 20;

/// A file prepared for a page. Its GLB is in metres with +Y up, as `mocap convert` writes it.
struct PageFile {
    name: String,
    scene: Scene,
    figure: Figure,
    glb: Option<Vec<u8>>,
    /// The original BVH file.
    source: Option<Vec<u8>>,
    contacts: Option<DetectedContacts>,
    limb_angles: Option<Vec<LimbAngles>>,
}

impl PageFile {
    fn new(name: String, scene: Scene, figure: Figure) -> mocap::Result<Self> {
        let mut read = Self {
            name,
            scene,
            figure,
            glb: None,
            source: None,
            contacts: None,
            limb_angles: None,
        };
        read.derive()?;
        Ok(read)
    }

    /// Sets the fields that depend on the motion.
    fn derive(&mut self) -> mocap::Result<()> {
        let is_short = key_bytes(&self.scene) <= LARGEST_GLB && mesh_bytes(&self.scene) <= LARGEST_MESHES;
        let glb = is_short.then(|| glb(&self.scene, &self.figure)).transpose()?;
        self.glb = glb.filter(|glb| glb.len() <= LARGEST_GLB + LARGEST_MESHES);
        // Only a humanoid with a motion has contacts.
        self.contacts = ContactOptions::default()
            .detect(&self.scene, 0, Some(&self.figure.humanoid))
            .ok();
        Ok(())
    }

    /// Drops a rest pose before the motion. Only the search for the T-pose needed this pose.
    fn leave_out_rest_pose(&mut self) -> mocap::Result<()> {
        if Conversion::leave_out_rest_pose(&mut self.scene, &self.figure)? {
            report::say(&format!("{}: the first frame, a rest pose, is dropped", self.name));
            self.derive()?;
        }
        Ok(())
    }

    fn frame_count(&self) -> usize {
        self.scene.animations.first().map_or(0, Animation::frame_count)
    }

    fn page_clip(&self) -> PageClip<'_> {
        PageClip::new(Clip {
            name: &self.name,
            scene: &self.scene,
        })
        .figure(Some(&self.figure))
        .glb(self.glb.as_deref())
        .source(self.source.as_deref())
        .contacts(self.contacts.as_ref())
        .limb_angles(self.limb_angles.as_deref())
    }
}

fn read(args: &ViewArgs, file: &Path) -> Result<PageFile, mocap::Error> {
    let importer = args.read.importer().skeleton_mesh(SkeletonMesh::Skinned);
    let importer = importer.gltf_meshes(true).morph_targets(true);
    let mut scene = importer.at_rate(args.fps, |importer| streams::import(importer, file))?;
    args.source.state(&mut scene);
    let found = Figure::mapped(&scene, &args.map.bones_here());
    let changed = found.and_then(|found| args.conversion().apply_to(&mut scene, &found));
    let (figure, _) = changed.map_err(|error| error.with_path(file))?;
    let source = source_of(&scene, file);
    let read = PageFile::new(short_name(file), scene, figure)?;
    Ok(PageFile { source, ..read })
}

/// The bytes of a BVH file that is small enough for a page. Without these bytes, the page has no button for the file.
fn source_of(scene: &Scene, file: &Path) -> Option<Vec<u8>> {
    let length = std::fs::metadata(file).ok()?.len();
    let is_small = scene.metadata.format == Some(Format::Bvh) && length <= LARGEST_SOURCE;
    is_small.then(|| std::fs::read(file).ok()).flatten()
}

/// The body on which motions are shown.
struct Body {
    name: String,
    retargeting: Retargeter,
}

/// Reads the character or the robot of the arguments.
fn read_body(args: &ViewArgs) -> Result<Option<Body>, Failure> {
    let options = RetargetOptions::new().source_bones(args.map.bones_here());
    let (name, file, target) = match (&args.character, &args.robot) {
        (Some(file), _) => {
            kinds::refuse_robot([file.as_path()])?;
            let importer = Importer::new()
                .skeleton_mesh(SkeletonMesh::Skinned)
                .gltf_meshes(true)
                .morph_targets(true);
            let mut scene = importer.import(file)?;
            // A character needs no motion, so drop this warning.
            scene.warnings.retain(|warning| warning.code != Code::NoMotion);
            report::warnings(Some(file), &scene.warnings);
            (short_name(file), file, Target::from(scene))
        }
        (None, Some(file)) => {
            let robot = Importer::new().robot_meshes(true).import_robot(file)?;
            let of_meshes = |warning: &&Diagnostic| warning.code == Code::IgnoredMesh;
            let of_meshes: Vec<Diagnostic> = robot.warnings.iter().filter(of_meshes).cloned().collect();
            report::warnings(Some(file), &of_meshes);
            (robot.name.clone(), file, Target::from(robot))
        }
        (None, None) => return Ok(None),
    };
    let retargeting = Retargeter::onto(target, options).map_err(|error| error.with_path(file))?;
    Ok(Some(Body { name, retargeting }))
}

/// Retargets a motion to a character or a robot, as `mocap retarget` and `mocap robot` do.
fn on_body(source: &mut PageFile, body: &Body, file: &Path) -> Result<PageFile, Failure> {
    if source.scene.animations.is_empty() {
        let error = mocap::Error::from(Diagnostic::new(Code::NoMotion, "the file contains no motion"));
        return Err(error.with_path(file).into());
    }
    let mut retargeting = body.retargeting.clone();
    let mut scene = source.scene.clone();
    // Only the first motion is shown.
    scene.animations.truncate(1);
    if let Target::Robot(_) = retargeting.target() {
        source.leave_out_rest_pose()?;
    }
    let prepared = retargeting
        .prepare_figure(scene, &source.figure)
        .map_err(|error| error.with_path(file))?;
    let moved = retargeting.add(prepared.named(&source.name));
    if moved.map_err(|error| error.with_path(file))?.is_rest_pose_left_out {
        report::say(&format!("{}: the first frame, a rest pose, is dropped", source.name));
    }
    let name = format!("{} on {}", source.name, body.name);
    let found = &retargeting.clips()[0].report;
    match found.body() {
        Some(_) => print_report(found, false, Place::Message)?,
        None => report::say(&format!("{name}: mean limb error {:.1} degrees", found.mean_degrees())),
    }
    let scene = retargeting.scene();
    let figure = match retargeting.humanoid() {
        Some(bones) => Figure::with_bones(&scene, bones.clone()),
        None => Figure::new(&scene),
    };
    let limb_angles = retargeting.limb_angles(0);
    let mut read = PageFile::new(name, scene, figure)?;
    // The downloaded file only has the links, as `mocap robot` writes them. The picture also has the meshes of the
    // links.
    if let Target::Robot(robot) = retargeting.target() {
        add_links(robot, &mut read.scene);
    }
    Ok(PageFile { limb_angles, ..read })
}

fn retargeter(source: &PageFile, target: &PageFile) -> mocap::Result<PoseRetargeter> {
    let options = PoseRetargetOptions::new()
        .source(source.figure.humanoid.clone())
        .target(target.figure.humanoid.clone());
    PoseRetargeter::new(&source.scene, &target.scene, &options)
}

fn tell_limbs(target: &PageFile, source: &PageFile, limbs: &[LimbAngles]) {
    let degrees = || {
        limbs
            .iter()
            .flat_map(|limb| &limb.degrees)
            .map(|degrees| f64::from(*degrees))
    };
    report::say(&format!(
        "{} against {}: mean limb error {:.2} degrees, {:.2} at most",
        target.name,
        source.name,
        degrees().sum::<f64>() / degrees().count().max(1) as f64,
        degrees().fold(0.0, f64::max)
    ));
}

/// Compares the limbs of two clips, if both are humanoids with the same frames. A rest pose before the first clip is
/// dropped, as `mocap retarget` does.
fn compare(source: &mut PageFile, target: &PageFile) -> mocap::Result<Option<Vec<LimbAngles>>> {
    /// The largest relative difference of equal frame rates: files store frame rates with few digits.
    const SAME_RATE: f64 = 1e-3;
    let Ok(retargeter) = retargeter(source, target) else {
        return Ok(None);
    };
    if source.frame_count() == target.frame_count() + 1 {
        source.leave_out_rest_pose()?;
    }
    let ([from, ..], [to, ..]) = (&source.scene.animations[..], &target.scene.animations[..]) else {
        return Ok(None);
    };
    let rates = to.ticks_per_second / from.ticks_per_second;
    if from.frame_count() != to.frame_count() || (rates - 1.0).abs() > SAME_RATE {
        return Ok(None);
    }
    Ok(Some(retargeter.limb_angles(&source.scene, from, &target.scene, to)))
}

/// The scene as GLB, in metres with +Y up.
fn glb(scene: &Scene, figure: &Figure) -> Result<Vec<u8>, mocap::Error> {
    let mut in_metres = scene.clone();
    Conversion::new().apply_to(&mut in_metres, figure)?;
    // The page lists the assumptions.
    in_metres.metadata.assumptions.clone_from(&scene.metadata.assumptions);
    // A GLB stores each mesh once, however often it is shown.
    if in_metres.original.is_some()
        && let Ok(written) = Exporter::new().write_as(&in_metres, "clip.glb")
    {
        return written.into_bytes();
    }
    gltf::GltfOptions::default().write_glb(&in_metres)
}

/// The approximate bytes of meshes and textures in a GLB.
fn mesh_bytes(scene: &Scene) -> usize {
    // Position, normal, texture coordinates, and four bones with their weights.
    const VERTEX: usize = 12 + 12 + 8 + 8 + 16;
    let meshes = scene.meshes.iter();
    let meshes = meshes.map(|mesh| VERTEX * mesh.vertices.len() + size_of::<u32>() * mesh.indices.len());
    meshes
        .chain(scene.textures.iter().map(|texture| texture.bytes.len()))
        .sum()
}

/// The approximate bytes of the animation in a GLB.
fn key_bytes(scene: &Scene) -> usize {
    let channels = scene.animations.iter().flat_map(|animation| &animation.channels);
    let bytes = channels.map(|channel| {
        12 * channel.position_keys.len() + 16 * channel.rotation_keys.len() + 12 * channel.scaling_keys.len()
    });
    bytes.sum()
}
