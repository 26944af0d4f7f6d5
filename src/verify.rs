//! Verifies a written glTF file: the position of every joint in every frame, against its source.
//!
//! Both sides are computed in double precision, and the file is read back by the `gltf` crate, which did not write it.
//! The time of a frame is rounded to 32 bits, as in glTF. The intended changes of the conversion (unit, up axis, trim,
//! frame rate, in place) are in the file's [`Provenance`], and are applied to the source as well. A file of another
//! program has none: then the unit follows from the lengths of the links, the up axis is the one that fits the first
//! frame better, and the motion is assumed to start with the source's first frame.

mod chain;

use std::collections::{HashMap, VecDeque};
use std::path::Path;

use glam::{DMat4, DVec3};
use serde::Serialize;

use self::chain::Skeleton;
use crate::error::{Code, Diagnostic, Result};
use crate::format::gltf::File;
use crate::format::gltf::Provenance;
use crate::import::{Clips, Importer};
use crate::limits::Limits;
use crate::process::SkeletonMesh;
use crate::scene::{AppliedStep, NodeKind, Scene, UpAxis};
use crate::skeleton;

/// The differences between a written file and its source.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Verification {
    /// The number of frames compared: those within the file's duration.
    pub frames: usize,
    /// The number of joints and end sites compared.
    pub joints: usize,
    /// The largest distance of a joint from its position in the source, in metres.
    pub max_error: f64,
    /// The root of the mean square of all distances, in metres.
    pub rms_error: f64,
    /// The joint and the time of the largest distance. Absent if nothing was compared.
    pub worst: Option<Worst>,
    /// Joints of the source that the file does not have.
    pub missing: Vec<String>,
    /// End sites of the source that the file does not have; many programs leave them out.
    pub missing_end_sites: Vec<String>,
    /// Metres per unit of the source.
    pub metres_per_unit: f64,
    /// Whether the file states how it was converted.
    pub has_provenance: bool,
}

/// The joint and the time of the largest distance.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Worst {
    /// The joint, by its name in the source.
    pub joint: String,
    /// The frame of the source.
    pub frame: usize,
    /// Seconds from the start of the file.
    pub seconds: f64,
}

/// Compares a written file with its source file. The source is read with the options of the conversion, if the written
/// file states them.
///
/// # Errors
/// Where one of the two cannot be read, or they have no joint in common.
pub fn verify_files(source: impl AsRef<Path>, output: impl AsRef<Path>) -> Result<Verification> {
    let output = output.as_ref();
    let opener = Importer::new();
    let bytes = opener.open(output)?;
    let file = read(&bytes, &|sibling| opener.open(&output.with_file_name(sibling)));
    let file = file.map_err(|error| error.with_path(output))?;
    let importer = file
        .provenance()
        .map(|provenance| provenance.importer())
        .unwrap_or_default();
    let scene = importer.skeleton_mesh(SkeletonMesh::None).import(source)?;
    verify_file(&scene, &file).map_err(|error| error.with_path(output))
}

/// Compares `output`, the bytes of a `.glb` or of a `.gltf` with an embedded buffer, with `source`, the imported scene
/// before any step that changes positions or times.
///
/// ```
/// use mocap::gltf::{Options, write_glb};
/// use mocap::verify::verify;
///
/// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
/// let verified = verify(&scene, &write_glb(&scene, &Options::default())?)?;
/// assert_eq!((verified.frames, verified.joints), (10, 4));
/// assert!(verified.max_error < 1e-6);
/// # Ok::<(), mocap::Error>(())
/// ```
///
/// # Errors
/// Where the bytes are not valid glTF, have their buffer in another file, or have no joint in common with `source`.
pub fn verify(source: &Scene, output: &[u8]) -> Result<Verification> {
    let refuse = |other: &Path| {
        let message = format!("the buffer is in another file, \"{}\"", other.display());
        Err(Diagnostic::new(Code::InvalidGltf, message)
            .help("call verify_files with the paths")
            .into())
    };
    verify_file(source, &read(output, &refuse)?)
}

/// Reads the file to compare, with a helpful error for a file of another format.
fn read<'a>(bytes: &'a [u8], open: &dyn Fn(&Path) -> Result<Vec<u8>>) -> Result<File<'a>> {
    if !File::sniff(bytes) {
        return Err(
            Diagnostic::new(Code::InvalidGltf, "the second file must be a glTF file")
                .help("give the source file first, then the .glb or .gltf made from it")
                .into(),
        );
    }
    File::read(bytes, open, &Limits::default())
}

