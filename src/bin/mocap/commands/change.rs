//! What `mocap convert` changes between reading and writing, each decision said and kept in the scene's metadata.

use mocap::scene::{Assumption, Scene, Topic, UpAxis};
use mocap::{Code, Diagnostic, process, skeleton};

use crate::args::{ChangeArgs, DropArg, Moment, RestArg, UnitArg, UpArg};

/// Does what `args` ask for, in the order that [`process`] recommends. Returns what was decided, by the reader and here,
/// in words.
///
/// glTF is in metres with +Y up, so that a unit and an axis have to be found for it; where `keeps_units`, the file's own
/// stay unless others are named.
///
/// # Errors
/// [`Code::UnknownOption`] where `args` name frames that the motion does not have.
pub(crate) fn apply(scene: &mut Scene, args: &ChangeArgs, keeps_units: bool) -> mocap::Result<Vec<String>> {
    // What the reader had to assume, and what of the file has no place in a scene.
    let mut words: Vec<String> = scene.metadata.assumptions.iter().map(Assumption::to_string).collect();
    let survey = skeleton::survey(scene);
    let guesses = survey.assumptions();
    let guess = |topic| guesses.iter().find(|guess| guess.topic == topic);
    let mut take = |scene: &mut Scene, topic| {
        if let Some(assumption) = guess(topic) {
            words.push(assumption.to_string());
            scene.metadata.assumptions.push(assumption.clone());
        }
    };

    // Before anything moves: the frame is named by its number in the file.
    let rest_frame = match args.rest {
        RestArg::Zero => None,
        RestArg::Frame(frame) => Some(frame as f64),
    };
    if let Some(frame) = rest_frame {
        check_within(scene, frame, "--rest names a frame that the motion does not have")?;
        process::rest_pose(scene, frame);
    }

    let drops = match args.drop_first_frame {
        DropArg::Auto => survey.first_frame_is_rest_pose,
        DropArg::Yes => true,
        DropArg::No => false,
    };
    if survey.first_frame_is_rest_pose {
        take(scene, Topic::FirstFrame);
    }
    let (mut first, mut last) = (if drops { 1.0 } else { 0.0 }, f64::INFINITY);
    if let Some(trim) = args.trim {
        let rate = scene
            .animations
            .first()
            .map_or(1.0, |animation| animation.ticks_per_second);
        let tick = |moment| match moment {
            Moment::Seconds(seconds) => f64::round(seconds * rate),
            Moment::Frame(frame) => frame as f64,
        };
        first = f64::max(first, trim.first.map_or(0.0, tick));
        last = trim.last.map_or(last, tick);
        check_within(scene, first, "--trim begins after the motion's end")?;
        if last < first {
            let message = "--trim ends before it begins, counted in frames";
            return Err(Diagnostic::new(Code::UnknownOption, message)
                .expected_found(format!("frame {first} or a later one"), format!("frame {last}"))
                .into());
        }
    }
    if first > 0.0 || last.is_finite() {
        process::trim(scene, first, last);
    }
    if let Some(rate) = args.fps {
        process::resample(scene, rate);
    }

    let metres_per_unit = match (args.unit, scene.metadata.metres_per_unit) {
        (UnitArg::Metres(metres), _) => metres,
        (UnitArg::Auto, _) if keeps_units => 1.0,
        (UnitArg::Auto, Some(metres)) => metres,
        (UnitArg::Auto, None) => {
            take(scene, Topic::Unit);
            survey.unit.value.metres()
        }
    };
    let up = match args.up {
        UpArg::Auto if keeps_units => UpAxis::Y,
        UpArg::Y => UpAxis::Y,
        UpArg::Z => UpAxis::Z,
        UpArg::Auto => {
            take(scene, Topic::Up);
            survey.up.value
        }
    };
    if metres_per_unit != 1.0 || up != UpAxis::Y || !keeps_units {
        process::convert_units(scene, metres_per_unit, up);
    }
    if args.in_place {
        process::in_place(scene);
    }
    if args.root_motion {
        process::root_motion(scene);
    }
    if survey.first_frame_is_rest_pose && !drops {
        words.push("the first frame is kept; `--drop-first-frame auto` leaves it out".to_owned());
    }
    Ok(words)
}

/// Refuses a frame behind the last; a scene without motion has none to be behind.
fn check_within(scene: &Scene, frame: f64, message: &str) -> mocap::Result<()> {
    match scene.animations.first() {
        Some(animation) if frame > animation.duration => {
            let last = animation.duration;
            let seconds = last / animation.ticks_per_second;
            Err(Diagnostic::new(Code::UnknownOption, message)
                .expected_found(
                    format!("at most frame {last}, {seconds:.3} seconds from the start"),
                    format!("frame {frame}"),
                )
                .into())
        }
        _ => Ok(()),
    }
}
