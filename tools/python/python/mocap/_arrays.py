"""Makes a scene of a motion in NumPy arrays."""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from . import _mocap
from ._call import public
from ._errors import OptionError
from ._job_options import ReadOptions
from ._scene import Scene


# The used arrays of a SAM 3D Body frame; the vertices are large and not used.
_OF_BODIES = ("pred_joint_coords", "pred_global_rots", "joint_global_rots", "pred_cam_t", "pred_keypoints_3d")

# The arrays of a frame: for one person, for each of several persons, or for no person.
_Frame = Mapping[str, object] | Sequence[Mapping[str, object]] | None


@public
def from_arrays(
    arrays: Mapping[str, object] | Sequence[_Frame] | None = None,
    *,
    positions: ArrayLike | None = None,
    rotations: ArrayLike | None = None,
    names: Sequence[str] | None = None,
    parents: Sequence[int] | None = None,
    frame_rate: float | None = None,
    person: int | None = None,
) -> Scene:
    """Makes a scene of a motion in NumPy arrays, in metres with +Y up.

    Args:
        arrays: Arrays in the layout of another program, by name, as `mocap.read` reads them from an ``.npz``. Or a list
            with the arrays of each frame, as SAM 3D Body returns them: one person, or a list of persons, which may be
            empty. Values that are not numbers are skipped. Use this argument instead of ``positions``.
        positions: The positions of the joints in the world, (frames, joints, 3).
        rotations: The rotations relative to the parents, as matrices (frames, joints, 3, 3) or as quaternions x, y, z,
            w (frames, joints, 4). Without rotations the joints are points. If the points have the names of SMPL's
            joints, or if there are 22 or 24 points without names, the rotations are solved.
        names: The names of the joints.
        parents: The index of each joint's parent, or -1. Parents precede their children. Required with rotations.
        frame_rate: Frames per second. Default: the rate in the arrays; 30 for positions.
        person: The index of one of several persons, from 0, in order of appearance. Default: the person with the most
            frames.

    >>> scene = mocap.from_arrays(positions=np.load("joints.npy"), frame_rate=20)  # doctest: +SKIP

    Raises:
        ValueError: If the shapes do not match.
        MocapError: If the numbers are not a motion.
    """
    if (arrays is None) == (positions is None):
        raise OptionError("give either arrays or positions")
    if arrays is not None:
        file = _saved(_stacked(arrays, frame_rate))
    else:
        file = _npz(positions, rotations, names, parents, 30.0 if frame_rate is None else frame_rate)
    options = ReadOptions() if person is None else ReadOptions(clip=f"person_{person}")
    return Scene(_mocap.read_bytes(file, "arrays.npz", options))


def _stacked(
    arrays: Mapping[str, object] | Sequence[_Frame], frame_rate: float | None
) -> dict[str, np.ndarray]:
    """Stacks the arrays: frames along the first axis, persons along the second."""
    if isinstance(arrays, Mapping):
        named = {name: np.asarray(array) for name, array in arrays.items() if _is_number(array)}
    else:
        frames = [_persons(frame) for frame in arrays]
        known = [person for frame in frames for person in frame]
        most = max(map(len, frames), default=0)
        common = set[str]().union(*known[:1]).intersection(*known)
        named = {}
        for name in sorted(common & set(_OF_BODIES) or common):
            if all(_is_number(person[name]) for person in known):
                named[name] = _rows(frames, name, most)
    if frame_rate is not None:
        named["fps"] = np.array(float(frame_rate))
    return named


def _rows(frames: Sequence[Sequence[Mapping[str, object]]], name: str, most: int) -> np.ndarray:
    """The arrays of this name for the frames, and for `most` persons if there are several."""
    shape = next(np.asarray(person[name]).shape for frame in frames for person in frame)
    rows = np.full((len(frames), most, *shape), np.nan)
    for index, frame in enumerate(frames):
        for place, person in enumerate(frame):
            rows[index, place] = np.asarray(person[name])
    return rows[:, 0] if most == 1 else rows


def _persons(frame: _Frame) -> Sequence[Mapping[str, object]]:
    if frame is None:
        return []
    return [frame] if isinstance(frame, Mapping) else frame


def _is_number(array: object) -> bool:
    return array is not None and np.asarray(array).dtype.kind in "biuf"


def _npz(
    positions: ArrayLike | None,
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
    return _saved(arrays)


def _saved(arrays: Mapping[str, np.ndarray]) -> bytes:
    out = io.BytesIO()
    # The stubs of this function mistake the names of arrays for its own options.
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
    """The median offsets of joints from their parents, in the axes of the parents."""
    world: list[np.ndarray] = []
    offsets = np.zeros((len(parents), 3))
    for joint, parent in enumerate(parents):
        if parent >= joint:
            raise OptionError(f"the parent of the joint {joint} must precede the joint, got {parent}")
        if parent < 0:
            world.append(matrices[:, joint])
            continue
        world.append(world[parent] @ matrices[:, joint])
        vectors = places[:, joint] - places[:, parent]
        if len(places):
            offsets[joint] = np.median(np.einsum("tji,tj->ti", world[parent], vectors), axis=0)
    return offsets
