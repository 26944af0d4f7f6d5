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
        blend: Seconds in which a shift eases out after a contact, and in before one. Default: 0.2.
        height: The largest height of a foot in contact above the level of rest, in metres. Default: 0.05.
        speed: The largest speed of a foot in contact, in metres per second. Default: 0.25.
        release: How many times as high or as fast a foot in contact must be to leave. Default: 1.6.
        shortest: The shortest contact, in seconds; shorter ones are dropped. Default: 0.08.
        gap: The shortest gap between two contacts, in seconds; shorter ones are closed. Default: 0.05.
        floor: The height of the floor along the up axis, in metres. Default: where the feet rest.
        largest_change: The largest change of any other joint, in metres: a foot that would take a knee or the hips
            farther gives way, and keeps a part of its slide. Default: ``None``, no foot slides.
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
    """Mirrors a motion across the plane of the figure, as it looks on the average: what the left side does the right
    one does then. A figure that walks forward still walks forward.

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
    """Filters rotations and positions, of all joints or of some. Rotations are averaged in the tangent space of each,
    so that no axis is preferred, and a joint may rotate as far as it likes. The first and the last frame stay, and
    everything outside a range and its ease.

    Args:
        filter: The filter. Default: Butterworth.
        cut_off: The cut-off in Hz. Default: 6, which keeps a walk.
        part: The part of the body. Default: everything, unless joints are named.
        joints: Joints by their names or by those of bones, each without what is below it; with a part, they come to
            it.
        range: The part of the motion. Default: the whole.
        ease: Seconds before and after the range in which the filter comes and goes. Default: 0.2.
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
    """Replaces rotations and positions that leave the motion for a few frames and come back, by what lies between the
    frames before and after.

    Args:
        threshold: How many times farther off its neighbours than the frames around it a frame must be. Default: 8.
        angle: The smallest jump of a rotation, in degrees. Default: 3.
        distance: The smallest jump of a position, as a fraction of the distance between the ends of the skeleton.
            Default: 0.02.
        longest: The longest spike, in frames. Default: 3.
    """
    return step_of("despike", threshold=threshold, angle=angle, distance=distance, longest=longest)


