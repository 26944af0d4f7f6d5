//! Gait events that a file states, as C3D files of laboratories do.

use mocap_scene::scene::report::AppliedStep;
use mocap_scene::scene::{Event, Scene, Side};

/// The times of heel strikes and toe-offs in the file, for the left and the right foot.
#[derive(Default)]
pub(super) struct FileEvents {
    pub(super) strikes: [Vec<f64>; 2],
    pub(super) toe_offs: [Vec<f64>; 2],
}

impl FileEvents {
    /// `None` if no foot has a stride, or the other foot has no event, or a processing step changed the times of the
    /// motion.
    pub(super) fn of(scene: &Scene) -> Option<Self> {
        let recorded = scene.metadata.recorded.as_deref()?;
        let animation = scene.animations.first().filter(|_| keeps_times(scene))?;
        let mut found = Self::default();
        let lasts = 0.0..=animation.duration / animation.ticks_per_second;
        for event in recorded.events.iter().filter(|event| lasts.contains(&event.time)) {
            let Some((side, is_strike)) = meaning(event) else {
                continue;
            };
            let times = if is_strike {
                &mut found.strikes
            } else {
                &mut found.toe_offs
            };
            times[usize::from(side == Side::Right)].push(event.time);
        }
        let [left, right] = &found.strikes;
        (left.len().max(right.len()) > 1 && !left.is_empty() && !right.is_empty()).then_some(found)
    }
}

/// Whether no processing step changed the times of the frames.
pub(super) fn keeps_times(scene: &Scene) -> bool {
    let keeps = |step: &AppliedStep| matches!(step, AppliedStep::ConvertUnits { .. } | AppliedStep::Retime { .. });
    scene.metadata.steps.iter().all(keeps)
}

/// The foot of an event, and whether it strikes the ground or leaves it. Example: `Foot Strike` with the context
/// `Left`, or `LHS`.
pub fn meaning(event: &Event) -> Option<(Side, bool)> {
    const STRIKES: [&str; 6] = ["footstrike", "heelstrike", "initialcontact", "hs", "fs", "ic"];
    const OFFS: [&str; 4] = ["footoff", "toeoff", "fo", "to"];
    let key = |text: &str| -> String {
        let letters = text.chars().filter(|letter| letter.is_alphabetic());
        letters.flat_map(char::to_lowercase).collect()
    };
    let label = key(&event.label);
    let (side, label) = match key(&event.context).as_str() {
        "left" | "l" => (Side::Left, label.as_str()),
        "right" | "r" => (Side::Right, label.as_str()),
        _ => [
            ("left", Side::Left),
            ("right", Side::Right),
            ("l", Side::Left),
            ("r", Side::Right),
        ]
        .into_iter()
        .find_map(|(start, side)| Some((side, label.strip_prefix(start)?)))?,
    };
    match (STRIKES.contains(&label), OFFS.contains(&label)) {
        (false, false) => None,
        (is_strike, _) => Some((side, is_strike)),
    }
}
