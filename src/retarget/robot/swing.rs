//! The height of a foot in its swing.

use glam::DVec3;

use super::twin::StandIn;
use mocap_scene::scene::HumanoidBone as Bone;

/// The smallest height of a sole in its swing, as a fraction of the leg: the clearance of a person's toes.
const CLEARANCE: f64 = 0.05;

/// The largest height that [`CLEARANCE`] may give, in metres: above the 2 cm that a robot needs over an uneven floor.
const MOST: f64 = 0.025;

/// The height that a foot in the air has from its first frame on, in metres. A sole below 5 mm scrapes, and the solver
/// does not always reach the full height.
pub(super) const LEAST: f64 = 0.007;

/// The time in which a foot rises from [`LEAST`] to its full height after lifting off, in seconds. It comes down in the
/// same time before landing.
const RISE: f64 = 0.15;

/// The smallest height of the robot's soles in a swing, in metres.
pub(super) fn most_clearance(twin: &StandIn) -> f64 {
    let legs = [Bone::LeftLowerLeg, Bone::LeftFoot].map(|bone| twin.bone(bone));
    let length = legs.into_iter().flatten().map(|bone| {
        let offset = twin.scene.nodes[bone.node.index()].transform.w_axis.truncate();
        f64::from(offset.length())
    });
    f64::min(CLEARANCE * length.sum::<f64>(), MOST)
}

/// The smallest height of a sole per m/s of its horizontal speed, in seconds. A sole that lands or pushes off is slow,
/// and carries the body. At 0.3 m/s, above which a sole scrapes, the height is 1.2 cm.
const BY_SPEED: f64 = 0.04;

/// The time around a frame whose largest speed counts, in seconds: a foot rises before it is fast.
const AHEAD: f64 = 0.02;

/// The horizontal speed of the slowest point of each sole near each frame, in metres per second. The slowest point
/// counts, because a foot may roll.
pub(super) fn speeds(points: &[[Vec<DVec3>; 2]], fps: f64) -> Vec<[f64; 2]> {
    let last = points.len().saturating_sub(1);
    let of_frame = |frame: usize| {
        let (from, to) = (frame.saturating_sub(1), (frame + 1).min(last));
        [0, 1].map(|side| {
            let pairs = points[from][side].iter().zip(&points[to][side]);
            let slowest = pairs.map(|(from, to)| from.truncate().distance(to.truncate()));
            slowest.reduce(f64::min).unwrap_or(0.0) * fps / (to - from).max(1) as f64
        })
    };
    let speeds: Vec<[f64; 2]> = (0..points.len()).map(of_frame).collect();
    let near = (AHEAD * fps).round() as usize;
    let most = |frame: usize| {
        let window = &speeds[frame.saturating_sub(near)..(frame + near + 1).min(speeds.len())];
        [0, 1].map(|side| window.iter().map(|speeds| speeds[side]).fold(0.0, f64::max))
    };
    (0..points.len()).map(most).collect()
}

/// The smallest height of the lowest point of each sole in each frame. It is `most` in the middle of a swing, at least
/// `LEAST` in the air, less for a slow sole, and 0 in stance. A foot without a stance has no swing.
pub fn clearances(contacts: &[[bool; 2]], speeds: &[[f64; 2]], fps: f64, most: f64) -> Vec<[f64; 2]> {
    let mut found = vec![[0.0; 2]; contacts.len()];
    for side in 0..2 {
        if !contacts.iter().any(|stands| stands[side]) {
            continue;
        }
        let mut apart: Vec<f64> = contacts
            .iter()
            .map(|stands| if stands[side] { 0.0 } else { f64::INFINITY })
            .collect();
        for frame in 1..apart.len() {
            apart[frame] = apart[frame].min(apart[frame - 1] + 1.0);
        }
        for frame in (1..apart.len()).rev() {
            apart[frame - 1] = apart[frame - 1].min(apart[frame] + 1.0);
        }
        for ((found, frames), speeds) in found.iter_mut().zip(apart).zip(speeds) {
            let risen = (frames / (RISE * fps)).min(1.0);
            let least = if frames > 0.0 { LEAST.min(most) } else { 0.0 };
            let height = least + (most - least) * (0.5 * std::f64::consts::PI * risen).sin().powi(2);
            found[side] = height.min(BY_SPEED * speeds[side]);
        }
    }
    found
}
