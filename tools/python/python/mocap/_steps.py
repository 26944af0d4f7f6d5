# Written by `MOCAP_WRITE=1 cargo test -p mocap-bindings`, from the documentation of Rust: do not edit.
"""A function for each step of ``mocap edit``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

from ._options import Bones, TimeRange, time_range
from ._scene import SceneLike
from ._step import Point, Step, path_points, step_function, step_of, target_of

__all__ = [
    "blend",
    "bone_axis",
    "clean",
    "concat",
    "despike",
    "drop_first_frame",
    "fill",
    "foot_lock",
    "ground",
    "in_between",
    "in_place",
    "layer",
    "look_at",
    "loop_clip",
    "mirror",
    "pin",
    "reach",
    "resample",
    "rest",
    "reverse",
    "root_motion",
    "smooth",
    "t_pose_first",
    "turn",
]

Limb = Literal["left-hand", "right-hand", "left-foot", "right-foot"]


@step_function
def foot_lock(
    *,
    blend: float | None = None,
    height: float | None = None,
    speed: float | None = None,
    release: float | None = None,
    shortest: float | None = None,
    gap: float | None = None,
    floor: float | None = None,
    largest_change: float | None = None,
    weights: Mapping[str, float] | None = None,
    bones: Bones | None = None,
) -> Step:
    """Holds feet still in contact and above the floor.

    Args:
        blend: Seconds in which a shift fades out after a contact, and fades in before a contact. Default: 0.2.
        height: The largest height of a foot in contact above the level of rest, in metres. Default: 0.05.
        speed: The largest speed of a foot in contact, in metres per second. Default: 0.25.
        release: The factor of height or speed at which a foot leaves a contact. Default: 1.6.
        shortest: The shortest contact, in seconds; shorter ones are dropped. Default: 0.08.
        gap: The shortest gap between two contacts, in seconds; shorter ones are closed. Default: 0.05.
        floor: The height of the floor along the up axis, in metres. Default: where the feet rest.
        largest_change: The largest change of any other joint, in metres. If locking a foot would move a knee or the
            hips farther, a part of the sliding remains. Default: ``None``, no foot slides.
        weights: The weights of the lock that differ from their defaults. Default: ``None``.
        bones: The names of joints for bones, where the guess is wrong: ``{"leftFoot": "ankle_L"}``.
    """
    return step_of(
        "foot-lock",
        bones=bones,
        blend=blend,
        height=height,
        speed=speed,
        release=release,
        shortest=shortest,
        gap=gap,
        floor=floor,
        largest_change=largest_change,
        weights=weights,
    )


@step_function
def mirror(*, bones: Bones | None = None) -> Step:
    """Mirrors a motion across the mean plane of the figure: the right side moves as the left side did. A figure that
    walks forward still walks forward.

    Args:
        bones: The names of joints for bones, where the guess is wrong: ``{"leftFoot": "ankle_L"}``.
    """
    return step_of("mirror", bones=bones)


@step_function
def smooth(
    *,
    filter: Literal["butterworth", "gaussian"] | None = None,
    cut_off: float | None = None,
    part: Literal["upper", "legs", "arms", "head"] | None = None,
    joints: Sequence[str] | None = None,
    range: TimeRange | None = None,
    ease: float | None = None,
    bones: Bones | None = None,
) -> Step:
    """Filters rotations and positions of all joints or of some. Rotations are averaged in the tangent space of each
    rotation: no axis is preferred, and a joint may rotate by any angle. The first and the last frame do not change.
    Frames outside the range and its ease time do not change.

    Args:
        filter: The filter. Default: Butterworth.
        cut_off: The cut-off in Hz. Default: 6, which keeps a walk.
        part: The part of the body. Default: everything, unless joints are named.
        joints: Joints by their names or the names of bones, without the joints below them. With ``part``, they are
            added to the part.
        range: The part of the motion. Default: the whole.
        ease: Fade time of the filter before and after the range, in seconds. Default: 0.2.
        bones: The names of joints for bones, where the guess is wrong: ``{"leftFoot": "ankle_L"}``.
    """
    return step_of(
        "smooth",
        bones=bones,
        filter=filter,
        cut_off=cut_off,
        part=part,
        joints=joints,
        range=time_range(range),
        ease=ease,
    )


@step_function
def despike(
    *,
    threshold: float | None = None,
    angle: float | None = None,
    distance: float | None = None,
    longest: int | None = None,
) -> Step:
    """Replaces spikes, which are rotations and positions that leave the motion for a few frames and come back. The
    frames before and after are interpolated.

    Args:
        threshold: The least distance of a spike from its neighbours, as a multiple of the distances in the frames
            around it. Default: 8.
        angle: The smallest jump of a rotation, in degrees. Default: 3.
        distance: The smallest jump of a position, as a fraction of the distance between the ends of the skeleton.
            Default: 0.02.
        longest: The longest spike, in frames. Default: 3.
    """
    return step_of("despike", threshold=threshold, angle=angle, distance=distance, longest=longest)


@step_function
def fill(*, longest: float | None = None, shortest: float | None = None) -> Step:
    """Fills gaps: frames in which every joint exactly repeats the frame before, as programs write them for unseen
    markers. A cubic curve with the speeds before and after the gap continues the motion. For markers and other
    points without a skeleton, a gap is the frames in which a point was not seen.

    Args:
        longest: The longest gap to fill, in seconds. A longer hold may be intended. Default: 0.5.
        shortest: The shortest gap to fill, in seconds. Default: 0, two equal frames.
    """
    return step_of("fill", longest=longest, shortest=shortest)


@step_function
def clean(
    *,
    time: bool | None = None,
    flips: bool | None = None,
    noise: bool | None = None,
    lengths: bool | None = None,
    floor: bool | None = None,
    contacts: bool | None = None,
    weights: Mapping[str, float] | None = None,
    bones: Bones | None = None,
) -> Step:
    """Cleans a motion: repairs timing, flips, noise, bone lengths, floor and foot contacts, in this order. Parts
    without a defect do not change. If the skeleton is not a humanoid, floor and contacts are not changed.

    Args:
        time: Repair timing: held, duplicated and dropped frames. Default: ``True``.
        flips: Remove flips: rotations that jump for some frames and return. Default: ``True``.
        noise: Remove noise from rotations and positions. Default: ``True``.
        lengths: Keep the length of each bone constant. Default: ``True``.
        floor: Correct the height and slope of the floor and the drift of the body. Default: ``True``.
        contacts: Stop foot sliding during ground contact. Default: ``True``.
        weights: The weights of the cleaning that differ from their defaults. Default: ``None``.
        bones: The names of joints for bones, where the guess is wrong: ``{"leftFoot": "ankle_L"}``.
    """
    return step_of(
        "clean",
        bones=bones,
        time=time,
        flips=flips,
        noise=noise,
        lengths=lengths,
        floor=floor,
        contacts=contacts,
        weights=weights,
    )


@step_function
def loop_clip(
    *,
    frames: tuple[int, int] | None = None,
    shortest: float | None = None,
    longest: float | None = None,
    blend: float | None = None,
    in_place: bool | None = None,
    bones: Bones | None = None,
) -> Step:
    """Cuts a motion to a loop. Its last frame equals its first frame in pose, speed and contacts; only the position
    over the ground differs. Joint velocities are continuous at the seam.

    Args:
        frames: The first and the last frame of the loop. Default: the two frames that match best.
        shortest: The shortest loop to look for, in seconds. Default: 0.6.
        longest: The longest loop to look for, in seconds. Default: 4.
        blend: Seconds in which the difference of the poses fades out after the seam. Default: 0.3.
        in_place: Whether the loop stays in place instead of travelling over the ground from cycle to cycle.
            Default: ``False``.
        bones: The names of joints for bones, where the guess is wrong: ``{"leftFoot": "ankle_L"}``.
    """
    return step_of(
        "loop",
        bones=bones,
        frames=frames,
        shortest=shortest,
        longest=longest,
        blend=blend,
        in_place=in_place,
    )


@step_function
def concat(
    other: SceneLike,
    *,
    blend: float | None = None,
    align: bool | None = None,
    within: float | None = None,
) -> Step:
    """Appends a second motion, which has the same joints. The first frame of the second motion is the last of the
    first, so that two parts of a cut motion are restored. The scene gets the warning ``PosesApart`` if the poses at
    the seam differ by more than 45 degrees or 30 cm, or the speeds by more than 1 m/s. ``within`` searches for the
    most similar pair of an end frame and a start frame near the seam. The measure is the distance of motion graphs,
    over windows of a third of a second.

    Args:
        other: The second motion; one with another skeleton is retargeted.
        blend: Seconds in which the difference of the poses fades out after the seam. Default: 0.3.
        align: Whether the second motion begins at the position and heading at which the first motion ends. Default:
            ``True``.
        within: Seconds at the end of the first and at the beginning of the second motion in which the most similar
            frames are joined. Default: 0, which keeps both motions completely.
    """
    return step_of("concat", other=other, blend=blend, align=align, within=within)


@step_function
def blend(
    other: SceneLike,
    weight: float | Sequence[tuple[float, float]] | None = None,
    *,
    within: float | None = None,
) -> Step:
    """Mixes with a second motion, which has the same joints. Weight 0 gives the first motion, 1 the second. Dynamic
    time warping of the poses aligns both in time, so that a step meets a step. The duration is the weighted mean of
    both durations. Steps over the ground are mixed in the heading of each figure: two walks in different directions
    give a walk in a direction between. The scene gets the warning ``PosesApart`` if mixed poses differ by more than
    45 degrees or 30 cm, wherever the figures stand. With ``within``, one motion may start later, and one may end
    earlier, so that the ends match best. The measure is the distance of motion graphs, over windows of a third of a
    second. The second motion then begins at the place and in the heading of the first.

    Args:
        other: The second motion; one with another skeleton is retargeted.
        weight: The fraction of the second motion. Default: 0.5 all the time.
        within: Seconds at the beginning and at the end of both motions in which the most similar frames are
            searched. Default: 0, which mixes both motions completely.
    """
    return step_of("blend", other=other, weight=weight, within=within)


@step_function
def layer(
    other: SceneLike,
    part: Literal["upper", "legs", "arms", "head"] | None = None,
    *,
    bones: Bones | None = None,
) -> Step:
    """Takes the rotations of a part of the body, relative to their parents, from a second motion with the same joints,
    at the same time. After the end of the second motion, its last pose is held.

    Args:
        other: The second motion; one with another skeleton is retargeted.
        part: The part of the body. Default: the spine and all above it.
        bones: The names of joints for bones, where the guess is wrong: ``{"leftFoot": "ankle_L"}``.
    """
    return step_of("layer", other=other, bones=bones, part=part)


@step_function
def in_between(
    *,
    keys: Sequence[int] | None = None,
    every: int | None = None,
    interpolation: Literal["slerp", "squad"] | None = None,
) -> Step:
    """Keyframe animation: keeps the poses of chosen frames, and interpolates the others.

    Args:
        keys: The frames whose poses are kept. The first and the last frame are always kept.
        every: The distance in frames of further keys. Default: 0, no others.
        interpolation: The interpolation between keys. Default: squad, which keeps constant speeds and has no jumps
            of speed.
    """
    return step_of("in-between", keys=keys, every=every, interpolation=interpolation)


@step_function
def resample(rate: float | None = None) -> Step:
    """Gives a motion another frame rate at the same speed.

    Args:
        rate: Frames per second. Default: 30.
    """
    return step_of("resample", rate=rate)


@step_function
def drop_first_frame(*, always: bool | None = None) -> Step:
    """Drops the first frame if it is a rest pose, as in some files.

    Args:
        always: Whether to drop the first frame even if it is not a rest pose. Default: ``False``.
    """
    return step_of("drop-first-frame", always=always)


@step_function
def in_place() -> Step:
    """Keeps the root above its start point. Its height and its rotation do not change."""
    return step_of("in-place")


@step_function
def root_motion() -> Step:
    """Moves the motion of the root over the ground to a new joint above it."""
    return step_of("root-motion")


@step_function
def reverse() -> Step:
    """Plays a motion backwards: its last frame becomes its first. A second ``reverse`` restores it."""
    return step_of("reverse")


@step_function
def rest(pose: Literal["t-pose", "a-pose"] | None = None, *, bones: Bones | None = None) -> Step:
    """Makes the T-pose or the A-pose the rest pose. The motion does not change.

    Args:
        pose: The pose. Default: the T-pose.
        bones: The names of joints for bones, where the guess is wrong: ``{"leftFoot": "ankle_L"}``.
    """
    return step_of("rest", bones=bones, pose=pose)


@step_function
def t_pose_first(*, bones: Bones | None = None) -> Step:
    """Inserts the T-pose before the first frame, on the floor at the start point.

    Args:
        bones: The names of joints for bones, where the guess is wrong: ``{"leftFoot": "ankle_L"}``.
    """
    return step_of("t-pose-first", bones=bones)


@step_function
def bone_axis(axis: Literal["y", "x"] | None = None, *, bones: Bones | None = None) -> Step:
    """Turns the frame of every joint at rest so that one of its axes points to the next joint, and another is the
    bending axis. Nothing moves, neither at rest nor in motion.

    Args:
        axis: The axis that points along the bone. Default: +Y.
        bones: The names of joints for bones, where the guess is wrong: ``{"leftFoot": "ankle_L"}``.
    """
    return step_of("bone-axis", bones=bones, axis=axis)


@step_function
def reach(
    to: str | Point,
    limb: Limb | None = None,
    *,
    offset: Point | None = None,
    start: str | None = None,
    tip: str | None = None,
    range: TimeRange | None = None,
    ease_in: float | None = None,
    ease_out: float | None = None,
    bones: Bones | None = None,
) -> Step:
    """Brings a hand or a foot to a target in a range of a motion: the wrist or the ankle, or a joint below it. The
    limb stays at the target during the range. It moves to the target before the range, and back after it. Two bones
    turn by the law of cosines, about the axis about which the limb bends in the motion. A hand turns with its
    forearm, a foot keeps its rotation in the world. Nothing else changes.

    Args:
        to: The target.
        limb: The limb. Default: the right hand.
        offset: The point to reach, from the origin of the target in metres along its axes. Default: the origin.
        start: The first joint of a chain of any skeleton, instead of a limb. Default: none.
        tip: The joint that moves to the target, at or below the hand or the foot, or below ``start``. Default: the
            wrist or the ankle, or the only end effector below ``start``.
        range: The range in which the limb is at the target. Default: the whole motion.
        ease_in: Duration of the movement to the target before the range, in seconds. Default: 0.4.
        ease_out: Duration of the movement back after the range, in seconds. Default: 0.4.
        bones: The names of joints for bones, where the guess is wrong: ``{"leftFoot": "ankle_L"}``.
    """
    return step_of(
        "reach",
        bones=bones,
        limb=limb,
        to=target_of(to),
        offset=target_of(offset),
        start=start,
        tip=tip,
        range=time_range(range),
        ease_in=ease_in,
        ease_out=ease_out,
    )


@step_function
def pin(
    to: str | Point | None = None,
    limb: Limb | None = None,
    *,
    start: str | None = None,
    tip: str | None = None,
    range: TimeRange | None = None,
    distance: float | None = None,
    speed: float | None = None,
    blend: float | None = None,
    bones: Bones | None = None,
) -> Step:
    """Holds a hand or a foot at the object that it touches. The limb keeps its mean position in the frame of the
    target, which may move and rotate. If the limb is too short, it comes as near as possible. The limb is held in a
    given range, or in every range in which it is near the target and slow relative to it. Two bones, or the joints
    of a chain, turn as in ``reach``. Nothing else changes. Use ``foot-lock`` for feet on the floor, because it lets
    them roll.

    Args:
        to: The target that the limb touches. Default: the world, at the position of the limb.
        limb: The limb. Default: the right hand.
        start: The first joint of a chain of any skeleton, instead of a limb. Default: none.
        tip: The joint that touches the target, at or below the hand or the foot, or below ``start``. Default: the
            wrist or the ankle, or the only end effector below ``start``.
        range: The range of the contact. Default: detected.
        distance: The largest distance of a detected contact from the target, in metres. Default: 0.3, from joint to
            joint.
        speed: The largest speed of a detected contact relative to the target, in metres per second. Default: 0.25.
        blend: Blend time before and after a contact, in seconds. Default: 0.2.
        bones: The names of joints for bones, where the guess is wrong: ``{"leftFoot": "ankle_L"}``.
    """
    return step_of(
        "pin",
        bones=bones,
        limb=limb,
        to=target_of(to),
        start=start,
        tip=tip,
        range=time_range(range),
        distance=distance,
        speed=speed,
        blend=blend,
    )


@step_function
def look_at(
    at: str | Point,
    *,
    neck: float | None = None,
    limit: float | None = None,
    range: TimeRange | None = None,
    ease_in: float | None = None,
    ease_out: float | None = None,
    bones: Bones | None = None,
) -> Step:
    """Turns neck and head so that the figure looks at a target in a range of a motion. The line of sight goes through
    the target. It starts between the eyes, or at the joint of the head, and points forward. The neck takes a
    fraction of the rotation, the head the rest. Beyond the limit, an angle from the facing of the trunk, the head
    stays behind smoothly. The figure does not look at a target behind its back. The head follows a faster target
    with at most 400 degrees per second: it starts earlier and arrives later.

    Args:
        at: The target.
        neck: The fraction of the rotation that the neck takes. Default: 0.4.
        limit: The largest angle between the facing of the trunk and the target at which the figure looks at the
            target, in degrees. Default: 80.
        range: The range in which the figure looks at the target. Default: the whole motion.
        ease_in: Duration of the turn to the target before the range, in seconds. Default: 0.4.
        ease_out: Duration of the turn back after the range, in seconds. Default: 0.4.
        bones: The names of joints for bones, where the guess is wrong: ``{"leftFoot": "ankle_L"}``.
    """
    return step_of(
        "look-at",
        bones=bones,
        at=target_of(at),
        neck=neck,
        limit=limit,
        range=time_range(range),
        ease_in=ease_in,
        ease_out=ease_out,
    )


@step_function
def ground(*, bones: Bones | None = None) -> Step:
    """Puts a motion on the floor at height 0. It removes the slope of the floor and the drift of the body as ``clean``
    does, and then the height, however small. Hills, stairs and treadmills do not change:
    ``docs/cleaning-algorithm.md`` describes their detection.

    Args:
        bones: The names of joints for bones, where the guess is wrong: ``{"leftFoot": "ankle_L"}``.
    """
    return step_of("ground", bones=bones)


@step_function
def turn(
    by: float | None = None,
    *,
    facing: Literal["x", "-x", "y", "-y", "z", "-z"] | None = None,
    bones: Bones | None = None,
) -> Step:
    """Turns a motion about the vertical through the figure's place in the first frame. It turns by an angle, or until
    the figure faces a direction in that frame. Everything that the animation moves turns too.

    Args:
        by: The angle in degrees, counterclockwise as seen from above.
        facing: The axis of the scene along which the figure looks in the first frame.
        bones: The names of joints for bones, where the guess is wrong: ``{"leftFoot": "ankle_L"}``.
    """
    return step_of("turn", bones=bones, by=by, facing=facing)
