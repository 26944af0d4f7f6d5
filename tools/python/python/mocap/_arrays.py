"""A motion of NumPy arrays as a scene."""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from . import _mocap
from ._call import public
from ._errors import OptionError
from ._job_options import ReadOptions
from ._scene import Scene


@public
def from_arrays(
    *,
    positions: ArrayLike,
    rotations: ArrayLike | None = None,
    names: Sequence[str] | None = None,
    parents: Sequence[int] | None = None,
    frame_rate: float = 30.0,
) -> Scene:
    """A scene of a motion in NumPy arrays, in metres with +Y up.

    Args:
        positions: Of the joints in the world, (frames, joints, 3).
        rotations: To the parent, as matrices (frames, joints, 3, 3) or as quaternions x, y, z, w (frames, joints, 4).
            Without them the joints are points, of which those named as SMPL's, or 22 or 24 without names, are solved.
        names: Of the joints.
        parents: Of each joint the index of the one above it, which stands before it, or -1. Needed with rotations.
        frame_rate: Frames per second.

    >>> scene = mocap.from_arrays(positions=np.load("joints.npy"), frame_rate=20)  # doctest: +SKIP

    Raises:
        ValueError: Where the shapes do not go together.
        MocapError: Where the numbers are no motion.
    """
    return Scene(_mocap.read_bytes(_npz(positions, rotations, names, parents, frame_rate), "arrays.npz", ReadOptions()))


def _npz(
    positions: ArrayLike,
    rotations: ArrayLike | None,
    names: Sequence[str] | None,
    parents: Sequence[int] | None,
    frame_rate: float,
) -> bytes:
    places = np.asarray(positions, np.float64)
    if places.ndim != 3 or places.shape[2] != 3:
        raise OptionError(f"positions must be (frames, joints, 3), got {places.shape}")
    frames, count = places.shape[:2]
    arrays: dict[str, np.ndarray] = {"positions": places, "frame_rate": np.array(float(frame_rate))}
    if names is not None:
        if len(names) != count:
            raise OptionError(f"names must be {count}, one for each joint, got {len(names)}")
        arrays["names"] = np.array(names, dtype=np.str_)
    if rotations is not None:
        turned = np.asarray(rotations, np.float64)
        if turned.shape not in ((frames, count, 4), (frames, count, 3, 3)):
            raise OptionError(f"rotations must be {(frames, count, 4)} or {(frames, count, 3, 3)}, got {turned.shape}")
        if parents is None or len(parents) != count:
            raise OptionError(f"parents must be {count}, one for each joint, with rotations")
        matrices = turned if turned.ndim == 4 else _matrices(turned)
        offsets = _offsets(places, matrices, parents)
        joints = [
            {
                "name": names[joint] if names is not None else f"joint_{joint}",
                "parent": int(parent) if parent >= 0 else None,
                "offset": offsets[joint].tolist(),
                "end_site": False,
                "rotation_order": None,
            }
            for joint, parent in enumerate(parents)
        ]
        header = {
            "frame_rate": float(frame_rate),
            "metres_per_unit": 1.0,
            "up": "y",
            "space": "world",
            "rotation": "matrix",
            "rotation_space": "local",
            "joints": joints,
        }
        arrays["rotations"] = matrices
        arrays["parents"] = np.array(parents, np.int32)
        arrays["offsets"] = offsets
        arrays["header"] = np.array(json.dumps(header))
    out = io.BytesIO()
    # Its stubs take the names of arrays for its own options.
    save: Callable[..., None] = np.savez
    save(out, **arrays)
    return out.getvalue()


def _matrices(quaternions: np.ndarray) -> np.ndarray:
    x, y, z, w = np.moveaxis(quaternions / np.linalg.norm(quaternions, axis=-1, keepdims=True), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, -1) for row in rows], -2)


def _offsets(places: np.ndarray, matrices: np.ndarray, parents: Sequence[int]) -> np.ndarray:
    """The medians of the vectors from the joints above, in the axes of those."""
    world: list[np.ndarray] = []
    offsets = np.zeros((len(parents), 3))
    for joint, parent in enumerate(parents):
        if parent >= joint:
            raise OptionError(f"the parent of the joint {joint} must stand before it, got {parent}")
        if parent < 0:
            world.append(matrices[:, joint])
            continue
        world.append(world[parent] @ matrices[:, joint])
        vectors = places[:, joint] - places[:, parent]
        if len(places):
            offsets[joint] = np.median(np.einsum("tji,tj->ti", world[parent], vectors), axis=0)
    return offsets
