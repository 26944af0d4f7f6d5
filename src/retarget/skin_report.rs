//! The report of the target's skin in a motion.

use std::fmt;

use serde::{Deserialize, Serialize};

/// The skin of a target in a motion. Lengths at rest are lengths in the rest pose of its file.
///
/// [`PoseRetargeter`](crate::PoseRetargeter) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct SkinReport {
    /// The largest extent of the skin at rest, in metres. It is the height of a standing body.
    pub height: f64,
    /// The increase in length of the most stretched edge, as a fraction of the height. In intact rigs it is 0.01 to
    /// 0.04.
    pub largest_stretch: f64,
    /// The tick of the largest stretch.
    pub stretch_tick: f64,
    /// The joints with the largest weights at the two ends of that edge.
    pub stretched_between: [String; 2],
    /// The fraction of edges that are more than twice as long as at rest, over all examined frames.
    pub fraction_stretched: f64,
    /// The largest depth of the lowest vertex below the floor, in metres, less the depth of the source below its own
    /// floor.
    pub below_floor: f64,
    /// The tick of the largest depth.
    pub floor_tick: f64,
    /// The fraction of examined frames in which the middle of a hand is inside head, trunk or legs.
    #[serde(default)]
    pub hands_inside: f64,
    /// The first tick with a hand inside.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hands_tick: Option<f64>,
    /// The first bone whose scale at rest is mirrored or uneven. Rotations shear the skin of joints below it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uneven_joint: Option<String>,
}

impl fmt::Display for SkinReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [one, other] = &self.stretched_between;
        let joints = match one == other {
            true => format!("at {one}"),
            false => format!("between {one} and {other}"),
        };
        write!(
            f,
            "skin stretched by at most {:.1} % of the height, {joints} at tick {}; at most {:.1} cm below the floor",
            100.0 * self.largest_stretch,
            self.stretch_tick,
            100.0 * self.below_floor
        )?;
        match self.hands_tick {
            Some(tick) => write!(
                f,
                "; a hand inside the body in {:.0} % of frames, first at tick {tick}",
                100.0 * self.hands_inside
            ),
            None => Ok(()),
        }
    }
}
