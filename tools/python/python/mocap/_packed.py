"""Packed clips, ``.mclip``, from which single poses are decoded."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from . import _mocap
from ._call import public
from ._errors import of_file
from ._job_options import ReadOptions
from ._options import StrPath
from ._scene import Scene, SceneLike, is_world, native_of


class PackedClip:
    """A compressed motion, from which the pose at any tick can be decoded. Games and training programs keep many of
    them in memory.

    >>> clip = mocap.PackedClip.of(mocap.edit.prepare(mocap.read("walk.bvh")), max_error=0.001)  # doctest: +SKIP
    >>> len(clip.data), clip.pose(12.5).shape                                                    # doctest: +SKIP
    (61824, (38, 4, 4))

    ``docs/packed-clip.md`` describes the bytes. ``mocap.read("walk.mclip")`` makes a :class:`Scene` of them.
    """

    def __init__(self, data: bytes) -> None:
        """Opens the bytes of a ``.mclip``.

        Raises:
            MocapError: If the bytes are not a complete and valid packed clip.
        """
        self._native = _mocap.PackedClip(data)

    @classmethod
    @public
    def of(cls, scene: SceneLike, *, max_error: float = 0.001) -> PackedClip:
        """Packs the motion of a scene.

        Args:
            scene: A motion, a scene or the path of a file. :func:`mocap.edit.prepare` brings it to metres, as ``mocap convert`` does.
            max_error: The largest distance of a joint from its position, in units of the scene.

        Raises:
            MocapError: If there is no motion, or ``max_error`` is invalid.
        """
        return cls(_mocap.pack(native_of(scene), max_error).data())

    @classmethod
    def open(cls, path: str | os.PathLike[str]) -> PackedClip:
        """Opens a ``.mclip`` file.

        Raises:
            OSError: If the file cannot be opened.
            MocapError: If the file is not a complete and valid packed clip.
        """
        try:
            data = Path(path).read_bytes()
        except OSError as failure:
            raise of_file(failure, path) from None
        return cls(data)

    def __repr__(self) -> str:
        return f"<mocap.PackedClip of {len(self.names)} nodes and {self.frames} frames in {len(self.data)} bytes>"

    def __reduce__(self) -> tuple[Any, tuple[bytes]]:
        return PackedClip, (self.data,)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, PackedClip) and self.data == other.data

    def __hash__(self) -> int:
        return hash(self.data)

    def to_scene(self) -> Scene:
        """The motion as a scene, as ``mocap.read("walk.mclip")`` makes it."""
        return Scene(_mocap.read_bytes(self.data, "clip.mclip", ReadOptions()))

    @property
    def data(self) -> bytes:
        """The bytes of the ``.mclip`` file."""
        return self._native.data()

    @property
    def names(self) -> list[str]:
        """The names of the nodes, parents before their children."""
        return self._native.names

    @property
    def parents(self) -> list[int]:
        """The index of each node's parent, or -1."""
        return self._native.parents

    @property
    def frames(self) -> int:
        """The number of frames."""
        return self._native.frames

    @property
    def duration(self) -> float:
        """The last tick."""
        return self._native.duration

    @property
    def ticks_per_second(self) -> float:
        """Ticks per second."""
        return self._native.ticks_per_second

    @property
    def max_error(self) -> float:
        """The largest distance of a joint from its original position in any frame."""
        return self._native.max_error

    def pose(self, tick: float, *, space: Literal["world", "local"] = "world") -> NDArray[np.float32]:
        """The matrices of all nodes at a tick, in the form of :meth:`Scene.pose`."""
        return self._native.pose_matrices(tick, is_world(space))
