"""Options as plain data, which compare, print and pickle."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, Literal, TypeVar

from . import _mocap
from ._errors import UnknownOptionError

Unit = Literal["m", "dm", "cm", "mm", "inch", "cmu"]
Axis = Literal["y", "z", "-y", "-z"]


@dataclass(frozen=True)
class ReadOptions:
    """How to read a file.

    Attributes:
        format: ``"bvh"`` or another format's name; found from the contents if ``None``.
        root_offset: What to do with a root's OFFSET where the root has position channels too: ``"auto"`` adds where
            the first frame's root position is near zero while the OFFSET is not, else replaces.
        all_rows: Read rows beyond the declared number of frames too.
        retime: Frames per second in place of the file's own: the motion keeps its frames, and is slower or faster.
        strict: Take every warning for an error.
        hash: Compute the SHA-256 of the file, for the provenance; without, it is empty.
        clip: The animation to use of a file that has several: its name, or its number from 0.
        skeleton: The ``.asf`` of an ``.amc``; found beside it if ``None``.
        joints: What the points of an array or a C3D are, for rotations: ``"smpl22"``, ``"coco17"``, ... or a JSON file.
        lengths: Of bones that are solved from positions: ``"median"``, or ``"moving"``, those of each frame.
        markers: Solve a skeleton from markers: ``"auto"``, ``"auto:NAME"`` of one of several subjects, or a JSON
            file from labels to landmarks.
        static: A file of markers of somebody who stands, which may have more markers than the motion.
        body: The body on which arrays of rotations are put: a model of SMPL, SMPL-H or SMPL-X, or a file with a figure.
    """

    format: str | None = None
    root_offset: Literal["auto", "replace", "add"] = "auto"
    all_rows: bool = False
    retime: float | None = None
    strict: bool = False
    hash: bool = True
    clip: str | int | None = None
    skeleton: str | os.PathLike[str] | None = None
    joints: str | os.PathLike[str] | None = None
    lengths: Literal["median", "moving"] | None = None
    markers: str | os.PathLike[str] | None = None
    static: str | os.PathLike[str] | None = None
    body: str | os.PathLike[str] | None = None


@dataclass(frozen=True)
class WriteOptions:
    """How to write a file.

    Attributes:
        max_error: The largest distance of a joint from its position, in metres; keys and bits are removed within it.
            ``None`` keeps every key, but for ``.mclip``, which has 0.001.
        shell_distance: Points at this distance from each joint, in metres, keep ``max_error`` too, as a skin does.
        compress: How glTF stores keys: ``"none"``, ``"int16"``, ``"meshopt"`` or ``"meshopt-khr"``.
        overwrite: Replace a file that may be somebody's source; an input is never replaced.
        skeleton_only: Write the skeleton and its motion alone, without the meshes and all else of a file that has them.
    """

    max_error: float | None = None
    shell_distance: float | None = None
    compress: Literal["none", "int16", "meshopt", "meshopt-khr"] | None = None
    overwrite: bool = False
    skeleton_only: bool = False


@dataclass(frozen=True)
class Contacts:
    """What counts as a foot that stands on the ground: low and slow at once.

    A foot in contact leaves when it is 1.6 times too high or too fast, as for the steps of ``edit``. It rests where it is
    in most frames: at the height below which it is in a twentieth of them.

    Attributes:
        feet: A regular expression for the names of the feet; ``None`` for those of the humanoid.
        height: Metres above where it rests, at most.
        speed: Metres a second, at most.
    """

    feet: str | None = None
    height: float = 0.05
    speed: float = 0.25


@dataclass(frozen=True)
class Options:
    """Options of the arrays. By default nothing is converted.

    Attributes:
        rot: What the numbers of a rotation are: ``"quat"`` is x, y, z, w; ``"6d"`` the first two columns of the
            matrix, one after the other; ``"matrix"`` 3 x 3; ``"euler"`` degrees about x, y and z, which the joint's
            ``rotation_order`` puts in order.
        space: What positions are relative to: the ``"world"``; the position of the ``"root"`` in the same frame, along
            the world's axes; ``"local"`` is the listed parent, in its axes.
        rot_space: What rotations are relative to: the listed parent (``"local"``) or the ``"world"``.
        joints: A regular expression for the names of the joints and end sites to keep; all if ``None``.
        fps: Frames per second; the file's own frames if ``None``. In between, positions move on a line and rotations
            on the shorter arc.
        trim: The part to keep, from and to, in seconds, both included; either may be ``None``.
        unit: Unit of length of the file, by name or as metres in one; if ``None``, what the file says, else a guess
            where it is needed.
        up: The axis of the file that points up; if ``None``, what the file says, else a guess where it is needed.
        out_unit: Unit of length of the output; the file's own if ``None``.
        out_up: The axis of the output that points up; the file's own axes if ``None``.
        bones: Joints of the file for bones of the humanoid, by name, as ``{"head": "Neck"}``; ``None`` in place of a
            name for a bone that there is not. The unit and the up axis are guessed from the bones.
        velocities: Give velocities too, in units a second: central differences, one-sided at the first and the last
            frame.
        contacts: Say which feet stand on the ground; ``True`` stands for ``Contacts()``.
    """

    rot: Literal["quat", "6d", "matrix", "euler"] = "quat"
    space: Literal["world", "root", "local"] = "world"
    rot_space: Literal["local", "world"] = "local"
    joints: str | None = None
    fps: float | None = None
    trim: tuple[float | None, float | None] = (None, None)
    unit: Unit | float | None = None
    up: Axis | None = None
    out_unit: Unit | float | None = None
    out_up: Axis | None = None
    bones: Mapping[str, str | None] = field(default_factory=dict, hash=False)
    velocities: bool = False
    contacts: Contacts | bool = field(default=False)

    def to_json(self) -> str:
        """The options as the native half reads them."""
        contacts = Contacts() if self.contacts is True else self.contacts or None
        first, last = self.trim
        values: dict[str, Any] = {
            "rotation": self.rot,
            "space": self.space,
            "rotation_space": self.rot_space,
            "joints": self.joints,
            "frames_per_second": self.fps,
            "first": None if first is None else {"seconds": first},
            "last": None if last is None else {"seconds": last},
            "metres_per_unit": metres(self.unit),
            "up": self.up,
            "out_metres_per_unit": metres(self.out_unit),
            "out_up": self.out_up,
            "bones": dict(self.bones),
            "velocities": self.velocities,
            "contacts": contacts and vars(contacts),
        }
        return json.dumps(values)


Changed = TypeVar("Changed", ReadOptions, WriteOptions, Options)


def changed(options: Changed, changes: dict[str, Any], *also: str) -> Changed:
    """The options with other values for the fields named. ``also`` are options that the caller takes itself.

    Raises:
        TypeError: Where no field has a name, with the names that there are.
    """
    known: list[str] = [option.name for option in fields(options)]
    for name in changes:
        if name not in known:
            raise UnknownOptionError(f"there is no option {name!r}; the options are {', '.join([*also, *known])}")
    return replace(options, **changes)


def metres(unit: Unit | float | None) -> float | None:
    """Metres in one unit, which may be a name or that number already."""
    return _mocap.metres_in(unit) if isinstance(unit, str) else unit


def names_of(bones: Mapping[str, str | None] | None) -> str | None:
    """Names of joints for bones, as the native half reads them."""
    return None if bones is None else json.dumps(dict(bones))
