"""Changes of a motion, each with a report of what it changed and by how much: the steps of ``mocap edit``.

>>> import mocap, mocap.edit
>>> walk = mocap.edit.prepare(mocap.read("walk.bvh"))       # doctest: +SKIP
>>> walk, report = mocap.edit.smooth(walk, cut_off=8)       # doctest: +SKIP
>>> report["largest_rotation"]                              # degrees    # doctest: +SKIP
4.25

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
from typing import Any, Literal, NamedTuple

from . import _mocap
from ._options import Axis, Unit, WriteOptions, changed, metres
from ._scene import Scene

__all__ = [
    "Edited",
    "apply",
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


class Edited(NamedTuple):
    """A changed scene, and what was changed."""

    scene: Scene
    report: dict[str, Any]


def prepare(scene: Scene, *, unit: Unit | float | None = None, up: Axis | None = None) -> Scene:
    """The scene in metres with +Y up, without a rest pose in its first frame, as the program changes it.

    Args:
        scene: A motion.
        unit: Its unit of length, by name or as metres in one; what the file says, else a guess, if ``None``.
        up: Its axis that points up; a guess if ``None``.
    """
    return Scene(_mocap.prepare(scene._native, metres(unit), up))


def apply(
    scene: Scene,
    step: str | Mapping[str, object],
    other: Scene | None = None,
    *,
    bones: Mapping[str, str | None] | None = None,
) -> Edited:
    """Applies a step: ``{"step": "smooth", "cut_off": 8}``, or as the program takes it, ``"smooth:cut-off=8"``.

    Args:
        scene: A motion.
        step: Its name and its options; an option that is ``None`` has its default.
        other: The second motion of a concat, a blend or a layer.
        bones: The names of joints for bones, where the guess is wrong: ``{"leftFoot": "ankle_L"}``.
    """
    if not isinstance(step, str):
        step = {key: value for key, value in step.items() if value is not None}
    native, report = _mocap.edit(
        scene._native,
        json.dumps(step, default=_plain),
        None if other is None else other._native,
        None if bones is None else json.dumps(dict(bones)),
    )
    return Edited(Scene(native), json.loads(report)["changed"])


def _plain(value: Any) -> object:
    """Numbers and arrays of NumPy."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"an option of a step cannot be {type(value).__name__}: {value!r}")


def _step(name: str, **options: object) -> dict[str, object]:
    return {"step": name, **options}


def foot_lock(
    scene: Scene,
    *,
    blend: float | None = None,
    height: float | None = None,
    speed: float | None = None,
    release: float | None = None,
    shortest: float | None = None,
    gap: float | None = None,
    floor: float | None = None,
    largest_change: float | None = None,
) -> Edited:
    """Holds feet still in contact and above the floor."""
    contact = dict(height=height, speed=speed, release=release, shortest=shortest, gap=gap)
    return apply(scene, _step("foot-lock", blend=blend, floor=floor, largest_change=largest_change, **contact))


def mirror(scene: Scene) -> Edited:
    """Exchanges left and right."""
    return apply(scene, _step("mirror"))


def smooth(
    scene: Scene,
    *,
    cut_off: float | None = None,
    filter: Literal["butterworth", "gaussian"] | None = None,
    part: Literal["upper", "legs", "arms", "head"] | None = None,
    joints: Sequence[str] | None = None,
    range: str | None = None,
    ease: float | None = None,
    bones: Mapping[str, str | None] | None = None,
) -> Edited:
    """Takes changes faster than ``cut_off``, in Hz, out: of all joints, or of a part of the body, or of ``joints``."""
    step = _step("smooth", cut_off=cut_off, filter=filter, part=part, joints=joints, range=range, ease=ease)
    return apply(scene, step, bones=bones)


def despike(
    scene: Scene,
    *,
    threshold: float | None = None,
    angle: float | None = None,
    distance: float | None = None,
    longest: int | None = None,
) -> Edited:
    """Takes single frames out that jump: ``threshold`` times farther than usual, and by ``angle`` in degrees."""
    return apply(scene, _step("despike", threshold=threshold, angle=angle, distance=distance, longest=longest))


