//! What a motion does to the skin of its target.

use std::fmt;

use serde::{Deserialize, Serialize};

/// The skin of a target in a motion. Lengths at rest are those of the rest pose of its file.
///
/// [`PoseRetargeter`](crate::PoseRetargeter) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct SkinReport {
    /// The largest extent of the skin at rest, in metres: the height of a body that stands.
    pub height: f64,
    /// By how much the edge that is stretched most is longer than at rest, as a fraction of the height. In intact rigs
    /// it is 0.01 to 0.04.
    pub largest_stretch: f64,
    /// The tick of it.
    pub stretch_tick: f64,
    /// The joints that move the two ends of that edge most.
    pub stretched_between: [String; 2],
    /// The fraction of edges that are more than twice as long as at rest, of all frames that are looked at.
    pub fraction_stretched: f64,
    /// How far the lowest vertex is below the floor at most, in metres, beyond how far the source is below its own.
    pub below_floor: f64,
    /// The tick of it.
    pub floor_tick: f64,
    /// The fraction of the frames that are looked at in which the middle of a hand is inside head, trunk or legs.
    #[serde(default)]
    pub hands_inside: f64,
    /// The first tick of it.
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
            "skin stretched by at most {:.1} % of the height, {joints} at tick {}; {:.1} cm below the floor at most",
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