@step_function
def fill(*, longest: float | None = None, shortest: float | None = None) -> Step:
    """Fills gaps: frames in which every joint holds exactly the values of the frame before, as programs write them
    when markers were not seen. The motion goes on through a gap on the cubic curve that has the speeds before and
    after it. Of markers and other points without a skeleton, the gaps are the frames in which each was not seen.

    Args:
        longest: The longest gap to fill, in seconds: what is held longer may be meant. Default: 0.5.
        shortest: The shortest, in seconds. Default: 0, two equal frames.
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
    without a defect do not change. A skeleton that is no humanoid keeps its floor and contacts.

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
        blend: Seconds in which the difference of the poses fades after the seam. Default: 0.3.
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
    """Appends a second motion, which has the same joints. The first frame of the second is the last of the first: a
    motion that is cut in two there comes back. Poses more than 45 degrees or 30 cm apart at the seam, and speeds
    more than 1 m/s, are a warning of the scene, ``PosesApart``. ``within`` lets the end of the first and the
    beginning of the second go where the two are more alike nearby: by the distance of motion graphs, of windows of
    a third of a second.

    Args:
        other: The second motion; one with another skeleton is retargeted.
        blend: Seconds in which the difference of the poses fades after the seam. Default: 0.3.
        align: Whether the second motion begins where the first one ends, and looks where it looks. Default:
            ``True``.
        within: Seconds of the end of the first and of the beginning of the second within which they are joined,
            where they are most alike. Default: 0, all of both stays.
    """
    return step_of("concat", other=other, blend=blend, align=align, within=within)


@step_function
def blend(
    other: SceneLike,
    weight: float | Sequence[tuple[float, float]] | None = None,
    *,
    within: float | None = None,
) -> Step:
    """Mixes with a second motion, which has the same joints. At weight 0 it is the first, at 1 the second. The two are
    aligned in time by dynamic time warping of their poses, so that a step meets a step, and the result is as long
    as its fraction of both. Its steps over the ground are mixed as each figure sees them from where it looks, so
    two walks in different directions are a walk in one between. Poses that are mixed and are more than 45 degrees
    or 30 cm apart, wherever the figures stand, are a warning of the scene, ``PosesApart``. ``within`` lets one of
    the two begin later, and one end earlier, where the two are more alike: by the distance of motion graphs, of
    windows of a third of a second. The second motion then begins where the first does, and looks where it looks.

    Args:
        other: The second motion; one with another skeleton is retargeted.
        weight: The fraction of the second motion. Default: 0.5 all the time.
        within: Seconds at the beginning and at the end of both within which they begin and end, where they are most
            alike. Default: 0, all of both is mixed.
    """
    return step_of("blend", other=other, weight=weight, within=within)


@step_function
def layer(
    other: SceneLike,
    part: Literal["upper", "legs", "arms", "head"] | None = None,
    *,
    bones: Bones | None = None,
) -> Step:
    """Gives the joints of a part of the body the rotations to their parents that they have in a second motion, which
    has the same joints, at the same time. Where the second motion ends, its last pose stays.

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
    """Keyframe animation: keeps the poses of chosen frames, and replaces the others by what lies between those.

    Args:
        keys: The frames whose poses stay. The first and the last frame always do.
        every: Every so many frames stay, besides those. Default: 0, no others.
        interpolation: How the others are computed. Default: squad, which keeps constant speeds and has no jumps of
            speed.
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
    """Drops the first frame, which is a rest pose in some files; by default only where it is one.

    Args:
        always: Whether it is dropped also where it is no rest pose. Default: ``False``.
    """
    return step_of("drop-first-frame", always=always)


@step_function
def in_place() -> Step:
    """Keeps the root above where it begins: its height and its rotation stay."""
    return step_of("in-place")


@step_function
def root_motion() -> Step:
    """Moves the motion of the root over the ground to a new joint above it."""
    return step_of("root-motion")


@step_function
def reverse() -> Step:
    """Plays a motion backwards: its last frame is its first. Twice, it is what it was."""
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
    """Puts the T-pose before the first frame: on the floor, where the motion begins.

    Args:
        bones: The names of joints for bones, where the guess is wrong: ``{"leftFoot": "ankle_L"}``.
    """
    return step_of("t-pose-first", bones=bones)


@step_function
def bone_axis(axis: Literal["y", "x"] | None = None, *, bones: Bones | None = None) -> Step:
    """Turns the frame of every joint at rest so that one of its axes points to the next joint, and another is the axis
    about which the joint bends. Nothing moves, neither at rest nor in motion.

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
    """Brings a hand or a foot to a target in a part of a motion: the wrist or the ankle, or a joint below it. Within
    the part it is there; before and after it goes there and back. Two bones are turned, by the law of cosines; the
    limb bends about the axis about which it bends in the motion. A hand turns with its forearm, a foot keeps its
    rotation in the world. Everything else stays.

    Args:
        to: The target.
        limb: The limb. Default: the right hand.
        offset: A point that goes along with the target, from its origin in metres along its axes. Default: its
            origin.
        start: The first joint of a chain of any skeleton, instead of a limb. Default: none.
        tip: The joint that goes to the target, at or below the hand or the foot, or below ``start``. Default: the
            wrist or the ankle, or the only end effector below ``start``.
        range: The part in which it is at the target. Default: the whole motion.
        ease_in: Seconds before the part in which it goes there. Default: 0.4.
        ease_out: Seconds after the part in which it goes back. Default: 0.4.
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
    """Holds a hand or a foot where it touches: at its mean position in the frame of what it touches, which may move
    and rotate, or next to it where the limb is too short for that. It is held in a given part of the motion, or in
    every part in which it is near and slow beside it. Two bones, or the joints of a chain, are turned as by
    ``Reach``; everything else stays. Feet on the floor are for ``FootLock``, which lets them roll.

    Args:
        to: What it touches. Default: the world, where it is.
        limb: The limb. Default: the right hand.
        start: The first joint of a chain of any skeleton, instead of a limb. Default: none.
        tip: The joint that touches, at or below the hand or the foot, or below ``start``. Default: the wrist or the
            ankle, or the only end effector below ``start``.
        range: The part in which it touches. Default: found.
        distance: The largest distance from the target of a contact that is found, in metres. Default: 0.3, from
            joint to joint.
        speed: The largest speed in the frame of the target of a contact that is found, in metres per second.
            Default: 0.25.
        blend: Seconds in which the change comes before a contact, and goes after it. Default: 0.2.
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
    """Turns neck and head so that the figure looks at a target in a part of a motion: the line forward from between
    the eyes, or from the joint of the head, goes through it. The neck takes a fraction of the rotation, the head
    the rest. Beyond the limit, an angle from where the trunk faces, the head stays behind smoothly; at what is
    behind its back the figure does not look.

    Args:
        at: The target.
        neck: The fraction of the rotation that the neck takes. Default: 0.4.
        limit: The largest angle from where the trunk faces at which it looks at the target, in degrees. Default:
            80.
        range: The part in which it looks there. Default: the whole motion.
        ease_in: Seconds before the part in which it turns there. Default: 0.4.
        ease_out: Seconds after the part in which it turns back. Default: 0.4.
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
    """Puts a motion on the floor at height 0: takes out the slope of the floor and the drift of the body as ``clean``
    does, and then the height, however small. ``docs/cleaning.md`` says how they are found, and what counts as a
    hill, as stairs and as a treadmill, which stay.

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
    """Turns a motion about the vertical through where the figure stands in the first frame, by an angle, or until it
    looks in a direction there. Everything that the animation moves goes along.

    Args:
        by: The angle in degrees, counterclockwise as seen from above.
        facing: The axis of the scene along which the figure looks in the first frame.
        bones: The names of joints for bones, where the guess is wrong: ``{"leftFoot": "ankle_L"}``.
    """
    return step_of("turn", bones=bones, by=by, facing=facing)
