"""Motion graphs: transitions between similar frames of clips, and walks over them."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _mocap
from ._call import public
from ._job_options import ReadOptions
from ._options import Axis, StrPath, Unit, metres
from ._report import Report, Reports, parsed
from ._scene import Scene


class Graph:
    """A motion graph with its clips. ``docs/motion-graphs.md`` has the words and formulas.

    >>> graph = mocap.graph(["walk.bvh", "turn.bvh"])                                # doctest: +SKIP
    >>> scene, report = graph.walk(60)                                               # doctest: +SKIP
    >>> mocap.edit.write(scene, "long.glb")                                          # doctest: +SKIP
    """

    def __init__(self, native: _mocap.Graph) -> None:
        self._native = native
        about = parsed(native.about_json())
        self.options: Report = about["options"]
        """How the moments were compared: ``rate``, ``window``, ``threshold``, ``whole``."""
        self.clips = Reports(about["clips"])
        """Of each clip its ``file``, ``sha256``, ``animation``, ``frames``, and the ``part`` of it from which a walk reaches
        all others: the first and the last frame, or ``None``."""

    @classmethod
    def read(
        cls,
        path: str | os.PathLike[str],
        *,
        unit: Unit | float | None = None,
        up: Axis | None = None,
        read_options: ReadOptions = ReadOptions(),
    ) -> Graph:
        """Reads a graph that ``mocap graph`` or :meth:`write` wrote, and the clips that it names.

        Args:
            path: The ``.json`` file.
            unit, up: As for :func:`graph`.
            read_options: How to read the clips.

        Raises:
            MocapError: If the file is not a graph, or a clip has changed since.
        """
        return cls(_mocap.read_graph(path, _space(unit, up), read_options))

    def __repr__(self) -> str:
        return f"<mocap.Graph of {len(self.clips)} clips>"

    def _repr_html_(self) -> str:
        return self.clips._repr_html_()

    @property
    def transitions(self) -> npt.NDArray[np.int64]:
        """The transitions. Each row has the source clip and frame, then the target clip and frame."""
        return self._native.transitions().reshape(-1, 4)

    @property
    def distances(self) -> npt.NDArray[np.float32]:
        """The distance of each transition, in metres."""
        return self._native.distances()

    @public
    def matrix(self, first: int = 0, second: int = 0) -> npt.NDArray[np.float32]:
        """The distance matrix of two clips in metres: rows are frames of the first clip, columns of the second.

        Raises:
            MocapError: If there is no such clip, or the clip is shorter than the window.
        """
        rows, columns, values = self._native.matrix(first, second)
        return values.reshape(rows, columns)

    @public
    def walk(
        self,
        seconds: float | None = None,
        *,
        path: Sequence[tuple[float, float]] | None = None,
        through: Sequence[str] | None = None,
        seed: int = 1,
    ) -> tuple[Scene, Report]:
        """Makes a walk over the graph, with feet locked during contact. Returns the motion and a report: ``frames``,
        ``seconds``, the begins of ``transitions``, ``largest_distance``, ``feet``, and ``path``, the deviation from the
        path in metres and degrees. Set one of ``seconds``, ``path`` and ``through``.

        Args:
            seconds: Walk for this number of seconds, towards frames that the walk has rarely visited.
            path: Walk along these points over the ground in metres: x and z where +Y is up, x and y where +Z is.
            through: Walk through these clips in this order; ``"turn@1.5"`` is a time of a clip.
            seed: Another number gives another walk of ``seconds``.

        Raises:
            MocapError: If there is no such walk, or a file has changed since.
        """
        points = None if path is None else [[float(x), float(z)] for x, z in path]
        walking = {"seconds": seconds, "path": points, "through": list(through or []), "seed": seed}
        scene, report = self._native.walk(json.dumps(walking))
        return Scene(scene), parsed(report)

    @public
    def write(self, path: StrPath, *, overwrite: bool = False) -> None:
        """Writes the graph as JSON, for ``mocap graph walk``.

        Raises:
            MocapError: If the output would replace a clip or a file that may be a source.
        """
        self._native.write(path, overwrite)


@public
def graph(
    paths: StrPath | Iterable[StrPath],
    *,
    rate: float = 30.0,
    window: float = 1 / 3,
    threshold: float = 0.06,
    whole: bool = False,
    on: StrPath | None = None,
    unit: Unit | float | None = None,
    up: Axis | None = None,
    read_options: ReadOptions = ReadOptions(),
) -> Graph:
    """Compares all frames of motions, and finds transitions between similar frames, as ``mocap graph`` does.

    Args:
        paths: The files, all of one skeleton, or of humanoids with ``on``.
        rate: Frames per second at which clips are compared.
        window: The length of the compared window, and of a transition, in seconds.
        threshold: The largest distance of a transition, in metres.
        whole: Also keep transitions outside the largest strongly connected component.
        on: The file of a body to which all clips are retargeted first.
        unit: Unit of length of the clips, as a name or in metres. ``None`` takes the unit that the files state, or else
            infers it.
        up: The up axis of the clips; ``None`` infers it.
        read_options: How to read.

    Raises:
        MocapError: If a file cannot be read, skeletons differ, or no frames are similar enough.
    """
    files = [paths] if isinstance(paths, (str, os.PathLike)) else list(paths)
    graphing: dict[str, Any] = {"rate": rate, "window": window, "threshold": threshold, "whole": whole}
    if on is not None:
        graphing["on"] = os.fspath(on)
    return Graph(_mocap.graph(files, json.dumps(graphing), _space(unit, up), read_options))


def _space(unit: Unit | float | None, up: Axis | None) -> str:
    """The unit and up axis of files, in the form of the native module."""
    known = {"unit": metres(unit), "up": up}
    return json.dumps({name: value for name, value in known.items() if value is not None})
