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
    """Holds each foot still during ground contact, and keeps it above the floor.

    Args:
        blend: Seconds before a contact during which the correction of the foot fades in, and after a contact during
            which it fades out. Default: 0.2.
        height: During a contact, the largest height of a foot above the height at which it rests, in metres.
            Default: 0.05.
        speed: During a contact, the largest speed of a foot, in metres per second. Default: 0.25.
        release: A contact ends when the height or the speed of the foot is above this factor times ``height`` or
            ``speed``. Default: 1.6.
        shortest: The shortest contact, in seconds. The step ignores shorter contacts. Default: 0.08.
        gap: The shortest gap between two contacts, in seconds. If a gap is shorter, both contacts become one.
            Default: 0.05.
        floor: The height of the floor along the up axis, in metres. Default: the height at which the feet rest.
        largest_change: The largest distance by which the step may move a joint that is not part of a foot, in
            metres. If a full lock would move a knee or the hips farther, a part of the sliding remains. Default:
            ``None``, no limit.
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
    """Mirrors a motion: the right side of the figure moves as the left side did, and the left side as the right side
    did. The mirror is a vertical plane, whose normal is the mean direction to the figure's left. A figure that
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
    """Removes fast changes from the rotations and positions of all joints, or of chosen joints. The result does not
    depend on the axes of the joints, and a joint may rotate by any angle. The first and the last frame do not
    change. Frames outside ``range`` do not change, except the frames within ``ease`` seconds of the range.

    Args:
        filter: The filter. Default: Butterworth.
        cut_off: The cut-off frequency in Hz: the filter keeps slower changes, and removes faster ones. Default: 6,
            which is above the frequencies of a walk.
        part: The part of the body to filter. Default: the whole body; with ``joints``, only these joints.
        joints: The joints to filter, by the name of a joint or of a bone. The step does not filter the joints below
            these joints. With ``part``, the step filters both the part and these joints.
        range: The time range to filter. Default: the whole motion.
        ease: Seconds before the range during which the effect of the filter fades in, and after the range during
            which it fades out. Default: 0.2.
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
    """Replaces spikes. A spike is a rotation or a position that jumps away for a few frames and comes back. The new
    values are interpolated between the frames before and after the spike.

    Args:
        threshold: The smallest distance of a spike from the frames before and after it, as a multiple of the median
            of such distances in the frames around. Default: 8.
        angle: The smallest jump of a rotation, in degrees. Default: 3.
        distance: The smallest jump of a position, as a fraction of the total length of all bones. Default: 0.02.
        longest: The longest spike, in frames. Default: 3.
    """
    return step_of("despike", threshold=threshold, angle=angle, distance=distance, longest=longest)


@step_function
def fill(*, longest: float | None = None, shortest: float | None = None) -> Step:
    """Fills gaps. A gap is a run of frames in which every joint exactly repeats the frame before. Capture programs
    write such frames while the cameras do not see the markers. The step replaces the gap by a cubic curve, which
    has the speeds of the motion before and after the gap. For markers and other points without a skeleton, a gap is
    a run of frames in which the cameras did not see the point.

    Args:
        longest: The longest gap to fill, in seconds. In a longer gap, the figure may be still on purpose. Default:
            0.5.
        shortest: The shortest gap to fill, in seconds. Default: 0, which also fills a single repeated frame.
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
    """Cleans a motion. It repairs timing, flips, noise, bone lengths, floor and foot contacts, in this order. A repair
    that finds no defect does not change the motion. If the skeleton is not a humanoid, the step does not repair
    floor and contacts.

    Args:
        time: Repair timing: frames that repeat the frame before, and missing frames. Default: ``True``.
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
    """Cuts a motion to a loop. Without ``frames``, the loop starts and ends at the two frames whose poses, speeds and
    foot contacts match best. The last frame equals the first frame, except for the position over the ground. Joint
    velocities are continuous at the seam, where the loop starts again.

    Args:
        frames: The first and the last frame of the loop. Default: the two frames that match best.
        shortest: The shortest loop to look for, in seconds. Default: 0.6.
        longest: The longest loop to look for, in seconds. Default: 4.
        blend: Seconds after the seam during which the difference between the first and the last pose fades out.
            Default: 0.3.
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
    """Appends a second motion, which has the same joints. At the seam, the last frame of the first motion and the
    first frame of the second motion become one frame. So ``concat`` restores a motion that was cut in two. The
    scene gets the warning ``poses-apart`` if the poses at the seam differ by more than 45 degrees or 30 cm, or the
    speeds by more than 1 m/s. With ``within``, the step joins the two most similar frames near the end of the first
    motion and near the start of the second motion. To compare two frames, it uses the distance of motion graphs,
    over a third of a second around each frame.

    Args:
        other: The second motion; one with another skeleton is retargeted.
        blend: Seconds after the seam during which the difference between the two poses fades out. Default: 0.3.
        align: Whether to move and turn the second motion so that it begins at the position and heading at which the
            first motion ends. Default: ``True``.
        within: The step searches this many seconds at the end of the first motion and at the beginning of the
            second motion for the two most similar frames. Default: 0, which keeps both motions completely.
    """
    return step_of("concat", other=other, blend=blend, align=align, within=within)


