//! Prints a BVH file as the crate `bvh_anim` reads it: its joints, and the values of one frame.
//!
//!     bvh-anim-dump FILE last|FRAME
//!
//! The exit status is 1 if the crate returns an error; a panic of the crate ends the program with a panic.

use std::error::Error;
use std::process::ExitCode;
use std::{env, fs};

use bvh_anim::{Bvh, Channel};
use serde_json::{Value, json};

fn main() -> ExitCode {
    match print() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn print() -> Result<(), Box<dyn Error>> {
    let mut arguments = env::args().skip(1);
    let file = arguments.next().ok_or("usage: bvh-anim-dump FILE last|FRAME")?;
    let frame = arguments.next().ok_or("usage: bvh-anim-dump FILE last|FRAME")?;

    let bvh = Bvh::from_bytes(fs::read(file)?)?;
    let frames = bvh.num_frames();
    let last = frames.saturating_sub(1);
    let index = if frame == "last" {
        last
    } else {
        last.min(frame.parse()?)
    };
    let values = bvh.frames().nth(index).map(|values| values.as_slice().to_vec());
    let frame_time = bvh.frame_time().as_secs_f64();

    let joints: Vec<Value> = bvh
        .joints()
        .map(|joint| {
            let joint = joint.data();
            let offset = joint.offset();
            json!({
                "name": text(joint.name().as_ref()),
                "parent": joint.parent_index(),
                "offset": [offset.x, offset.y, offset.z],
                "channels": joint.channels().iter().map(channel).collect::<Vec<_>>(),
                "end_site": joint.end_site().map(|tip| [tip.x, tip.y, tip.z]),
            })
        })
        .collect();
    let rate = (frame_time > 0.0).then(|| frame_time.recip());
    println!(
        "{}",
        json!({ "frames": frames, "rate": rate, "joints": joints, "values": values.unwrap_or_default() })
    );
    Ok(())
}

/// The target of a channel, and the index of its value in a frame.
fn channel(channel: &Channel) -> Value {
    json!([channel.channel_type().as_str(), channel.motion_index()])
}

/// The crate gives a name as bytes. Valid UTF-8 is read as UTF-8, other bytes as Latin-1, so that no byte is lost.
fn text(name: &[u8]) -> String {
    String::from_utf8(name.to_vec()).unwrap_or_else(|_| name.iter().copied().map(char::from).collect())
}
