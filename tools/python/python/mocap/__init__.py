"""Motion capture as arrays: BVH and others into NumPy, Arrow and glTF.

>>> import mocap
>>> motion = mocap.read("walk.bvh").to_numpy(rot="6d", fps=30, out_unit="m")  # doctest: +SKIP
>>> motion.positions.shape  # frames, joints, xyz                          # doctest: +SKIP
(131, 38, 3)

Matrices map column vectors, quaternions are x, y, z, w, coordinates are right-handed. Reading and kinematics run with
the interpreter let go, so threads work side by side.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import fields
from typing import Any, Literal

from . import _mocap, edit, ik
from ._arrays import from_arrays
from ._errors import (
    FileError,
    FileIsFolderError,
    FilePermissionError,
    LimitError,
    MissingFileError,
    MocapError,
    OptionError,
    UnknownOptionError,
)
from ._graph import Graph, graph
from ._mocap import ArrowTable, Node
from ._options import Axis, Contacts, Options, ReadOptions, Unit, WriteOptions, changed, metres, names_of
from ._packed import PackedClip
from ._picture import Picture
from ._retarget import Retargeted, add_motions, retarget
from ._robot import Robot, RobotMotion, RobotStream
from ._scene import Motion, Scene
from ._search import Database, index
from ._survey import Survey, examine, survey

__all__ = [
    "ArrowTable",
    "Contacts",
    "Database",
    "FileError",
    "FileIsFolderError",
    "FilePermissionError",
    "Graph",
    "LimitError",
    "MissingFileError",
    "MocapError",
    "Motion",
    "Node",
    "OptionError",
    "Options",
    "PackedClip",
    "Picture",
    "ReadOptions",
    "Retargeted",
    "Robot",
    "RobotMotion",
    "RobotStream",
    "Scene",
    "Survey",
    "UnknownOptionError",
    "WriteOptions",
    "add_motions",
    "convert",
    "edit",
    "examine",
    "from_arrays",
    "graph",
    "ik",
    "index",
    "read",
    "read_bytes",
    "retarget",
    "run",
    "survey",
    "table",
]


def read(path: str | os.PathLike[str], **options: Any) -> Scene:
    """Reads a motion file. ``options`` are the fields of :class:`ReadOptions`, by name:

    ``format``, ``root_offset``, ``all_rows``, ``retime``, ``strict``, ``hash``, ``clip``, ``skeleton``, ``joints``, ``lengths``,
    ``markers``, ``static``, ``body``; see ``help(mocap.ReadOptions)``.

    >>> scene = mocap.read("walk.bvh", root_offset="add", strict=True)  # doctest: +SKIP

    Raises:
        MocapError: Where the file is of no known format, or breaks the rules of its own.
        FileNotFoundError, IsADirectoryError, PermissionError, OSError: Where it cannot be opened.
        MemoryError: Where it would need more memory than the limits allow.
        TypeError: Where there is no such option.
    """
    return Scene(_mocap.read(path, changed(ReadOptions(), options)))


def read_bytes(data: bytes, name: str, **options: Any) -> Scene:
    """Reads the bytes of a motion file. ``name`` stands for the file in errors, its extension helps to tell the format.

    Raises:
        MocapError: As :func:`read`.
    """
    return Scene(_mocap.read_bytes(data, name, changed(ReadOptions(), options)))


def convert(
    source: str | os.PathLike[str],
    target: str | os.PathLike[str],
    *,
    unit: Unit | float | None = None,
    up: Axis | None = None,
    fps: float | None = None,
    rest: str = "zero",
    t_pose_first: bool = False,
    names: str | os.PathLike[str] | Mapping[str, str | None] | None = None,
    max_error: float | None = None,
    shell_distance: float | None = None,
    compress: Literal["none", "int16", "meshopt", "meshopt-khr"] | None = None,
    overwrite: bool = False,
    skeleton_only: bool = False,
    bones: Mapping[str, str | None] | None = None,
    **options: Any,
) -> int:
    """Writes a motion file in the format of the target's extension, as ``mocap formats`` lists them; returns the bytes
    written. glTF, VRM animations and packed clips are in metres with +Y up, FBX says what it is in, and BVH keeps the
    unit and the axes of its source.

    Args:
        source: The motion file.
        target: The file to write; it is whole or absent. A file that may be somebody's source is not replaced.
        unit: Unit of length of the source, by name or as metres in one; what it says, else a guess, if ``None``.
        up: The axis of the source that points up; a guess if ``None``.
        fps: Frames per second to write; the source's own frames if ``None``.
        rest: The rest pose: ``"zero"`` as in the file, ``"t-pose"``, ``"a-pose"`` with the arms 45 degrees down, or
            ``"frame:N"``, the pose of a frame. The motion stays.
        t_pose_first: Put the T-pose before the first frame, on the floor.
        names: What joints are called in the target: ``"vrm"``, ``"mixamo"``, ``"unreal"``, ``"cmu"``, a JSON file, or the
            name of each bone, as ``{"hips": "Pelvis"}``; ``None`` keeps the source's names.
        bones: The names of joints for bones, where the guess is wrong: ``{"leftFoot": "ankle_L"}``; ``None`` for a bone that
            there is not.
        max_error, shell_distance, compress, overwrite, skeleton_only: The fields of :class:`WriteOptions`.
        options: The fields of :class:`ReadOptions`.

    Raises:
        MocapError: Where the source cannot be read or the target cannot be written.
        ValueError: Where the extension is that of no written format, or an option has no effect on it.
    """
    write = WriteOptions(max_error, shell_distance, compress, overwrite, skeleton_only)
    own = ("unit", "up", "fps", "rest", "t_pose_first", "names", "bones", *(field.name for field in fields(WriteOptions)))
    read = changed(ReadOptions(), options, *own)
    given = None if names is None else json.dumps(dict(names) if isinstance(names, Mapping) else os.fspath(names))
    return _mocap.convert(source, target, metres(unit), up, fps, rest, t_pose_first, given, names_of(bones), read, write)


def run(job: Mapping[str, Any]) -> dict[str, Any]:
    """Does a job, as ``mocap run`` does a job file: reads files, changes motions, puts them on another body, writes files.

    >>> run({"source": {"inputs": ["walk.bvh"]}, "steps": ["mirror"], "write": {"output": "walk.glb"}})  # doctest: +SKIP

    Args:
        job: What ``mocap run --schema`` describes. ``mocap convert ... --print-job`` prints the job of a command line.
            ``steps`` may hold every :class:`mocap.edit.Step`; paths may be :class:`pathlib.Path`.

    Returns:
        What was done: ``files`` with their sizes, ``notes``, ``warnings``, the reports of ``steps`` and ``clips``, and
        ``problem`` where the output is worse than the job allows.

    Raises:
        MocapError: Where a file cannot be read or written, or a step cannot be done.
        ValueError: Where the job holds what no job has; the message says where.
    """
    report: dict[str, Any] = json.loads(_mocap.run(json.dumps(job, default=_plain)))
    return report


def _plain(value: Any) -> object:
    """Steps and paths in a job."""
    if isinstance(value, edit.Step):
        if value.other is not None or value.bones is not None:
            raise OptionError(f"a job names files: put what {value.name} needs into source.with and source.bones")
        return value.to_dict()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise OptionError(f"a job cannot hold a {type(value).__name__}: {value!r}")


def table(
    files: Iterable[tuple[str, bytes]],
    shape: Literal["clips", "inventory"] = "clips",
    options: Options = Options(),
    read_options: ReadOptions = ReadOptions(),
) -> ArrowTable:
    """A table with a row for each file, names and bytes given. A file that cannot be read is a row with an ``error``.

    This is what to map over the batches of Ray Data, Spark or Dask: options and results travel between processes.

    Args:
        files: Names and bytes.
        shape: ``"clips"`` for the arrays, as lists in one row; ``"inventory"`` for what a file holds, without its
            motion: skeleton hash, joints, frames, frame rate, duration, unit, axis, warnings.
        options: What to put into the arrays.
        read_options: How to read.
    """
    return _mocap.table(list(files), shape, options.to_json(), read_options)