@step_function
def blend(
    other: SceneLike,
    weight: float | Sequence[tuple[float, float]] | None = None,
    *,
    within: float | None = None,
) -> Step:
    """Mixes a motion with a second motion, which has the same joints. Weight 0 gives the first motion, weight 1 the
    second motion. Dynamic time warping aligns the poses of both motions in time. So the step mixes two footsteps at
    the same phase. The duration is the weighted mean of both durations. The step mixes movements over the ground
    relative to the heading of each figure: two walks in different directions give a walk in a direction between
    them. The scene gets the warning ``poses-apart`` if two mixed poses differ by more than 45 degrees or 30 cm.
    This comparison ignores position and heading over the ground. With ``within``, the step drops frames at the
    beginning of one motion and at the end of one motion, so that both motions begin and end in similar poses. To
    compare two frames, it uses the distance of motion graphs, over a third of a second around each frame. With
    ``within``, the second motion also begins at the position and in the heading of the first motion.

    Args:
        other: The second motion; one with another skeleton is retargeted.
        weight: The fraction of the second motion: one number, or pairs of a time and a fraction. Default: 0.5 all
            the time.
        within: The step searches this many seconds at the beginning and at the end of both motions for the most
            similar frames. Default: 0, which mixes both motions completely.
    """
    return step_of("blend", other=other, weight=weight, within=within)


