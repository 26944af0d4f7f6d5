"""Databases of motions, and the search for similar parts."""

from __future__ import annotations

import os
from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from . import _mocap
from ._call import public
from ._errors import OptionError
from ._job_options import ReadOptions
from ._options import StrPath
from ._report import Reports, parsed
from ._scene import SceneLike, native_of

_FEATURES = 27


class Database:
    """Clips with the features of their frames, at 60 frames per second, for all skeletons. ``docs/search.md`` lists the
    features.

    >>> database = mocap.index(["walk.bvh", "dance.bvh"])                            # doctest: +SKIP
    >>> database.find("walk.bvh", 1.0, 2.5)[0]["file"]                               # doctest: +SKIP
    'walk.bvh'
    """

    def __init__(self, native: _mocap.Database) -> None:
        self._native = native

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Database:
        """Reads an ``.mdb`` file, which ``mocap index`` or :meth:`write` wrote.

        Raises:
            MocapError: If the file is cut off, damaged, or of another version.
        """
        return cls(_mocap.read_database(path))

    def __len__(self) -> int:
        return len(self._native)

    def __repr__(self) -> str:
        return f"<mocap.Database of {len(self)} clips>"

    def _repr_html_(self) -> str:
        return self.clips._repr_html_()

    @property
    def clips(self) -> Reports:
        """The clips. Each has its ``row`` in a survey, whether it is ``mirrored`` and ``packed``, its begin in the
        file, its number of ``frames``, and its ``first`` frame."""
        return Reports(parsed(self._native.clips_json()))

    @property
    def features(self) -> npt.NDArray[np.float32]:
        """The features of all frames: frames x 27."""
        return self._native.features().reshape(-1, _FEATURES)

    @property
    def contacts(self) -> npt.NDArray[np.uint8]:
        """The parts of the feet at rest in each frame: the sum of 1 and 2 for the left and right ankle, 4 and 8 for the
        balls."""
        return self._native.contacts()

    @public
    def find(
        self,
        scene: SceneLike,
        first: float | None = None,
        last: float | None = None,
        *,
        pose: bool = False,
        animation: int = 0,
        count: int = 10,
        per_clip: int | None = 1,
        mirror: bool = True,
        where: str | None = None,
    ) -> Reports:
        """Finds the parts of clips most similar to a part of a motion, the best first: ``file``, ``clip``, ``first``
        and ``last`` in seconds, ``distance``, ``mirrored``, ``pace``.

        Args:
            scene: The motion, a scene or the path of a file, on any skeleton.
            first: The begin of the part in seconds; by default the begin of the motion.
            last: The end of the part in seconds.
            pose: Whether to search the pose at ``first`` instead of a part.
            animation: The number of the animation, from 0.
            count: Largest number of results.
            per_clip: Largest number of results from one take: a clip and its near-duplicates are one take. None is any
                number.
            mirror: Whether results may match the mirror image.
            where: Search only clips that fulfil this condition, such as ``"walking > 0.5"``.

        Raises:
            MocapError: If the motion is not a humanoid's, the part is outside the motion, or ``where`` is invalid.
            ValueError: For ``pose`` without ``first``.
        """
        if pose and first is None:
            raise OptionError("a pose needs the argument first: the time of the pose in seconds")
        native = native_of(scene)
        text = self._native.find(native, animation, (first, last), pose, count, per_clip, mirror, where)
        return Reports(parsed(text))

    @public
    def write(self, path: StrPath, *, overwrite: bool = False) -> None:
        """Writes the file, ``.mdb``.

        Raises:
            MocapError: If the output would replace an indexed file or a file that may be a source.
        """
        self._native.write(path, overwrite)


@public
def index(
    paths: StrPath | Iterable[StrPath],
    *,
    mirror: bool = False,
    pack: bool = False,
    read_options: ReadOptions = ReadOptions(),
) -> Database:
    """Makes a database of files, as ``mocap index`` does.

    Args:
        paths: The files.
        mirror: Whether the database also has the mirror image of each motion.
        pack: Whether the database includes the motions, as packed clips.
        read_options: How to read.

    Raises:
        MocapError: If a file cannot be read, or has no motion of a humanoid with two feet.
    """
    files = [paths] if isinstance(paths, (str, os.PathLike)) else list(paths)
    return Database(_mocap.index(files, mirror, pack, read_options))
