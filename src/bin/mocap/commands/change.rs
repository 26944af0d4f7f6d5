//! What `mocap convert` changes between reading and writing, each decision in words.

use mocap::Conversion;
use mocap::convert::FirstFrame;
use mocap::scene::{Assumption, Confidence, Scene, Topic, UpAxis};

use crate::args::ConvertArgs;

/// What `args` ask for.
pub(crate) fn conversion(args: &ConvertArgs) -> Conversion {
    let mut conversion = args.change.conversion().bones(args.map.bones_here());
    if let Some(metres) = args.source.metres_per_unit() {
        conversion = conversion.metres_per_unit(metres);
    }
    if let Some(up) = args.source.up() {
        conversion = conversion.up(up);
    }
    conversion
}

/// Does what `args` ask for. Returns what was decided, by the reader and here, in words. Where `keeps_units`, the
/// file's own unit and axes stay unless others are named. `of_others` is the up axis of other clips of the same
/// skeleton.
///
/// # Errors
/// As [`mocap::Conversion::apply`].
pub(crate) fn apply(
    scene: &mut Scene,
    args: &ConvertArgs,
    keeps_units: bool,
    of_others: Option<UpAxis>,
) -> mocap::Result<Vec<String>> {
    let of_others = of_others.filter(|_| scene.metadata.up.is_none() && args.source.up().is_none());
    if let Some(up) = of_others {
        scene.metadata.assumptions.push(Assumption {
            topic: Topic::Up,
            choice: up.as_str().to_owned(),
            reason: "other clips of the same skeleton stand along it".to_owned(),
            confidence: Some(Confidence::Likely),
        });
    }
    // What the reader had to assume, and what of the file a scene cannot hold.
    let mut words: Vec<String> = scene.metadata.assumptions.iter().map(Assumption::to_string).collect();
    let mut conversion = conversion(args).keep_units(keeps_units);
    if let Some(up) = of_others {
        conversion = conversion.up(up);
    }
    let decided = conversion.apply(scene)?;
    words.extend(decided.iter().map(Assumption::to_string));
    let begins_with_rest_pose = decided.iter().any(|assumption| assumption.topic == Topic::FirstFrame);
    if begins_with_rest_pose && args.change.frames.drop_first_frame == FirstFrame::Keep {
        words.push("the first frame is kept; `--drop-first-frame auto` leaves it out".to_owned());
    }
    Ok(words)
}
