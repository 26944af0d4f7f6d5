//! The report of contacts between a hand and the body, the other hand or the floor.

use std::fmt;

use mocap_figure::HumanoidBone as Bone;
use serde::{Deserialize, Serialize};

/// The part that a hand touches.
///
/// [`PoseRetargeter`](crate::PoseRetargeter) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum TouchedPart {
    /// The other hand.
    OtherHand,
    /// The head.
    Head,
    /// The trunk above the waist.
    Chest,
    /// The trunk below the waist.
    Hips,
    /// The left thigh, down to its knee.
    LeftThigh,
    /// The right thigh, down to its knee.
    RightThigh,
    /// The left shin.
    LeftShin,
    /// The right shin.
    RightShin,
    /// The floor.
    Floor,
}

impl TouchedPart {
    /// The name of the part in a sentence.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::OtherHand => "other hand",
            Self::Head => "head",
            Self::Chest => "chest",
            Self::Hips => "hips",
            Self::LeftThigh => "left thigh",
            Self::RightThigh => "right thigh",
            Self::LeftShin => "left shin",
            Self::RightShin => "right shin",
            Self::Floor => "floor",
        }
    }
}

/// A contact of a hand. Distances are means over the frames of the contact, in metres. They are between the middle of
/// the palm and the surface of the touched part, negative inside. For two hands, they are from palm to palm.
///
/// [`PoseRetargeter`](crate::PoseRetargeter) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct HandContact {
    /// The hand. For a contact of two hands, the left hand.
    pub hand: Bone,
    /// The touched part.
    pub with: TouchedPart,
    /// The tick of the first frame.
    pub first: f64,
    /// The tick of the last frame.
    pub last: f64,
    /// The distance in the source, scaled by the ratio of the leg lengths.
    pub source: f64,
    /// The distance on the target before the contact was kept.
    pub before: f64,
    /// The distance on the target after the contact was kept.
    pub after: f64,
    /// The distance of the palm from its goal before the correction.
    pub error_before: f64,
    /// The distance of the palm from its goal after the correction.
    pub error_after: f64,
    /// The applied fraction of the correction: 1, or less if the motion would jerk.
    pub strength: f64,
}

/// Contacts of hands that are kept on the target.
///
/// [`PoseRetargeter`](crate::PoseRetargeter) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct HandsReport {
    /// The contacts that are kept, in order of time.
    pub contacts: Vec<HandContact>,
    /// The number of contacts that are not kept, because the hand would jerk or the palm would not come nearer to its
    /// goal.
    pub given_up: usize,
    /// The mean angle of all limbs and frames without the contacts, in degrees. The verdict uses this angle, because a
    /// hand contact changes the angles of its arm.
    pub free_mean_degrees: f64,
    /// The largest ratio of a hand's mean square jerk to its jerk without the contacts.
    pub jerk_ratio: f64,
}

impl fmt::Display for HandsReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = self.contacts.len().max(1) as f64;
        let mean = |error: fn(&HandContact) -> f64| 100.0 * self.contacts.iter().map(error).sum::<f64>() / count;
        let mut parts: Vec<&str> = self.contacts.iter().map(|contact| contact.with.as_str()).collect();
        parts.sort_unstable();
        parts.dedup();
        write!(
            f,
            "hands kept in {} contacts with {}: palms {:.1} cm from their goals, {:.1} before; jerk {:.2} times the \
             jerk of free hands",
            self.contacts.len(),
            parts.join(", "),
            mean(|contact| contact.error_after),
            mean(|contact| contact.error_before),
            self.jerk_ratio
        )?;
        match self.given_up {
            0 => Ok(()),
            given_up => write!(f, "; {given_up} contacts not kept"),
        }
    }
}
