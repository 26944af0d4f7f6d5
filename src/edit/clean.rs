//! Cleans motion that comes from a camera or from a generative model. The parts of the cleaning are time, flips, noise,
//! lengths, floor and contacts, in this order.
//!
//! Each part looks for one kind of defect, and changes only defects. If a part makes a measure of the motion worse, the
//! step undoes this part. `docs/cleaning-algorithm.md` has the methods and their sources.

mod contacts;
mod depth;
mod exchange;
pub(crate) mod gaps;
mod hands;
mod lengths;
mod live;
mod measures;
mod noise;
mod pace;
mod points;
mod rate;
mod report;
mod smoother;
mod soles;
mod time;

pub use self::live::LiveClean;
pub use self::measures::CleanMeasures;
pub use self::report::{CleanOutcome, CleanPart, CleanReport, CleanedPart};

use glam::Vec3;
use mocap_figure::{Creature, Figure};
use mocap_scene::error::Result;
use mocap_scene::pose::Trs;
use mocap_scene::scene::{NodeId, Scene};

use self::hands::Meetings;
use super::floor;
use super::quantity::counted;
use super::step::step;
use super::work::Work;
use super::{Step, StepInput, StepKey, ValueKind, flips};
use crate::clean_weights::CleanWeights;

step! {
    /// Cleans a motion. It repairs timing, flips, noise, bone lengths, floor and foot contacts, in this order. A repair
    /// that finds no defect does not change the motion. If the skeleton is not a humanoid, the step does not repair
    /// floor and contacts.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::edit::{Clean, CleanPart, Step, StepInput};
    /// use mocap::edit::report::CleanOutcome;
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let report = Clean::new().contacts(false).apply(&mut scene, &StepInput::new())?;
    /// let noise = report.parts.iter().find(|part| part.part == CleanPart::Noise).unwrap();
    /// assert_eq!(noise.outcome, CleanOutcome::Nothing); // a marker system has little
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::NoMotion`](mocap_scene::Code::NoMotion) without this animation, and
    /// [`Code::InvalidValue`](mocap_scene::Code::InvalidValue) for a weight that is out of its range.
    Clean {
        /// Repair timing: frames that repeat the frame before, and missing frames. Default: `true`.
        time: bool = true, ValueKind::Flag;
        /// Remove flips: rotations that jump for some frames and return. Default: `true`.
        flips: bool = true, ValueKind::Flag;
        /// Remove noise from rotations and positions. Default: `true`.
        noise: bool = true, ValueKind::Flag;
        /// Keep the length of each bone constant. Default: `true`.
        lengths: bool = true, ValueKind::Flag;
        /// Correct the height and slope of the floor and the drift of the body. Default: `true`.
        floor: bool = true, ValueKind::Flag;
        /// Stop foot sliding during ground contact. Default: `true`.
        contacts: bool = true, ValueKind::Flag;
        /// The weights of the cleaning that differ from their defaults. Default: `None`.
        weights: Option<CleanWeights> = None, ValueKind::Numbers;
    }
}

impl Step for Clean {
    const NAME: &'static str = "clean";
    const HELP: &'static str = "repair timing, flips, noise, bone lengths, floor slope and foot sliding";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    const TAKES_BONES: bool = true;
    type Report = CleanReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<CleanReport> {
        let figure = Work::figure(scene, input);
        let reach = Work::reaches(scene, &figure);
        let mut work = Work::new(scene, &figure, &reach, input.animation)?;
        work.weights = self.weights.unwrap_or_default();
        work.weights.check()?;
        let before = work.clone();
        let mut report = CleanReport::new(&work);
        // What the hands touch, measured before the noise is removed.
        let mut meetings = Meetings::default();
        for part in CleanPart::ALL {
            if self.has(part) {
                self.do_part(part, (&mut work, &mut meetings), input.animation, &mut report)?;
            } else {
                report.leave_out(part, "not requested");
            }
        }
        let frames = work.frames;
        let old = before.frames;
        let (mut rotated, mut moved): (Vec<NodeId>, Vec<NodeId>) = (Vec::new(), Vec::new());
        for (column, node) in frames.nodes().iter().enumerate() {
            // The foot lock may have rotated a joint that no channel drives.
            let Some(former) = old.column(*node) else {
                rotated.push(*node);
                continue;
            };
            let is_rotated = frames.rotations(column).ne(old.rotations(former));
            let is_moved = frames.translations(column).ne(old.translations(former));
            rotated.extend(is_rotated.then_some(*node));
            moved.extend(is_moved.then_some(*node));
        }
        let has_other_frames = frames.len() != old.len();
        let rate = (frames.rate != old.rate).then_some(frames.rate);
        drop(old);
        let frames = frames.changes();
        if has_other_frames {
            frames.write_all(scene, input.animation);
        } else {
            frames.write(scene, input.animation, &rotated, &moved);
        }
        if let Some(rate) = rate {
            scene.animations[input.animation].ticks_per_second = rate;
        }
        Ok(report)
    }
}

/// The smallest evidence for a dropped frame that [`MotionErrors`] reports, as the logarithm of a ratio. A repair needs
/// more evidence, because it changes the motion. In tools/survey, none of 300 clean clips reaches this value, and 76 of
/// 77 clips with a dropped frame reach it.
const REPORTED_EVIDENCE: f64 = 0.2;

/// The defects of a motion, by kind.
#[doc(hidden)]
pub struct MotionErrors {
    /// Frames that repeat the frame before.
    #[doc(hidden)]
    pub doubled: Vec<usize>,
    /// Frames before which one or more frames are missing.
    #[doc(hidden)]
    pub dropped: Vec<usize>,
    /// The joints whose rotation flips. Each has a list that states for each frame whether the rotation is flipped.
    #[doc(hidden)]
    pub flipped: Vec<(NodeId, Vec<bool>)>,
    /// The noise of the rotation of each joint, in metres: the displacement that the noise causes at the farthest joint
    /// below.
    #[doc(hidden)]
    pub noise: Vec<(NodeId, f64)>,
    /// For each frame, whether the left and right limbs are exchanged. Empty if they never are.
    #[doc(hidden)]
    pub exchanged: Vec<bool>,
    /// The slope of the floor in degrees.
    #[doc(hidden)]
    pub slope: Option<f64>,
    /// The drift of the body over the ground, in metres.
    #[doc(hidden)]
    pub drift: Option<f64>,
    /// The drift of the height of the ground, in metres.
    #[doc(hidden)]
    pub height_drift: Option<f64>,
}

impl MotionErrors {
    /// Finds the defects that [`Clean`] would repair, without changing the scene.
    ///
    /// # Errors
    /// [`Code::NoMotion`](mocap_scene::Code::NoMotion) without this animation.
    #[doc(hidden)]
    pub fn find(scene: &Scene, animation: usize, figure: &Figure) -> Result<Self> {
        let reach = Work::reaches(scene, figure);
        let mut work = Work::new(scene, figure, &reach, animation)?;
        work.weights.least_evidence = REPORTED_EVIDENCE;
        let [doubled, dropped] = time::errors(&work);
        let [slope, drift, height_drift] = if work.is_humanoid() {
            floor::errors(&work)
        } else {
            [None; 3]
        };
        let exchanged = if work.is_humanoid() {
            exchange::frames(&work)
        } else {
            Vec::new()
        };
        let nodes = work.frames.nodes().iter().enumerate();
        let flipped = nodes.map(|(column, node)| {
            let mut track: Vec<_> = work.frames.rotations(column).collect();
            (*node, flips::mend(&mut track, None, work.frames.rate).frames)
        });
        Ok(Self {
            doubled,
            dropped,
            flipped: flipped.filter(|(_, frames)| !frames.is_empty()).collect(),
            noise: noise::levels(&work),
            exchanged,
            slope,
            drift,
            height_drift,
        })
    }
}

impl Clean {
    /// Sets whether the step includes a part.
    #[must_use]
    pub fn part(mut self, part: CleanPart, wanted: bool) -> Self {
        *match part {
            CleanPart::Time => &mut self.time,
            CleanPart::Flips => &mut self.flips,
            CleanPart::Noise => &mut self.noise,
            CleanPart::Lengths => &mut self.lengths,
            CleanPart::Floor => &mut self.floor,
            CleanPart::Contacts => &mut self.contacts,
        } = wanted;
        self
    }

    fn has(&self, part: CleanPart) -> bool {
        match part {
            CleanPart::Time => self.time,
            CleanPart::Flips => self.flips,
            CleanPart::Noise => self.noise,
            CleanPart::Lengths => self.lengths,
            CleanPart::Floor => self.floor,
            CleanPart::Contacts => self.contacts,
        }
    }

    /// Runs a part of the cleaning, and undoes it if it made a measure of the motion worse.
    fn do_part(
        &self,
        part: CleanPart,
        (work, meetings): (&mut Work<'_>, &mut Meetings),
        animation: usize,
        report: &mut CleanReport,
    ) -> Result<()> {
        let needs_humanoid = match part {
            CleanPart::Lengths | CleanPart::Floor => true,
            CleanPart::Contacts => work.figure.humanoid.creature != Some(Creature::FourLegged),
            CleanPart::Time | CleanPart::Flips | CleanPart::Noise => false,
        };
        if needs_humanoid && !work.is_humanoid() {
            report.leave_out(part, "the skeleton is not a humanoid");
            return Ok(());
        }
        let before = work.clone();
        let what = match part {
            CleanPart::Time => {
                let (done, doubt) = time::mend(work);
                report.doubts.extend(doubt);
                done.to_string()
            }
            CleanPart::Flips => mend_flips(work).to_string(),
            CleanPart::Noise => do_noise(work, meetings, report),
            CleanPart::Lengths => match lengths::hold(work) {
                0 => String::new(),
                held => format!("{} got a constant length", counted(held, "bone")),
            },
            CleanPart::Floor => {
                let depth = depth::still(work);
                floor::FloorOutcome {
                    depth,
                    ..floor::level(work, false).unwrap_or_default()
                }
                .to_string()
            }
            CleanPart::Contacts => do_contacts(work, animation, (meetings, report), true)?,
        };
        let mut undone = report.take(part, what, (&before, &*work), meetings);
        if undone.is_some() && part == CleanPart::Contacts && report.had_noise() {
            *work = before.clone();
            let what = do_contacts(work, animation, (meetings, report), false)?;
            undone = report.take(part, what, (&before, &*work), meetings);
        }
        if let Some(about) = undone {
            *work = before;
            report.take_back(part, about);
        }
        Ok(())
    }
}

/// Locks the feet, and brings the hands back to what they touched. With `steadies`, a foot that stands keeps its
/// rotation. Returns a message about the changes.
fn do_contacts(
    work: &mut Work<'_>,
    animation: usize,
    (meetings, report): (&Meetings, &CleanReport),
    steadies: bool,
) -> Result<String> {
    let is_changed = report.had_noise();
    let noise = [report.has_changed(CleanPart::Noise), is_changed];
    let feet = contacts::lock(work, animation, noise, report.after.skate, steadies)?;
    if report.has_changed(CleanPart::Floor) && !feet.is_empty() {
        floor::bring_to_zero(work);
    }
    let hands = match is_changed {
        true => meetings.restore(work, report.before.hands),
        false => String::new(),
    };
    let done: Vec<String> = [feet, hands].into_iter().filter(|what| !what.is_empty()).collect();
    Ok(done.join(", "))
}

/// Factors of the allowed jerk. The noise removal tries them in this order, because a smoother that allows more jerk
/// cuts less of the peaks.
const TRIES: [f64; 4] = [1.0, 2.0, 8.0, 64.0];

/// Removes noise as strongly as possible without cutting the peaks of the motion, and returns a message about the
/// changes. Before this, the function measures what the hands touch.
fn do_noise(work: &mut Work<'_>, meetings: &mut Meetings, report: &mut CleanReport) -> String {
    let mut depth = None;
    let own = time::interpolated(work);
    let every = pace::frames_for_one(work.frames.rate, own);
    if work.is_humanoid() {
        let bank = |every: usize, times: f64| pace::Bank::new(work.frames.rate, every, times * work.weights.smoothing);
        let strong = bank(every, TRIES[0]);
        // A clap lasts for only a frame or two, so every frame is measured.
        let weaker = bank(if own > 1 { every } else { 1 }, TRIES[1]);
        *meetings = Meetings::new(work, &weaker);
        report.measure_hands(meetings, work);
        depth = depth::steady(work, &strong);
    }
    if depth.is_some() {
        report.measure_steadied(work);
    }
    let steady = work.clone();
    let mut what = remove_noise(work, every, work.weights.smoothing);
    for strength in TRIES[1..].iter().map(|times| times * steady.weights.smoothing) {
        if what.is_nothing() || !report.is_worse(CleanPart::Noise, (&steady, &*work)) {
            break;
        }
        *work = steady.clone();
        what = remove_noise(work, every, strength);
    }
    // If a body hardly moves, its fastest frames are noise. The removal of noise makes these frames slower, which is
    // then no damage.
    if !what.is_nothing() && report.is_worse(CleanPart::Noise, (&steady, &*work)) {
        *work = steady.clone();
        what = remove_noise(work, every, steady.weights.smoothing);
        if measures::is_noise(work, &steady.frames) {
            report.measure_steadied(work);
        }
    }
    noise::SmoothingOutcome { depth, ..what }.to_string()
}

/// Smooths the rotations of joints, then their positions in the world. `strength` is the jerk that the smoother allows.
fn remove_noise(work: &mut Work<'_>, every: usize, strength: f64) -> noise::SmoothingOutcome {
    let bank = pace::Bank::new(work.frames.rate, every, strength);
    let noisy = work.frames.clone();
    let done = noise::remove(work, &bank);
    if !done.is_nothing() && work.has_no_scale() {
        points::follow(work, &noisy, &bank, done.in_most);
    }
    done
}

/// The smallest displacement that counts as a spike of a position, in metres. No body moves so far in one frame and
/// comes back within 0.2 s. At 24 frames per second, this would need 10 times the acceleration of gravity.
const LEAST_SPIKE: f32 = 0.1;

/// The repairs of all joints.
#[derive(Default)]
struct Flips {
    runs: usize,
    /// The number of runs of displaced positions.
    positions: usize,
    joints: usize,
    spread: usize,
    exchanged: usize,
}

fn mend_flips(work: &mut Work<'_>) -> Flips {
    let mut done = Flips::default();
    if work.is_humanoid() {
        done.exchanged = exchange::mend(work);
    }
    let is_animal = work.figure.humanoid.creature.is_some();
    for mended in flips::mend_all(work.scene, &mut work.frames, is_animal) {
        done.runs += mended.runs;
        done.joints += usize::from(mended.runs > 0);
        done.spread += mended.spread;
    }
    for column in 0..work.frames.nodes().len() {
        let mut track: Vec<Vec3> = work.frames.translations(column).collect();
        let runs = flips::mend_positions(&mut track, LEAST_SPIKE / work.metres, work.frames.rate);
        if runs > 0 {
            done.positions += runs;
            let positions = track.iter().zip(work.frames.track(column));
            let track: Vec<Trs> = positions
                .map(|(at, trs)| Trs {
                    translation: *at,
                    ..trs
                })
                .collect();
            work.frames.set_track(column, &track);
        }
    }
    done
}
