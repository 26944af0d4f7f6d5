"""Changes of a motion, each with a report of what it changed and by how much: the steps of ``mocap edit``.

>>> import mocap, mocap.edit
>>> walk = mocap.edit.prepare(mocap.read("walk.bvh"))       # doctest: +SKIP
>>> walk, report = mocap.edit.smooth(walk, cut_off=8)       # doctest: +SKIP
>>> report["largest_rotation"]                              # degrees    # doctest: +SKIP
4.25

Each function makes a :class:`Step` too, which can be kept, compared, pickled, and put into the ``steps`` of a job:

>>> gentle = [mocap.edit.smooth.step(cut_off=8), mocap.edit.foot_lock.step()]      # doctest: +SKIP
>>> walk, reports = mocap.edit.apply_all(walk, gentle)                             # doctest: +SKIP

A scene never changes: a function returns a new one. Lengths in options and reports are in metres whatever the unit of
the scene, times in seconds, angles in degrees. What is not given has the default of the program; ``docs/editing.md`` says
what each step does. The steps stand in ``scene.metadata["steps"]``, and in the glTF file that :func:`write` makes.

Every function raises :class:`mocap.MocapError` where an option is not valid, or where a step needs a humanoid and
the skeleton is not one.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal

from . import _mocap
from ._errors import UnknownOptionError
from ._options import Axis, Unit, WriteOptions, changed, metres, names_of
from ._scene import Scene
from ._step import Edited, Step, apply, apply_all, step_function, step_of

__all__ = [
    "Edited",
    "Step",
    "apply",
    "apply_all",
    "blend",
    "bone_axis",
    "clean",
    "concat",
    "contacts",
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
    "prepare",
    "reach",
    "resample",
    "rest",
    "reverse",
    "root_motion",
    "smooth",
    "t_pose_first",
    "trim",
    "turn",
    "warp_path",
    "warp_time",
    "write",
]


Limb = Literal["left-hand", "right-hand", "left-foot", "right-foot"]


def prepare(
    scene: Scene,
    *,
    unit: Unit | float | None = None,
    up: Axis | None = None,
    bones: Mapping[str, str | None] | None = None,
) -> Scene:
    """The scene in metres with +Y up, without a rest pose in its first frame, as the program changes it.

    Args:
        scene: A motion.
        unit: Its unit of length, by name or as metres in one; what the file says, else a guess, if ``None``.
        up: Its axis that points up; a guess if ``None``.
        bones: The names of joints for bones, where the guess is wrong; unit and axis are guessed from the bones.
    """
    return Scene(_mocap.prepare(scene._native, metres(unit), up, names_of(bones)))


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
) -> Step:
    """Holds feet still in contact and above the floor."""
    contact = dict(height=height, speed=speed, release=release, shortest=shortest, gap=gap)
    return step_of("foot-lock", blend=blend, floor=floor, largest_change=largest_change, **contact)


@step_function
def mirror() -> Step:
    """Exchanges left and right."""
    return step_of("mirror")


@step_function
def smooth(
    *,
    cut_off: float | None = None,
    filter: Literal["butterworth", "gaussian"] | None = None,
    part: Literal["upper", "legs", "arms", "head"] | None = None,
    joints: Sequence[str] | None = None,
    range: str | None = None,
    ease: float | None = None,
    bones: Mapping[str, str | None] | None = None,
) -> Step:
    """Takes changes faster than ``cut_off``, in Hz, out: of all joints, or of a part of the body, or of ``joints``."""
    step = step_of("smooth", cut_off=cut_off, filter=filter, part=part, joints=joints, range=range, ease=ease)
    return replace(step, bones=bones)


@step_function
def despike(
    *,
    threshold: float | None = None,
    angle: float | None = None,
    distance: float | None = None,
    longest: int | None = None,
) -> Step:
    """Takes single frames out that jump: ``threshold`` times farther than usual, and by ``angle`` in degrees."""
    return step_of("despike", threshold=threshold, angle=angle, distance=distance, longest=longest)


@step_function
def fill(*, longest: float | None = None, shortest: float | None = None) -> Step:
    """Fills gaps in which the motion was held."""
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
) -> Step:
    """Takes errors of time, flips, noise, slopes of the floor and slides out: all parts but those that are ``False``."""
    options = dict(time=time, flips=flips, noise=noise, lengths=lengths, floor=floor, contacts=contacts)
    return step_of("clean", **options)


@step_function
def loop_clip(
    *,
    frames: tuple[int, int] | None = None,
    shortest: float | None = None,
    longest: float | None = None,
    blend: float | None = None,
    in_place: bool | None = None,
) -> Step:
    """Cuts to a loop: ``frames``, or the best one of ``shortest`` to ``longest`` seconds."""
    options = dict(frames=frames, shortest=shortest, longest=longest, blend=blend, in_place=in_place)
    return step_of("loop", **options)


@step_function
def concat(
    other: Scene,
    *,
    blend: float | None = None,
    align: bool | None = None,
    within: float | None = None,
) -> Step:
    """Appends ``other``, from where the scene ends unless ``align`` is ``False``.

    ``within`` so many seconds of the end and of the beginning of ``other``, the two are joined where they are most alike.
    A motion with another skeleton is retargeted.
    """
    return replace(step_of("concat", blend=blend, align=align, within=within), other=other)


@step_function
def blend(
    other: Scene, weight: float | Sequence[tuple[float, float]] = 0.5, *, within: float | None = None
) -> Step:
    """Mixes with ``other``, aligned in time. ``weight`` is from 0 to 1, or a curve: pairs of seconds and a weight.

    ``within`` so many seconds of their beginnings and ends, both begin and end where they are most alike. A motion with
    another skeleton is retargeted.
    """
    return replace(step_of("blend", weight=weight, within=within), other=other)


@step_function
def layer(other: Scene, part: Literal["upper", "legs", "arms", "head"] = "upper") -> Step:
    """Takes a part of the body from ``other``."""
    return replace(step_of("layer", part=part), other=other)


@step_function
def warp_time(
    moments: Sequence[tuple[float, float]] | None = None, *, speed: float | None = None
) -> Step:
    """Moves moments: pairs of a time and the time at which it is to be. Or all at a ``speed``."""
    if (moments is None) == (speed is None):
        raise UnknownOptionError("give either moments or a speed")
    return step_of("warp", moments=moments, speed=speed)


@step_function
def warp_path(
    points: Sequence[tuple[float, float] | tuple[float, float, float]],
    facing: Literal["along", "kept"] = "along",
) -> Step:
    """Bends the way over the ground to ``points``: two coordinates in metres, or before them a time in seconds."""

    def point(numbers: Sequence[float]) -> dict[str, object]:
        at: dict[str, object] = {"at": list(numbers[-2:])}
        return at if len(numbers) == 2 else {"seconds": numbers[0], **at}

    return step_of("warp", path=[point(numbers) for numbers in points], facing=facing)


@step_function
def in_between(
    *,
    keys: Sequence[int] | None = None,
    every: int | None = None,
    interpolation: Literal["slerp", "squad"] | None = None,
) -> Step:
    """Keeps key frames, and computes the others."""
    return step_of("in-between", keys=keys, every=every, interpolation=interpolation)


@step_function
def trim(first: float = 0.0, last: float | None = None) -> Step:
    """Keeps the part from ``first`` to ``last``, in seconds."""
    return step_of("trim", range=f"{first}..{'' if last is None else last}")


@step_function
def resample(rate: float) -> Step:
    """Changes the frame rate, at the same speed."""
    return step_of("resample", rate=rate)


@step_function
def drop_first_frame(*, always: bool | None = None) -> Step:
    """Drops the first frame where it is a rest pose, or ``always``."""
    return step_of("drop-first-frame", always=always)


@step_function
def in_place() -> Step:
    """Takes the motion of the root over the ground out."""
    return step_of("in-place")


@step_function
def root_motion() -> Step:
    """Moves the motion of the root over the ground to a joint of its own."""
    return step_of("root-motion")


@step_function
def reverse() -> Step:
    """Plays the motion backwards."""
    return step_of("reverse")


@step_function
def rest(pose: Literal["t-pose", "a-pose"] = "t-pose") -> Step:
    """Makes the T-pose or the A-pose the rest pose. The motion does not change."""
    return step_of("rest", pose=pose)


@step_function
def t_pose_first() -> Step:
    """Puts the T-pose before the first frame, on the floor."""
    return step_of("t-pose-first")


@step_function
def bone_axis(axis: Literal["y", "x"] = "y") -> Step:
    """Turns the frames of joints at rest so that an axis points along each bone. The motion does not change."""
    return step_of("bone-axis", axis=axis)


@step_function
def reach(
    to: str | Sequence[float],
    limb: Limb = "right-hand",
    *,
    offset: Sequence[float] | None = None,
    tip: str | None = None,
    range: str | None = None,
    ease_in: float | None = None,
    ease_out: float | None = None,
) -> Step:
    """Brings a hand or a foot to a point in metres, or to a joint, a bone or a node by its name.

    ``range`` is the part in which it is there, as the program takes it: ``"1..2.5"`` in seconds, ``"30f..75f"`` in frames.
    """
    options = dict(offset=None if offset is None else list(offset), tip=tip, range=range)
    return step_of("reach", limb=limb, to=_target(to), ease_in=ease_in, ease_out=ease_out, **options)


def _target(to: str | Sequence[float] | None) -> object:
    return to if to is None or isinstance(to, str) else list(to)


@step_function
def pin(
    to: str | Sequence[float] | None = None,
    limb: Limb = "right-hand",
    *,
    tip: str | None = None,
    range: str | None = None,
    distance: float | None = None,
    speed: float | None = None,
    blend: float | None = None,
) -> Step:
    """Keeps a hand or a foot on what it touches, in the part ``range`` or wherever it is near and slow beside it."""
    options = dict(tip=tip, range=range, distance=distance, speed=speed, blend=blend)
    return step_of("pin", limb=limb, to=_target(to), **options)


@step_function
def look_at(
    at: str | Sequence[float],
    *,
    neck: float | None = None,
    limit: float | None = None,
    range: str | None = None,
    ease_in: float | None = None,
    ease_out: float | None = None,
) -> Step:
    """Turns neck and head to a point in metres, or to a joint, a bone or a node, within ``limit`` degrees."""
    options = dict(neck=neck, limit=limit, range=range, ease_in=ease_in, ease_out=ease_out)
    return step_of("look-at", at=_target(at), **options)


@step_function
def ground() -> Step:
    """Puts the motion on the floor: takes out its height and slope, and the drift of the body."""
    return step_of("ground")


@step_function
def turn(
    by: float | None = None, *, facing: Literal["x", "-x", "y", "-y", "z", "-z"] | None = None
) -> Step:
    """Turns about the vertical by degrees, or until the figure looks along an axis in the first frame."""
    return step_of("turn", by=by, facing=facing)


def contacts(
    scene: Scene,
    *,
    hands: bool = False,
    height: float | None = None,
    speed: float | None = None,
    release: float | None = None,
    shortest: float | None = None,
    gap: float | None = None,
    bones: Mapping[str, str | None] | None = None,
) -> dict[str, Any]:
    """When the feet are at rest, and the hands if asked: for each point ``at_rest``, frame by frame."""
    options = dict(hands=hands, height=height, speed=speed, release=release, shortest=shortest, gap=gap)
    given = {key: value for key, value in options.items() if value is not None}
    found: dict[str, Any] = json.loads(_mocap.contacts(scene._native, json.dumps(given), names_of(bones)))
    return found


def write(scene: Scene, target: str | os.PathLike[str], **options: Any) -> None:
    """Writes the scene in the format of the target's extension, as ``mocap formats`` lists them; the file is whole or
    absent. A file that may be somebody's source is not replaced.

    glTF and FBX record the steps; BVH and ``.mclip`` have no field for them.

    Args:
        scene: The scene.
        target: The file to write.
        options: The fields of :class:`mocap.WriteOptions`.

    Raises:
        MocapError: Where the target cannot be written.
        ValueError: Where the extension is that of no written format, or an option has no effect on it.
    """
    _mocap.write(scene._native, target, changed(WriteOptions(), options))
