"""Inverse kinematics: limbs and chains that reach for a goal, in one pose.

>>> from mocap import ik
>>> ik.two_bone([[0, 1, 0], [0, 0.5, 0.1], [0, 0, 0]], goal=[0.2, 0.3, 0]).distance  # doctest: +SKIP
0.0

:func:`mocap.edit.reach` and :func:`mocap.edit.pin` do it over a part of a motion.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _mocap
from ._call import public
from ._errors import OptionError
from ._points import numbers, single
from ._scene import SceneLike, is_world, native_of

__all__ = ["Bent", "Chain", "TwoBone", "bend", "chain", "two_bone"]


class TwoBone(NamedTuple):
    """What two bones come to.

    Attributes:
        middle: The joint between them.
        end: The end.
        upper: How the first bone turns in the world: x, y, z, w.
        lower: How the second turns in the world; it contains ``upper``.
        distance: What is left to the goal: 0 within reach, but for rounding.
    """

    middle: NDArray[np.float32]
    end: NDArray[np.float32]
    upper: NDArray[np.float32]
    lower: NDArray[np.float32]
    distance: float


class Chain(NamedTuple):
    """The positions that a chain comes to, (joints, 3), and what is left to the goal."""

    positions: NDArray[np.float32]
    distance: float


class Bent(NamedTuple):
    """The matrices of a pose, (nodes, 4, 4), and what is left to the goal."""

    matrices: NDArray[np.float32]
    distance: float


@public
def two_bone(joints: ArrayLike, goal: ArrayLike, *, pole: ArrayLike | None = None) -> TwoBone:
    """Two bones that reach for a goal, as an arm or a leg does. Out of reach they are straight towards it.

    Args:
        joints: The positions of the first joint, of the one between the bones, and of the end, (3, 3).
        goal: Where the end is to come.
        pole: A position towards which the middle bends; as it bends now if ``None``.
    """
    solved = _mocap.two_bone(
        _points(joints, "joints", 3), _point(goal, "goal"), None if pole is None else _point(pole, "pole")
    )
    middle, end, upper, lower, distance = solved
    as_array = functools.partial(np.array, dtype=np.float32)
    return TwoBone(as_array(middle), as_array(end), as_array(upper), as_array(lower), distance)


@public
def chain(positions: ArrayLike, goal: ArrayLike, *, tolerance: float = 1e-4) -> Chain:
    """A chain of any number of bones that reaches for a goal; the first joint and the lengths stay (FABRIK).

    Args:
        positions: From the first joint to the end, (joints, 3).
        goal: Where the end is to come.
        tolerance: How near is near enough.
    """
    moved, distance = _mocap.chain(_points(positions, "positions"), _point(goal, "goal"), tolerance)
    return Chain(np.array(moved, np.float32), distance)


@public
def bend(
    scene: SceneLike,
    tick: float,
    joints: Sequence[str | int],
    goal: ArrayLike,
    *,
    rotation: ArrayLike | None = None,
    pole: ArrayLike | None = None,
    space: Literal["world", "local"] = "world",
) -> Bent:
    """The pose of a scene at a tick, with joints turned so that the last of them comes to a goal.

    >>> arm = ["LeftArm", "LeftForeArm", "LeftHand"]               # doctest: +SKIP
    >>> ik.bend(scene, 30, arm, goal=[0.3, 1.2, 0.4]).distance      # doctest: +SKIP
    0.0

    Args:
        scene: A scene, or the path of a file.
        tick: The moment, as for :meth:`Scene.pose`.
        joints: Names or indices, each above the next. Three bend as a limb, any other number as a chain.
        goal: Where the last is to come, in the world, in the unit of the scene.
        rotation: The rotation that the last is to have in the world: x, y, z, w.
        pole: Of three joints: a position towards which the middle bends.
        space: What the matrices are relative to, as for :meth:`Scene.pose`.

    Raises:
        OptionError: Where there is no such joint, or one is not above the next.
    """
    native = native_of(scene)
    names = [node.name for node in native.nodes]

    def index(joint: str | int) -> int:
        if isinstance(joint, str):
            if joint not in names:
                raise OptionError(f"no joint is called {joint!r}; the joints are {', '.join(names)}")
            return names.index(joint)
        if not 0 <= joint < len(names):
            raise OptionError(f"there is no node {joint}: there are {len(names)}, counted from 0")
        return joint

    turned = None if rotation is None else numbers(rotation, "rotation", 4)
    return Bent(
        *_mocap.bend(
            native,
            tick,
            [index(joint) for joint in joints],
            _point(goal, "goal"),
            turned,
            None if pole is None else _point(pole, "pole"),
            is_world(space),
        )
    )


def _point(value: ArrayLike, name: str) -> list[float]:
    return numbers(value, name, 3)


def _points(value: ArrayLike, name: str, count: int | None = None) -> list[list[float]]:
    array = single(value)
    wanted = "joints" if count is None else str(count)
    if array.ndim != 2 or array.shape[1] != 3 or (count is not None and len(array) != count):
        raise OptionError(f"{name} must be ({wanted}, 3), got {array.shape}")
    if not np.isfinite(array).all():
        raise OptionError(f"{name} must be finite")
    points: list[list[float]] = array.tolist()
    return points
