//! What the body does in each frame, by rules on heights and speeds.
//!
//! Speeds are those of the hips along the floor over half a second; the trunk is the line from the hips to the neck.
//!
//! | activity | rule |
//! |---|---|
//! | lies | the trunk is more than 60 degrees off the vertical, and the hips lower than half a leg above the floor |
//! | jumps | both feet are more than a tenth of a leg above where they rest, for 0.15 s to 1.2 s, 0.35 s where the body runs |
//! | runs | the hips move at 2.2 m/s or more |
//! | walks | the hips move at 0.4 m/s or more |
//! | stands | the hips are higher than 0.75 legs above the floor |
//! | other | anything else: sits, kneels, crouches |
//!
//! The body turns over where its trunk passes from upright (less than 60 degrees) to head down (more than 120).

use super::motion::{Body, Motion};

/// The speed of the hips in m/s from which on a body walks: slower ones shift their weight.
const WALKS: f32 = 0.4;

/// The speed of the hips in m/s from which on a body runs: people change over at about 2.
const RUNS: f32 = 2.2;
/// The time over which speeds are taken, on each side, in seconds.
const HALF_WINDOW: f64 = 0.25;

/// The cosine of the angle of a trunk from the vertical beyond which it leans: 60 degrees.
const LEANS: f32 = 0.5;

/// The cosine of the angle of a trunk from the vertical beyond which the head is down: 120 degrees.
const HEAD_DOWN: f32 = -0.5;

/// The height of the hips in lengths of the leg below which a body sits, kneels or lies.
const LOW: f32 = 0.5;

/// The height of the hips in lengths of the leg above which it stands.
const HIGH: f32 = 0.75;

/// Height of both feet, in lengths of the leg, from which on a body jumps: a small hop.
const OFF: f32 = 0.1;

/// The shortest and the longest jump in seconds: 3 cm and 1.8 m high.
const JUMP: [f64; 2] = [0.15, 1.2];

/// The shortest jump in seconds of a body that runs: the flights of a run are shorter.
const JUMP_OF_RUNNER: f64 = 0.35;

/// Seconds of each activity, and how often the body jumps and turns over.
#[derive(Clone, Debug, Default)]
pub(super) struct Activity {
    pub(super) standing: f64,
    pub(super) walking: f64,
    pub(super) running: f64,
    pub(super) jumping: f64,
    pub(super) lying: f64,
    pub(super) other: f64,
    pub(super) jumps: u64,
    pub(super) turns_over: u64,
}

impl Activity {
    pub(super) fn new(motion: &Motion, body: &Body) -> Self {
        let mut activity = Self::default();
        let (half, hips) = (motion.frames_in(HALF_WINDOW), body.hips());
        let jumps = jumps(motion, body, half);
        activity.jumps = jumps.len() as u64;
        let second = 1.0 / motion.rate.max(f64::MIN_POSITIVE);
        let mut was_upright = true;
        for frame in 0..motion.frames {
            let speed = motion.velocity(frame, hips, half).with_y(0.0).length();
            let height = (motion.at(frame, hips).y - body.contacts.floor) / body.leg;
            let upright = body.trunk(motion, frame).y;
            let jumps = jumps.iter().any(|[from, to]| (*from..=*to).contains(&frame));
            *match () {
                () if upright < LEANS && height < LOW => &mut activity.lying,
                () if jumps => &mut activity.jumping,
                () if speed >= RUNS => &mut activity.running,
                () if speed >= WALKS => &mut activity.walking,
                () if height > HIGH => &mut activity.standing,
                () => &mut activity.other,
            } += second;
            if was_upright && upright < HEAD_DOWN {
                activity.turns_over += 1;
                was_upright = false;
            }
            was_upright |= upright > LEANS;
        }
        activity
    }
}

/// The jumps, each as its first and its last frame in the air.
fn jumps(motion: &Motion, body: &Body, half: usize) -> Vec<[usize; 2]> {
    let is_off = |frame: usize| body.lowest_foot(frame) > OFF * body.leg;
    let mut spans = super::spans(motion.frames, is_off);
    spans.retain(|[from, to]| {
        let seconds = (to + 1 - from) as f64 / motion.rate;
        let speed = motion.velocity((from + to) / 2, body.hips(), half).with_y(0.0).length();
        let shortest = if speed >= RUNS { JUMP_OF_RUNNER } else { JUMP[0] };
        (shortest..=JUMP[1]).contains(&seconds)
    });
    spans
}
