//! The columns of TRC that its reader does not need: the number and the time of each frame. Other readers go by them.

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::Scene;

/// How far a time may be from that of its frame, in frames.
const SAME_FRAME: f64 = 0.5;

/// Says where a row has another time than its frame. Frames count from 1, or from 0; a part of a take may begin later.
pub(super) fn inspect(bytes: &[u8], scene: &Scene) -> Result<Option<Diagnostic>> {
    let clip = scene.animations.first();
    Ok(clip.and_then(|clip| wrong_time(bytes, clip.ticks_per_second)))
}

fn wrong_time(bytes: &[u8], frame_rate: f64) -> Option<Diagnostic> {
    let text = String::from_utf8_lossy(bytes);
    // The lines before hold the name of the file, the header, and the names.
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
