//! Descriptions of the tools' options for agents.

/// Descriptions for agents of two kinds of options. The help of the first kind addresses a user of the command line.
/// The help of the second kind is long, and would appear in several tools. Each row has the option, or the tool and the
/// option, and its effect. Other options use their help.
pub const ABOUT: &[(&str, &str)] = &[
    ("character-map", "A JSON file of the character's bones"),
    ("clip", "The animation, by name or number from 0"),
    ("explain", "Explain the bone of each joint in detail"),
    ("fail-on", "Verdict that sets \"problem\", or worse"),
    ("feet", "lock holds feet still while the source feet are in contact"),
    (
        "floor",
        "Floor: auto, under the feet; z=0, height 0 of the file; keep, no change",
    ),
    ("fps", "Frames per second, at the same speed"),
    ("from", "Format of the input, if its contents do not show it"),
    ("in-place", "Keep the figure in place"),
    ("like", "Part of a motion: walk.bvh@2.0s..3.5s, or walk.bvh"),
    ("map", "A JSON file of the bones, as skeleton returns"),
    ("max-angle", "Degrees; a larger limb error sets \"problem\""),
    ("max-error", "Compress within this distance of every joint: 1mm"),
    ("mirror", "Also add every motion mirrored, for match"),
    (
        "names",
        "Names of joints: vrm, mixamo, unreal, cmu, godot, unity, mhr, soma, or a JSON file",
    ),
    ("pack", "Store the motions in the database, within 0.1 mm"),
    (
        "passes",
        "1: frame by frame, fast; 2: smooth, within the robot's velocities [default: 2]",
    ),
    ("path", "Points x/z in metres: 0/0+0/4+3/4"),
    ("replace-animations", "Drop the animations of the character"),
    ("require", "A worse verdict sets \"problem\""),
    ("robot-map", "A JSON file of the robot's links as bones"),
    ("scale", "Scale of the path: auto, by leg length; none; or a factor"),
    ("seed", "Another number gives another walk"),
    ("select", "Keep this number or percentage of clips, most diverse"),
    ("speed", "Metres per second"),
    ("survey threshold", "Threshold from which a clip is bad: skate=2"),
    ("target", "The program whose unit, axes and frame rate to write"),
    ("through", "Clips to walk through in this order; CLIP@SECONDS is a time"),
    ("time-scale", "Speed: auto, or a factor"),
    ("to", "Format of the files in an output folder"),
    ("trim", "Part to keep: A..B in seconds, or Af..Bf in frames"),
    ("unit", "Unit of the input: auto, m, dm, cm, mm, inch, cmu"),
    ("up", "Up axis of the input: auto, y, z, -y, -z"),
    ("verify", "Compare the written file with its source"),
    ("verify max-error", "The largest allowed distance of a joint: 1mm"),
    ("where", "Clips that fulfil this: skate < 1 and not twin"),
];

/// The text for an agent about an option of a tool, if it differs from the help.
pub(super) fn option(tool: &str, option: &str) -> Option<&'static str> {
    let named = |name: &str| ABOUT.iter().find(|(other, _)| *other == name).map(|(_, about)| *about);
    named(&format!("{tool} {option}")).or_else(|| named(option))
}
