//! Classifies the activity of the body in each frame, by rules on heights and speeds.
//!
//! Speed is the speed of the hips along the floor, over half a second. The trunk is the line from the hips to the neck.
//!
//! | activity | rule |
//! |---|---|
//! | lies | the trunk is more than 60 degrees from the vertical, and the hips lower than half a leg above the floor |
//! | jumps | both feet are over a tenth of a leg above their resting heights, for 0.15 s (in a run 0.35 s) to 1.2 s |
//! | runs | the hips move at 2.2 m/s or more |
//! | walks | the hips move at 0.4 m/s or more |
//! | stands | the hips are higher than 0.75 legs above the floor |
//! | other | anything else: sits, kneels, crouches |
//!
//! The body turns over when the angle of its trunk from the vertical goes from below 60 degrees (upright) to above 120
//! degrees (head down).

use super::motion::{Body, Motion};

/// The least speed of the hips in walking, in m/s. A slower body only shifts its weight.
const WALKS: f32 = 0.4;

/// The least speed of the hips in running, in m/s. People change from walking to running at about 2 m/s.
const RUNS: f32 = 2.2;
/// Half the window over which speeds are measured, in seconds.
const HALF_WINDOW: f64 = 0.25;

/// The cosine of 60 degrees: a trunk leans if its angle from the vertical is larger.
const LEANS: f32 = 0.5;

/// The cosine of 120 degrees: the head is down if the trunk's angle from the vertical is larger.
const HEAD_DOWN: f32 = -0.5;

/// The height of the hips, in leg lengths, below which a body sits, kneels or lies.
const LOW: f32 = 0.5;

/// The height of the hips, in leg lengths, above which a body stands.
const HIGH: f32 = 0.75;

/// The least height of both feet in a jump, in leg lengths: a small hop.
const OFF: f32 = 0.1;

/// The shortest and the longest jump, in seconds: 3 cm and 1.8 m high.
const JUMP: [f64; 2] = [0.15, 1.2];

/// The shortest jump of a running body, in seconds. The flight phases of running are shorter.
const JUMP_OF_RUNNER: f64 = 0.35;

/// The seconds of each activity, and the number of jumps and turns over.
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

/// The jumps, each as its first and last frame in the air.
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
