//! What `mocap convert` changes between reading and writing, each decision in words.

use mocap::Conversion;
use mocap::scene::{Assumption, Scene, Topic};

use crate::args::{ConvertArgs, DropArg};

/// What `args` ask for.
pub(crate) fn conversion(args: &ConvertArgs) -> Conversion {
    let mut conversion = args.change.conversion().bones(args.map.bones());
    if let Some(metres) = args.source.metres_per_unit() {
        conversion = conversion.metres_per_unit(metres);
    }
    if let Some(up) = args.source.up() {
        conversion = conversion.up(up);
    }
    conversion
}

/// Does what `args` ask for. Returns what was decided, by the reader and here, in words. Where `keeps_units`, the
/// file's own unit and axes stay unless others are named.
///
/// # Errors
/// As [`mocap::Conversion::apply`].
pub(crate) fn apply(scene: &mut Scene, args: &ConvertArgs, keeps_units: bool) -> mocap::Result<Vec<String>> {
    // What the reader had to assume, and what of the file has no place in a scene.
    let mut words: Vec<String> = scene.metadata.assumptions.iter().map(Assumption::to_string).collect();
    let decided = conversion(args).keep_units(keeps_units).apply(scene)?;
    words.extend(decided.iter().map(Assumption::to_string));
    let begins_with_rest_pose = decided.iter().any(|assumption| assumption.topic == Topic::FirstFrame);
    if begins_with_rest_pose && matches!(args.change.drop_first_frame, DropArg::No) {
        words.push("the first frame is kept; `--drop-first-frame auto` leaves it out".to_owned());
    }
    Ok(words)
}