fn verify_file(source: &Scene, file: &File<'_>) -> Result<Verification> {
    let provenance = file.provenance();
    let ours = Skeleton::of_scene(source);
    let theirs = Skeleton::of_file(file)?;
    let pairs = pairs(&ours, &theirs);
    if pairs.is_empty() {
        let message = "no joint of the source is in the file";
        return Err(Diagnostic::new(Code::Unrepresentable, message)
            .help("compare it with the file it was made from")
            .into());
    }
    let change = match &provenance {
        Some(provenance) => Change::recorded(&provenance.steps),
        None => Change::guessed(&ours, &theirs, &pairs),
    };
    let missing = |kind: NodeKind| {
        let is_missing = |(index, joint): &(usize, &chain::Joint)| {
            joint.kind == kind && !pairs.iter().any(|(ours, _)| ours == index)
        };
        ours.joints
            .iter()
            .enumerate()
            .filter(is_missing)
            .map(|(_, joint)| joint.name.clone())
            .collect()
    };
    let mut verification = Verification {
        frames: 0,
        joints: pairs.len(),
        max_error: 0.0,
        rms_error: 0.0,
        worst: None,
        missing: missing(NodeKind::Joint),
        missing_end_sites: missing(NodeKind::EndSite),
        metres_per_unit: change.metres_per_unit,
        has_provenance: provenance.is_some(),
    };
    compare(source, &ours, &theirs, &pairs, &change, &mut verification);
    Ok(verification)
}

impl Provenance {
    /// An importer with the options of the conversion.
    fn importer(&self) -> Importer {
        let mut importer = Importer::new();
        if let Some(used) = &self.root_offset {
            importer = importer.root_offset(used.policy);
        }
        if let Some(origin) = self.source.as_ref().filter(|origin| origin.frame_time > 0.0) {
            importer = importer.frame_rate(origin.frame_time.recip());
        }
        for step in &self.steps {
            if let AppliedStep::SelectClip { index } = step {
                importer = importer.clips(Clips::Index(*index));
            }
        }
        importer
    }
}

/// Pairs the joints of two skeletons by name; the n-th joint of a name belongs to the n-th of that name. Unique names
/// may also differ in case and in characters that are neither letters nor digits.
fn pairs(ours: &Skeleton, theirs: &Skeleton) -> Vec<(usize, usize)> {
    let simplified = |name: &str| {
        name.chars()
            .filter(|c| c.is_alphanumeric())
            .flat_map(char::to_lowercase)
            .collect()
    };
    let exact = match_names(ours, theirs, std::borrow::ToOwned::to_owned);
    let loose = match_names(ours, theirs, simplified);
    if loose.len() > exact.len() { loose } else { exact }
}

fn match_names(ours: &Skeleton, theirs: &Skeleton, key: impl Fn(&str) -> String) -> Vec<(usize, usize)> {
    let mut places: HashMap<(String, bool), VecDeque<usize>> = HashMap::new();
    // Other programs do not mark end sites, so the kind of a node is compared only if the file has marks.
    let marks = theirs.joints.iter().any(|joint| joint.kind == NodeKind::EndSite);
    let key = |joint: &chain::Joint| (key(&joint.name), marks && joint.kind == NodeKind::EndSite);
    for (place, joint) in theirs.joints.iter().enumerate() {
        places.entry(key(joint)).or_default().push_back(place);
    }
    let sources = ours
        .joints
        .iter()
        .enumerate()
        .filter(|(_, joint)| joint.kind != NodeKind::Group);
    sources
        .filter_map(|(index, joint)| Some((index, places.get_mut(&key(joint))?.pop_front()?)))
        .collect()
}

/// The intended changes between a source and a file.
struct Change {
    metres_per_unit: f64,
    up: UpAxis,
    /// The ticks of the source at the file's start and end.
    first: f64,
    last: f64,
    /// The frame rate of the file, where it is not the source's.
    frames_per_second: Option<f64>,
    in_place: bool,
}

impl Change {
    fn none() -> Self {
        Self {
            metres_per_unit: 1.0,
            up: UpAxis::Y,
            first: 0.0,
            last: f64::INFINITY,
            frames_per_second: None,
            in_place: false,
        }
    }

    /// The recorded steps. Resampling should not move a joint at the time of a frame; differences count as error.
    fn recorded(steps: &[AppliedStep]) -> Self {
        let mut change = Self::none();
        for step in steps {
            match *step {
                AppliedStep::ConvertUnits { metres_per_unit, up } => {
                    change.metres_per_unit *= metres_per_unit;
                    change.up = up;
                }
                AppliedStep::Trim { first, last } if change.frames_per_second.is_none() => {
                    change.last = change.first + last;
                    change.first += first;
                }
                AppliedStep::Resample { frames_per_second } => {
                    change.frames_per_second.get_or_insert(frames_per_second);
                }
                AppliedStep::InPlace => change.in_place = true,
                AppliedStep::Trim { .. } | AppliedStep::RootMotion | AppliedStep::SelectClip { .. } => {}
            }
        }
        change
    }