def fill(scene: Scene, *, longest: float | None = None, shortest: float | None = None) -> Edited:
    """Fills gaps in which the motion was held."""
    return apply(scene, _step("fill", longest=longest, shortest=shortest))


def clean(
    scene: Scene,
    *,
    time: bool | None = None,
    flips: bool | None = None,
    noise: bool | None = None,
    lengths: bool | None = None,
    floor: bool | None = None,
    contacts: bool | None = None,
) -> Edited:
    """Takes errors of time, flips, noise, slopes of the floor and slides out: all parts but those that are ``False``."""
    options = dict(time=time, flips=flips, noise=noise, lengths=lengths, floor=floor, contacts=contacts)
    return apply(scene, _step("clean", **options))


def loop_clip(
    scene: Scene,
    *,
    frames: tuple[int, int] | None = None,
    shortest: float | None = None,
    longest: float | None = None,
    blend: float | None = None,
    in_place: bool | None = None,
) -> Edited:
    """Cuts to a loop: ``frames``, or the best one of ``shortest`` to ``longest`` seconds."""
    options = dict(frames=frames, shortest=shortest, longest=longest, blend=blend, in_place=in_place)
    return apply(scene, _step("loop", **options))


def concat(
    scene: Scene,
    other: Scene,
    *,
    blend: float | None = None,
    align: bool | None = None,
    within: float | None = None,
) -> Edited:
    """Appends ``other``, from where the scene ends unless ``align`` is ``False``.

    ``within`` so many seconds of the end and of the beginning of ``other``, the two are joined where they are most alike.
    A motion with another skeleton is retargeted.
    """
    return apply(scene, _step("concat", blend=blend, align=align, within=within), other)


def blend(
    scene: Scene, other: Scene, weight: float | Sequence[tuple[float, float]] = 0.5, *, within: float | None = None
) -> Edited:
    """Mixes with ``other``, aligned in time. ``weight`` is from 0 to 1, or a curve: pairs of seconds and a weight.

    ``within`` so many seconds of their beginnings and ends, both begin and end where they are most alike. A motion with
    another skeleton is retargeted.
    """
    return apply(scene, _step("blend", weight=weight, within=within), other)


def layer(scene: Scene, other: Scene, part: Literal["upper", "legs", "arms", "head"] = "upper") -> Edited:
    """Takes a part of the body from ``other``."""
    return apply(scene, _step("layer", part=part), other)


def warp_time(
    scene: Scene, moments: Sequence[tuple[float, float]] | None = None, *, speed: float | None = None
) -> Edited:
    """Moves moments: pairs of a time and the time at which it is to be. Or all at a ``speed``."""
    if (moments is None) == (speed is None):
        raise TypeError("give either moments or a speed")
    return apply(scene, _step("warp", moments=moments, speed=speed))


def warp_path(
    scene: Scene,
    points: Sequence[tuple[float, float] | tuple[float, float, float]],
    facing: Literal["along", "kept"] = "along",
) -> Edited:
    """Bends the way over the ground to ``points``: two coordinates in metres, or before them a time in seconds."""

    def point(numbers: Sequence[float]) -> dict[str, object]:
        at: dict[str, object] = {"at": list(numbers[-2:])}
        return at if len(numbers) == 2 else {"seconds": numbers[0], **at}

    return apply(scene, _step("warp", path=[point(numbers) for numbers in points], facing=facing))


def in_between(
    scene: Scene,
    *,
    keys: Sequence[int] | None = None,
    every: int | None = None,
    interpolation: Literal["slerp", "squad"] | None = None,
) -> Edited:
    """Keeps key frames, and computes the others."""
    return apply(scene, _step("in-between", keys=keys, every=every, interpolation=interpolation))


def trim(scene: Scene, first: float = 0.0, last: float | None = None) -> Edited:
    """Keeps the part from ``first`` to ``last``, in seconds."""
    return apply(scene, _step("trim", range=f"{first}..{'' if last is None else last}"))


def resample(scene: Scene, rate: float) -> Edited:
    """Changes the frame rate, at the same speed."""
    return apply(scene, _step("resample", rate=rate))


def drop_first_frame(scene: Scene, *, always: bool | None = None) -> Edited:
    """Drops the first frame where it is a rest pose, or ``always``."""
    return apply(scene, _step("drop-first-frame", always=always))