@step_function
def layer(
    other: SceneLike,
    part: Literal["upper", "legs", "arms", "head"] | None = None,
    *,
    bones: Bones | None = None,
) -> Step:
    """Takes the rotations of a part of the body from a second motion, which has the same joints. A rotation is
    relative to the parent joint. Both motions start at the same time. If the second motion ends first, the part of
    the body keeps its last pose.

    Args:
        other: The second motion; one with another skeleton is retargeted.
        part: The part of the body. Default: the spine and all joints above it, with the arms.
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
    """Makes a keyframe animation: keeps the poses of chosen frames, the keys, and interpolates all other frames.

    Args:
        keys: The frames whose poses the step keeps. It always keeps the first and the last frame, too.
        every: Frames whose number is a multiple of this number are also keys. Default: 0, no further keys.
        interpolation: The interpolation between keys. Default: squad, whose speed does not jump at a key. A speed
            that is constant over the keys stays constant.
    """
    return step_of("in-between", keys=keys, every=every, interpolation=interpolation)


@step_function
def resample(rate: float | None = None) -> Step:
    """Gives a motion another frame rate. The speed of the motion does not change.

    Args:
        rate: Frames per second. Default: 30.
    """
    return step_of("resample", rate=rate)


@step_function
def drop_first_frame(*, always: bool | None = None) -> Step:
    """Drops the first frame if it is a rest pose. Some programs write the rest pose as the first frame.

    Args:
        always: Whether to drop the first frame even if it is not a rest pose. Default: ``False``.
    """
    return step_of("drop-first-frame", always=always)


@step_function
def in_place() -> Step:
    """Keeps the root above the point over which it starts. The height and the rotation of the root do not change."""
    return step_of("in-place")


@step_function
def root_motion() -> Step:
    """Takes the horizontal motion away from the root and gives it to a new joint, which becomes the parent of the
    root."""
    return step_of("root-motion")


@step_function
def reverse() -> Step:
    """Plays a motion backwards: the last frame becomes the first frame. A second ``reverse`` restores the motion."""
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
    """Inserts a frame before the first frame. In the new frame, the figure stands in the T-pose on the floor, at the
    point over which the motion starts.

    Args:
        bones: The names of joints for bones, where the guess is wrong: ``{"leftFoot": "ankle_L"}``.
    """
    return step_of("t-pose-first", bones=bones)


@step_function
def bone_axis(axis: Literal["y", "x"] | None = None, *, bones: Bones | None = None) -> Step:
    """Turns the coordinate frame of every joint in the rest pose. One axis then points to the next joint, and another
    is the axis about which the joint bends. The positions of the joints do not change, neither in the rest pose nor
    in the motion.

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
    """Brings a hand or a foot to a target during a time range. The wrist, the ankle or the joint ``tip`` reaches the
    target. The limb moves to the target before the range, stays there during the range, and moves back after the
    range. The upper and the lower bone of the limb turn. The elbow or the knee bends about the same axis as in the
    rest of the motion. A hand turns with its forearm, but a foot keeps its rotation in the world. Nothing else
    changes.

    Args:
        to: The target: a point of the world in metres, or the name of a node.
        limb: The limb. Default: the right hand.
        offset: The position of the point to reach, in the coordinate frame of the target, in metres. Default: the
            origin of the target.
        start: For a skeleton without known limbs: the first joint of the chain that moves. It replaces ``limb``.
            Default: none.
        tip: The joint that comes to the target. It is the wrist, the ankle or a joint below. With ``start``, it is
            a joint below ``start``. Default: the wrist or the ankle; with ``start``, the only end effector below
            ``start``.
        range: The time range during which the limb is at the target. Default: the whole motion.
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
    """Holds a hand or a foot at the object that it touches, the target. During a contact, the limb keeps its mean
    position in the coordinate frame of the target. The target may move and rotate. If the limb is too short to
    reach this position, it comes as near as possible. A contact is the given range. Without a range, it is every
    time during which the limb is near the target and slow relative to the target. The bones turn as in ``reach``.
    Nothing else changes. For feet on the floor, use ``foot-lock``, which lets a foot roll.

    Args:
        to: The target that the limb touches: a point of the world in metres, or the name of a node. Default: the
            mean position of the limb in ``range``, which must then be given.
        limb: The limb. Default: the right hand.
        start: For a skeleton without known limbs: the first joint of the chain that moves. It replaces ``limb``.
            Default: none.
        tip: The joint that touches the target. It is the wrist, the ankle or a joint below. With ``start``, it is a
            joint below ``start``. Default: the wrist or the ankle; with ``start``, the only end effector below
            ``start``.
        range: The time range of the contact. Default: the step finds the contacts by ``distance`` and ``speed``.
        distance: If the step finds the contacts: the largest distance between ``tip`` and the origin of the target,
            in metres. Default: 0.3, because joints are inside the body.
        speed: If the step finds the contacts: the largest speed of ``tip`` relative to the target, in metres per
            second. Default: 0.25.
        blend: Duration of the movement to the target before a contact, and of the movement back after it, in
            seconds. Default: 0.2.
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
    """Turns neck and head so that, during a time range, the figure looks at a target. The line of sight then goes
    through the target. This line points forward from the middle between the eyes, or from the head joint if the
    skeleton has no eyes. The neck takes a fraction of the rotation, and the head takes the remaining rotation. If
    the target is farther to the side than ``limit``, the figure no longer looks exactly at the target: the head
    stops at most 15 degrees after the limit. The figure does not look at a target behind its back. The step adds at
    most 400 degrees of rotation per second. If the target moves faster, the turn starts earlier and ends later.

    Args:
        at: The target: a point of the world in metres, or the name of a node.
        neck: The fraction of the rotation that the neck takes. Default: 0.4.
        limit: The angle between the direction that the trunk faces and the direction to the target, in degrees. Up
            to this angle, the figure looks exactly at the target. Default: 80.
        range: The time range during which the figure looks at the target. Default: the whole motion.
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
    """Puts a motion on the floor at height 0. The step removes the slope of the floor and the drift of the body, as
    ``clean`` does. Then it moves the figure so that the floor is exactly at height 0. The slope of a hill or of
    stairs, and the drift on a treadmill, do not change: ``docs/cleaning-algorithm.md`` describes how mocap detects
    them.

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
    """Rotates a motion about the vertical line through the figure's position in the first frame. The step rotates by a
    given angle, or until the figure faces a given direction in the first frame. It also rotates everything else
    that the animation moves. Give either ``by`` or ``facing``.

    Args:
        by: The angle in degrees, counterclockwise as seen from above.
        facing: The axis of the scene along which the figure faces in the first frame of the result.
        bones: The names of joints for bones, where the guess is wrong: ``{"leftFoot": "ankle_L"}``.
    """
    return step_of("turn", bones=bones, by=by, facing=facing)
