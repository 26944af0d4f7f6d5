"""Inverse kinematics: moves the ends of limbs and chains to a goal, in one pose.

>>> from mocap import ik
>>> ik.two_bone([[0, 1, 0], [0, 0.5, 0.1], [0, 0, 0]], goal=[0.2, 0.3, 0]).distance  # doctest: +SKIP
0.0

:func:`mocap.edit.reach` and :func:`mocap.edit.pin` apply inverse kinematics over a part of a motion.
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
    """The result for two bones.

    Attributes:
        middle: The position of the joint between the bones.
        end: The position of the end.
        upper: The rotation of the first bone in the world: x, y, z, w.
        lower: The rotation of the second bone in the world; it includes ``upper``.
        distance: The remaining distance to the goal: 0 within reach, except for rounding.
    """

    middle: NDArray[np.float32]
    end: NDArray[np.float32]
    upper: NDArray[np.float32]
    lower: NDArray[np.float32]
    distance: float


class Chain(NamedTuple):
    """The positions of a chain, (joints, 3), and the remaining distance to the goal."""

    positions: NDArray[np.float32]
    distance: float


class Bent(NamedTuple):
    """The matrices of a pose, (nodes, 4, 4), and the remaining distance to the goal."""

    matrices: NDArray[np.float32]
    distance: float


@public
def two_bone(joints: ArrayLike, goal: ArrayLike, *, pole: ArrayLike | None = None) -> TwoBone:
    """Moves the end of two bones, such as an arm or a leg, to a goal. If the goal is out of reach, the bones are
    straight towards the goal.

    Args:
        joints: The positions of the first joint, the middle joint and the end, (3, 3).
        goal: The goal of the end.
        pole: A position towards which the middle joint bends; ``None`` keeps the current direction.
    """
    solved = _mocap.two_bone(
        _points(joints, "joints", 3), _point(goal, "goal"), None if pole is None else _point(pole, "pole")
    )
    middle, end, upper, lower, distance = solved
    as_array = functools.partial(np.array, dtype=np.float32)
    return TwoBone(as_array(middle), as_array(end), as_array(upper), as_array(lower), distance)


@public
def chain(positions: ArrayLike, goal: ArrayLike, *, tolerance: float = 1e-4) -> Chain:
    """Moves the end of a chain with any number of bones to a goal by FABRIK. The first joint and the bone lengths stay
    constant.

    Args:
        positions: From the first joint to the end, (joints, 3).
        goal: The goal of the end.
        tolerance: The largest accepted distance from the goal.
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
    """The pose of a scene at a tick, with joints turned so that the last joint reaches a goal.

    >>> arm = ["LeftArm", "LeftForeArm", "LeftHand"]               # doctest: +SKIP
    >>> ik.bend(scene, 30, arm, goal=[0.3, 1.2, 0.4]).distance      # doctest: +SKIP
    0.0

    Args:
        scene: A scene, or the path of a file.
        tick: The time, as for :meth:`Scene.pose`.
        joints: Names or indices. Each joint is an ancestor of the next. Three joints bend as a limb, any other number
            as a chain.
        goal: The goal of the last joint, in the world, in the unit of the scene.
        rotation: The wanted rotation of the last joint in the world: x, y, z, w.
        pole: For three joints: a position towards which the middle joint bends.
        space: What the matrices are relative to, as for :meth:`Scene.pose`.

    Raises:
        OptionError: If there is no such joint, or a joint is not an ancestor of the next.
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