def in_place(scene: Scene) -> Edited:
    """Takes the motion of the root over the ground out."""
    return apply(scene, _step("in-place"))


def root_motion(scene: Scene) -> Edited:
    """Moves the motion of the root over the ground to a joint of its own."""
    return apply(scene, _step("root-motion"))


def reverse(scene: Scene) -> Edited:
    """Plays the motion backwards."""
    return apply(scene, _step("reverse"))


def rest(scene: Scene, pose: Literal["t-pose", "a-pose"] = "t-pose") -> Edited:
    """Makes the T-pose or the A-pose the rest pose. The motion does not change."""
    return apply(scene, _step("rest", pose=pose))


def t_pose_first(scene: Scene) -> Edited:
    """Puts the T-pose before the first frame, on the floor."""
    return apply(scene, _step("t-pose-first"))


def bone_axis(scene: Scene, axis: Literal["y", "x"] = "y") -> Edited:
    """Turns the frames of joints at rest so that an axis points along each bone. The motion does not change."""
    return apply(scene, _step("bone-axis", axis=axis))


def reach(
    scene: Scene,
    to: str | Sequence[float],
    limb: Limb = "right-hand",
    *,
    offset: Sequence[float] | None = None,
    tip: str | None = None,
    range: str | None = None,
    ease_in: float | None = None,
    ease_out: float | None = None,
) -> Edited:
    """Brings a hand or a foot to a point in metres, or to a joint, a bone or a node by its name.

    ``range`` is the part in which it is there, as the program takes it: ``"1..2.5"`` in seconds, ``"30f..75f"`` in frames.
    """
    options = dict(offset=None if offset is None else list(offset), tip=tip, range=range)
    return apply(scene, _step("reach", limb=limb, to=_target(to), ease_in=ease_in, ease_out=ease_out, **options))


def _target(to: str | Sequence[float] | None) -> object:
    return to if to is None or isinstance(to, str) else list(to)


def pin(
    scene: Scene,
    to: str | Sequence[float] | None = None,
    limb: Limb = "right-hand",
    *,
    tip: str | None = None,
    range: str | None = None,
    distance: float | None = None,
    speed: float | None = None,
    blend: float | None = None,
) -> Edited:
    """Keeps a hand or a foot on what it touches, in the part ``range`` or wherever it is near and slow beside it."""
    options = dict(tip=tip, range=range, distance=distance, speed=speed, blend=blend)
    return apply(scene, _step("pin", limb=limb, to=_target(to), **options))


def look_at(
    scene: Scene,
    at: str | Sequence[float],
    *,
    neck: float | None = None,
    limit: float | None = None,
    range: str | None = None,
    ease_in: float | None = None,
    ease_out: float | None = None,
) -> Edited:
    """Turns neck and head to a point in metres, or to a joint, a bone or a node, within ``limit`` degrees."""
    options = dict(neck=neck, limit=limit, range=range, ease_in=ease_in, ease_out=ease_out)
    return apply(scene, _step("look-at", at=_target(at), **options))


def ground(scene: Scene) -> Edited:
    """Puts the motion on the floor: takes out its height and slope, and the drift of the body."""
    return apply(scene, _step("ground"))


def turn(
    scene: Scene, by: float | None = None, *, facing: Literal["x", "-x", "y", "-y", "z", "-z"] | None = None
) -> Edited:
    """Turns about the vertical by degrees, or until the figure looks along an axis in the first frame."""
    return apply(scene, _step("turn", by=by, facing=facing))


def contacts(
    scene: Scene,
    *,
    hands: bool = False,
    height: float | None = None,
    speed: float | None = None,
    release: float | None = None,
    shortest: float | None = None,
    gap: float | None = None,
) -> dict[str, Any]:
    """When the feet are at rest, and the hands if asked: for each point ``at_rest``, frame by frame."""
    options = dict(hands=hands, height=height, speed=speed, release=release, shortest=shortest, gap=gap)
    given = {key: value for key, value in options.items() if value is not None}
    found: dict[str, Any] = json.loads(_mocap.contacts(scene._native, json.dumps(given)))
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