    /// Guesses the unit from the lengths of the links in the first frame, and the up axis with which the roots are
    /// closer.
    fn guessed(ours: &Skeleton, theirs: &Skeleton, pairs: &[(usize, usize)]) -> Self {
        let (mut here, mut there) = (Vec::new(), Vec::new());
        ours.world(0.0, &mut here);
        theirs.world(0.0, &mut there);
        let position = |world: &[DMat4], place: usize| world[place].w_axis.truncate();
        let span = |world: &[DMat4], pick: fn(&(usize, usize)) -> usize| -> f64 {
            let positions = || pairs.iter().map(|pair| position(world, pick(pair)));
            positions().zip(positions().skip(1)).map(|(a, b)| a.distance(b)).sum()
        };
        let ratio = span(&there, |pair| pair.1) / span(&here, |pair| pair.0);
        let mut change = Self::none();
        if ratio.is_finite() && ratio > 0.0 {
            change.metres_per_unit = ratio;
        }
        let distance = |change: &Self| -> f64 {
            pairs
                .iter()
                .map(|(a, b)| change.place(position(&here, *a)).distance(position(&there, *b)))
                .sum()
        };
        let turned = Self {
            up: UpAxis::Z,
            ..change
        };
        if distance(&turned) < distance(&change) {
            turned
        } else {
            change
        }
    }

    /// Maps a point of the source to the file.
    fn place(&self, point: DVec3) -> DVec3 {
        let point = point * self.metres_per_unit;
        match self.up {
            UpAxis::Y => point,
            UpAxis::Z => DVec3::new(point.x, point.z, -point.y),
        }
    }
}

/// Compares every frame of the source that is in the file.
fn compare(
    source: &Scene,
    ours: &Skeleton,
    theirs: &Skeleton,
    pairs: &[(usize, usize)],
    change: &Change,
    verification: &mut Verification,
) {
    let animation = source.animations.first();
    let rate = animation.map_or(1.0, |animation| animation.ticks_per_second);
    let last = animation.map_or(0.0, |animation| animation.duration).min(change.last);
    // A file of another program may end earlier. Half a frame allows for rounding.
    let their_rate = change
        .frames_per_second
        .map_or(rate, |wanted| skeleton::rate_before(rate, wanted));
    let last = last.min(change.first + theirs.end * their_rate + 0.5);
    let root_of = roots(ours);
    let mut start: Option<Vec<DVec3>> = None;
    let (mut here, mut there) = (Vec::new(), Vec::new());
    let mut sum_of_squares = 0.0;
    for frame in change.first.ceil() as usize..=last.floor() as usize {
        let seconds = (frame as f64 - change.first) / their_rate;
        ours.world(frame as f64 / rate, &mut here);
        // The frame's time as rounded in glTF. Just before it, at a cut, the pose is another one.
        theirs.world(f64::from(seconds as f32), &mut there);
        let places: Vec<_> = here
            .iter()
            .map(|matrix| change.place(matrix.w_axis.truncate()))
            .collect();
        let start = start.get_or_insert_with(|| places.clone());
        for &(a, b) in pairs {
            let mut expected = places[a];
            if change.in_place {
                let way = places[root_of[a]] - start[root_of[a]];
                expected -= DVec3::new(way.x, 0.0, way.z);
            }
            let error = expected.distance(there[b].w_axis.truncate());
            sum_of_squares += error * error;
            // NaN counts as the largest error.
            let is_worse = error > verification.max_error || (error.is_nan() && !verification.max_error.is_nan());
            if is_worse || verification.worst.is_none() {
                verification.max_error = error;
                verification.worst = Some(Worst {
                    joint: ours.joints[a].name.clone(),
                    frame,
                    seconds,
                });
            }
        }
        verification.frames += 1;
    }
    let compared = (verification.frames * pairs.len()).max(1);
    verification.rms_error = (sum_of_squares / compared as f64).sqrt();
}

/// The root of every joint: the highest ancestor that is not a group.
fn roots(skeleton: &Skeleton) -> Vec<usize> {
    let mut roots: Vec<usize> = Vec::with_capacity(skeleton.joints.len());
    for (index, joint) in skeleton.joints.iter().enumerate() {
        let is_below_root = |parent: &usize| skeleton.joints[*parent].kind != NodeKind::Group;
        roots.push(joint.parent.filter(is_below_root).map_or(index, |parent| roots[parent]));
    }
    roots
}
