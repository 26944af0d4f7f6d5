//! Checks the columns of TRC that its reader does not need but other readers use: the number and the time of each
//! frame.

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::Scene;

/// The largest difference between a row's time and its frame's time, in frames.
const SAME_FRAME: f64 = 0.5;

/// Reports a row whose time differs from the time of its frame. Frames count from 1 or 0, and a cut take may begin
/// later.
pub(super) fn inspect(bytes: &[u8], scene: &Scene) -> Result<Option<Diagnostic>> {
    let clip = scene.animations.first();
    Ok(clip.and_then(|clip| wrong_time(bytes, clip.ticks_per_second)))
}

fn wrong_time(bytes: &[u8], frame_rate: f64) -> Option<Diagnostic> {
    let text = String::from_utf8_lossy(bytes);
    // The first lines contain the file name, the header and the names.
    let rows = text.lines().enumerate().skip(3).filter_map(|(line, row)| {
        let mut cells = row.split('\t').map(str::trim);
        let (frame, time): (f64, f64) = (cells.next()?.parse().ok()?, cells.next()?.parse().ok()?);
        Some((line, frame, time))
    });
    let mut start = None;
    for (line, frame, time) in rows {
        let start = *start.get_or_insert(if frame == 0.0 { 0.0 } else { 1.0 });
        let expected = (frame - start) / frame_rate;
        if (time - expected).abs() * frame_rate <= SAME_FRAME {
            continue;
        }
        let message = format!("line {}: frame {frame} has the time {time}", line + 1);
        let diagnostic = Diagnostic::new(Code::FrameCount, message);
        return Some(diagnostic.expected_found(format!("{expected:.6} s"), format!("{time} s")));
    }
    None
}
