"""Reads motion capture files (BVH and others) as NumPy and Arrow arrays, and writes glTF and other formats.

>>> import mocap
>>> motion = mocap.read("walk.bvh").to_numpy(rot="6d", fps=30, out_unit="m")  # doctest: +SKIP
>>> motion.positions.shape  # frames, joints, xyz                          # doctest: +SKIP
(131, 38, 3)

Matrices multiply column vectors, quaternions are x, y, z, w, and coordinates are right-handed. Reading and kinematics
release the GIL, so threads run in parallel.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from importlib.metadata import version
from typing import Any, Literal

from . import _mocap, edit, ik, torch
from ._array_options import Contacts, Options
from ._arrays import from_arrays
from ._call import public
from ._clash import warn_of_other
from ._dataset import write_dataset
from ._errors import (
    FileError,
    FileIsFolderError,
    FilePermissionError,
    LimitError,
    MissingFileError,
    MocapError,
    OptionError,
    UnknownOptionError,
    WrongTypeError,
)
from ._files import convert, read, read_bytes
from ._graph import Graph, graph
from ._job_options import ReadOptions, WriteOptions
from ._mocap import ArrowTable, Node
from ._packed import PackedClip
from ._picture import Picture
from ._report import Columns, Report, Reports, parsed
from ._retarget import Retargeted, add_motions, retarget
from ._robot import Robot, RobotMotion, RobotStream
from ._scene import Motion, Scene
from ._search import Database, index
from ._survey import Survey, examine, survey

__version__ = version("mocap-kit")

warn_of_other()

__all__ = [
    "ArrowTable",
    "Columns",
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
    "Report",
    "Reports",
    "Retargeted",
    "Robot",
    "RobotMotion",
    "RobotStream",
    "Scene",
    "Survey",
    "UnknownOptionError",
    "WriteOptions",
    "WrongTypeError",
    "__version__",
    "add_motions",
    "convert",
    "edit",
    "examine",
    "extensions",
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
    "torch",
    "write_dataset",
]


@public
def extensions() -> list[str]:
    """The extensions of the files that :func:`read` knows, without dots. ``bip`` is among them: :func:`read` rejects
    such files with advice."""
    return _mocap.extensions()


@public
def run(job: Mapping[str, Any]) -> Report:
    """Runs a job, as ``mocap run`` does: reads files, edits motions, retargets them, and writes files.

    >>> run({"source": {"inputs": ["walk.bvh"]}, "steps": ["mirror"], "write": {"output": "walk.glb"}})  # doctest: +SKIP

    Args:
        job: The job; ``mocap run --schema`` prints its schema, and ``mocap convert ... --print-job`` prints the job of
            a command line. ``steps`` may contain :class:`mocap.edit.Step`, and paths may be :class:`pathlib.Path`.

    Returns:
        The report: ``files`` with their sizes, ``notes``, ``warnings``, the reports of ``steps`` and ``clips``, and
        ``problem`` if the output is worse than the job allows.

    Raises:
        MocapError: If a file cannot be read or written, or a step fails.
        ValueError: If the job has an unknown key or an invalid value; the message names its place.
    """
    report: Report = parsed(_mocap.run(json.dumps(job, default=_plain)))
    return report


def _plain(value: Any) -> object:
    """Converts steps and paths in a job to plain JSON values."""
    if isinstance(value, edit.Step):
        if value.other is not None or value.bones is not None:
            place = "put its second motion into source.with, and its bones into source.map"
            raise OptionError(f"the step {value.name} holds data, but a job names files: {place}")
        return value.to_dict()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    raise OptionError(f"a job cannot hold a {type(value).__name__}: {value!r}")


@public
def table(
    files: Iterable[tuple[str, bytes]],
    shape: Literal["clips", "inventory"] = "clips",
    options: Options = Options(),
    read_options: ReadOptions = ReadOptions(),
) -> ArrowTable:
    """A table with a row for each file in memory. A file that cannot be read is a row with an ``error``.

    Map this function over the batches of Ray Data, Spark or Dask: options and results can be sent between processes.

    Args:
        files: Names and bytes.
        shape: ``"clips"`` for the arrays, as lists in one row; ``"inventory"`` for a summary of each file without its
            motion: skeleton hash, joints, frames, frame rate, duration, unit, axis, warnings.
        options: The contents of the arrays.
        read_options: How to read.
    """
    return _mocap.table(list(files), shape, options.to_json(), read_options)
