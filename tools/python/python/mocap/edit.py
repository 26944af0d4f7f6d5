"""The steps of ``mocap edit``. Each function edits a motion, and reports what changed and by how much.

>>> import mocap, mocap.edit
>>> walk = mocap.edit.prepare(mocap.read("walk.bvh"))       # doctest: +SKIP
>>> walk, report = mocap.edit.smooth(walk, cut_off=8)       # doctest: +SKIP
>>> report["largest_rotation"]                              # degrees    # doctest: +SKIP
4.25

Each function can also make a :class:`Step`, which can be stored, compared, pickled, and used in the ``steps`` of a job:

>>> gentle = [mocap.edit.smooth.step(cut_off=8), mocap.edit.foot_lock.step()]      # doctest: +SKIP
>>> walk, reports = mocap.edit.apply_all(walk, gentle)                             # doctest: +SKIP

A scene never changes: each function returns a new scene. Lengths in options and reports are in metres for any unit of
the scene, times in seconds, angles in degrees. Absent options have the defaults of the program; ``docs/editing.md``
describes each step. ``scene.metadata["steps"]`` and the glTF file of :func:`write` record the steps.

Every function raises :class:`mocap.MocapError` if an option is not valid, or if the step needs a humanoid and the
skeleton is not a humanoid.
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
    """Converts a scene to metres with +Y up and drops a rest pose in its first frame, as the program does.

    Args:
        scene: A motion, or the path of one.
        unit: The unit of length, as a name or in metres. ``None`` takes the unit that the file states, or else infers
            it.
        up: The up axis; ``None`` infers it.
        bones: The joints of bones, to correct mocap's choice. Unit and axis are inferred from the bones.
    """
    return Scene(_mocap.prepare(native_of(scene), metres(unit), up, names_of(bones)))


@step_function
def warp_time(
    moments: Sequence[tuple[float, float]] | None = None, *, speed: float | None = None
) -> Step:
    """Moves times: ``moments`` are pairs of a time and its new time. Or changes the ``speed`` of the whole motion."""
    if (moments is None) == (speed is None):
        raise UnknownOptionError("give either moments or a speed")
    return step_of("warp", moments=moments, speed=speed)


@step_function
def warp_path(
    points: Sequence[tuple[float, float] | tuple[float, float, float]],
    facing: Literal["along", "kept"] = "along",
) -> Step:
    """Bends the path over the ground to ``points``: two coordinates in metres, optionally after a time in seconds."""
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
    """Finds the contacts of the feet, and optionally of the hands: ``at_rest`` for each point and frame.

    The other options are as for :func:`foot_lock`.
    """
    options = dict(hands=hands, height=height, speed=speed, release=release, shortest=shortest, gap=gap)
    given = {key: value for key, value in options.items() if value is not None}
    found: Report = parsed(_mocap.contacts(native_of(scene), as_json(given), names_of(bones)))
    return found
