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

from collections.abc import Sequence
from typing import Literal

from . import _mocap, _steps
from ._call import public
from ._errors import UnknownOptionError
from ._files import write
from ._options import Axis, Bones, Unit, as_json, metres, names_of
from ._report import Report, parsed
from ._scene import Scene, SceneLike, native_of
from ._step import Edited, Step, apply, apply_all, path_points, step_function, step_of
from ._steps import *  # noqa: F403

__all__ = [
    "Edited",
    "Step",
    "apply",
    "apply_all",
    "contacts",
    "prepare",
    "trim",
    "warp_path",
    "warp_time",
    "write",
    *_steps.__all__,
]


@public
def prepare(
    scene: SceneLike,
    *,
    unit: Unit | float | None = None,
    up: Axis | None = None,
    bones: Bones | None = None,
) -> Scene:
    """The scene in metres with +Y up, without a rest pose in its first frame, as the program changes it.

    Args:
        scene: A motion, or the path of one.
        unit: Its unit of length, by name or as metres in one; what the file says, else a guess, if ``None``.
        up: Its axis that points up; a guess if ``None``.
        bones: The names of joints for bones, where the guess is wrong; unit and axis are guessed from the bones.
    """
    return Scene(_mocap.prepare(native_of(scene), metres(unit), up, names_of(bones)))


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
    return step_of("warp", path=path_points(points), facing=facing)


@step_function
def trim(first: float = 0.0, last: float | None = None) -> Step:
    """Keeps the part from ``first`` to ``last``, in seconds."""
    return step_of("trim", range=f"{first}..{'' if last is None else last}")


@public
def contacts(
    scene: SceneLike,
    *,
    hands: bool = False,
    height: float | None = None,
    speed: float | None = None,
    release: float | None = None,
    shortest: float | None = None,
    gap: float | None = None,
    bones: Bones | None = None,
) -> Report:
    """When the feet are at rest, and the hands if asked: for each point ``at_rest``, frame by frame.

    The other options are those of :func:`foot_lock`.
    """
    options = dict(hands=hands, height=height, speed=speed, release=release, shortest=shortest, gap=gap)
    given = {key: value for key, value in options.items() if value is not None}
    found: Report = parsed(_mocap.contacts(native_of(scene), as_json(given), names_of(bones)))
    return found
