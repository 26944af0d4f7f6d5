//! The time of each frame of a recording, by two clocks.
//!
//! VMC defines `/VMC/Ext/T` as a relative time in seconds. Senders write Unity's `Time.time` as a 32-bit float. The
//! sender's clock has no network jitter. But it starts at 0 again with the sender, and jumps if the machine slept or
//! set its clock. The receiver's clock bridges such a jump.

use mocap_scene::error::{Code, Diagnostic};

/// The largest gain or loss of the sender's clock against the receiver's clock between two frames, in seconds. Network
/// delays and reordered packets stay below it.
const LONGEST_DELAY: f64 = 1.0;

/// The fraction of irregular frames above which the sender's clock is not used. The time of an irregular frame is
/// missing, or not later than the previous time. A 32-bit clock that has run for days repeats its values.
const MOST_IRREGULAR: f64 = 0.05;

/// The time of a frame by the sender's clock, and its time of arrival, in seconds since a fixed time.
#[derive(Clone, Copy, Debug)]
pub(super) struct FrameTime {
    pub(super) sender: Option<f64>,
    pub(super) arrival: f64,
}

impl FrameTime {
    /// Seconds since an earlier frame, by the sender's clock. If the sender's time is missing or jumps, by the
    /// receiver's clock.
    pub(super) fn since(self, before: Self) -> f64 {
        let step = before.sender.zip(self.sender).map(|(before, now)| now - before);
        let waited = self.waited(before);
        step.filter(|step| !is_jump(*step, waited)).unwrap_or(waited)
    }

    fn waited(self, before: Self) -> f64 {
        (self.arrival - before.arrival).max(0.0)
    }
}

fn is_jump(step: f64, waited: f64) -> bool {
    step - waited > LONGEST_DELAY || step < -LONGEST_DELAY
}

/// A jump of the sender's clock.
#[derive(Clone, Copy, Debug)]
struct ClockJump {
    /// The time of the recording at the first frame after the jump, in seconds.
    at: f64,
    /// The excess of the sender's clock over the receiver's clock, in seconds.
    by: f64,
}

/// The time of each frame since the first, in seconds, and the warning about bridged jumps.
pub(super) fn seconds_of(frames: &[FrameTime]) -> (Vec<f64>, Option<Diagnostic>) {
    let mut seconds: Vec<f64> = Vec::with_capacity(frames.len());
    let (mut jumps, mut irregular) = (Vec::new(), 0);
    // The first frame after the last jump, with its time: the sender's clock counts from here.
    let mut origin: Option<(f64, f64)> = None;
    let mut last_of_clock: Option<(f64, FrameTime)> = None;
    for (index, frame) in frames.iter().enumerate() {
        let waited = index.checked_sub(1).map_or(0.0, |before| frame.waited(frames[before]));
        let by_arrival = seconds.last().unwrap_or(&0.0) + waited;
        let Some(sender) = frame.sender else {
            irregular += 1;
            seconds.push(by_arrival);
            continue;
        };
        if let Some((before, last)) = last_of_clock {
            let (step, waited) = (sender - before, frame.waited(last));
            if is_jump(step, waited) {
                jumps.push(ClockJump {
                    at: by_arrival,
                    by: step - waited,
                });
                origin = None;
            } else if step <= 0.0 {
                irregular += 1;
            }
        }
        let (from, at) = *origin.get_or_insert((sender, by_arrival));
        seconds.push(at + (sender - from));
        last_of_clock = Some((sender, *frame));
    }
    if f64::from(irregular) > MOST_IRREGULAR * frames.len() as f64 {
        return (frames.iter().map(|frame| frame.waited(frames[0])).collect(), None);
    }
    (seconds, warning_of(&jumps))
}

fn warning_of(jumps: &[ClockJump]) -> Option<Diagnostic> {
    let ClockJump { at, by } = jumps.first()?;
    let direction = if *by < 0.0 { "back" } else { "forward" };
    let size = match by.abs() {
        by if by < 1e9 => format!("{by:.2}"),
        by => format!("{by:.1e}"),
    };
    let message = format!(
        "the sender's clock jumped {direction} by {size} s at {at:.2} s; the recording continues by the time of arrival"
    );
    let warning = Diagnostic::new(Code::ClockJump, message).times(jumps.len() as u64);
    Some(warning.help("if the recording belongs to audio or video, check the synchronization at this time"))
}
