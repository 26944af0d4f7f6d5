"""Windows of motions for training, as a dataset for PyTorch's ``DataLoader``.

>>> from torch.utils.data import DataLoader                                          # doctest: +SKIP
>>> from mocap.torch import Windows                                                  # doctest: +SKIP
>>> train = Windows("takes", 64, stride=16, features=("rotations", "velocities"))    # doctest: +SKIP
>>> for batch in DataLoader(train, batch_size=32, shuffle=True):                     # doctest: +SKIP
...     loss = model(batch["features"], batch["mask"])

PyTorch is only imported when a window becomes tensors. :meth:`Windows.arrays` returns NumPy arrays without PyTorch.
"""

from __future__ import annotations

import hashlib
import importlib
import json
import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._array_options import Options
from ._call import public
from ._errors import OptionError, of_file
from ._files import read
from ._options import StrPath
from ._packed import PackedClip
from ._scene import Scene
from ._survey import files_of

__all__ = ["Statistics", "Windows"]

Feature = Literal["positions", "rotations", "velocities", "contacts"]
Source: TypeAlias = Scene | PackedClip | str | os.PathLike[str]

# A column that varies less is constant except for rounding, and is not divided.
_SMALLEST_DEVIATION = 1e-6


class Statistics(NamedTuple):
    """Mean and standard deviation of each column over the frames of all clips, and the number of frames."""

    mean: NDArray[np.float32]
    std: NDArray[np.float32]
    frames: int

    def __repr__(self) -> str:
        return f"<mocap.torch.Statistics of {len(self.mean)} columns over {self.frames} frames>"

    def save(self, path: StrPath) -> None:
        """Writes the statistics as ``.npz``.

        Raises:
            OSError: If the file cannot be written.
        """
        try:
            # The file is complete or absent, because another process may read it.
            beside = Path(f"{os.fspath(path)}.{os.getpid()}.tmp")
            with open(beside, "wb") as file:
                np.savez(file, mean=self.mean, std=self.std, frames=np.array(self.frames))
            os.replace(beside, path)
        except OSError as failure:
            raise of_file(failure, path) from None

    @classmethod
    def read(cls, path: StrPath) -> Statistics:
        """Reads what :meth:`save` wrote.

        Raises:
            OSError: If the file cannot be opened.
            OptionError: If the file has no statistics.
        """
        try:
            with np.load(path, allow_pickle=False) as loaded:
                return cls(loaded["mean"], loaded["std"], int(loaded["frames"]))
        except OSError as failure:
            raise of_file(failure, path) from None
        except (KeyError, ValueError):
            raise OptionError(f"{os.fspath(path)} has no statistics: it must be a file of Statistics.save") from None


class Windows:
    """Windows of a fixed number of frames over motions of one skeleton.

    A window is a dictionary: ``features``, float32 (length, columns); ``mask``, bool (length,), false where a window is
    padded; ``clip``, an index of :attr:`names`, and ``first``, its first frame. The columns of a frame are the features
    in order, each joint by joint.
    """

    @public
    def __init__(
        self,
        motions: Source | Iterable[Source],
        length: int,
        *,
        stride: int | None = None,
        features: Sequence[Feature] = ("positions", "rotations"),
        options: Options = Options(rot="6d", space="root"),
        padding: Literal["drop", "edge", "zero"] = "edge",
        normalize: bool = True,
        statistics: Statistics | StrPath | None = None,
        seed: int | None = None,
        cache: StrPath | None = None,
    ) -> None:
        """Reads the motions.

        Args:
            motions: Scenes, packed clips, files, folders of files, and ``.parquet`` files of ``mocap pack``. Parquet
                files need pyarrow, and keep the options with which they were packed.
            length: The number of frames of a window.
            stride: The number of frames from one window of a clip to the next; ``None`` means ``length``.
            features: The features in the columns.
            options: The options of the arrays: frame rate, rotations, unit, axes, joints.
            padding: The handling of a last window that the clip does not fill: ``"drop"`` drops the frames; ``"edge"``
                repeats the last frame; ``"zero"`` fills with zeros. Padded frames are false in the mask.
            normalize: Subtract the mean of each column, and divide by its standard deviation. Contacts stay 0 and 1.
            statistics: The statistics of other windows, such as ``train.statistics``; or a file, which is read if it
                exists, and else written. ``None`` computes the statistics from these motions.
            seed: Shifts every window by a random number of frames below ``stride``, different in each epoch; see
                :meth:`set_epoch`. ``None`` shifts nothing.
            cache: A folder for the arrays and statistics of files. Unchanged files are not read again, and arrays are
                mapped into memory instead of loaded.

        Raises:
            OptionError: If there is no window, or the motions have different skeletons.
            MocapError: If a file cannot be read.
        """
        if length < 1:
            raise OptionError(f"length must be at least 1, got {length}")
        if stride is not None and stride < 1:
            raise OptionError(f"stride must be at least 1, got {stride}")
        if not features:
            raise OptionError("features must name at least one of positions, rotations, velocities and contacts")
        if seed is not None and seed < 0:
            raise OptionError(f"seed must be at least 0, got {seed}")
        self.length = length
        self.stride = stride or length
        self.padding = padding
        self.seed = seed
        self.epoch = 0
        self.names: list[str] = []
        """The clips, by the names of their files."""
        self._clips: list[_Clip] = []
        made = _Maker(tuple(features), options, None if cache is None else Path(cache))
        layout: _Layout | None = None
        for name, clip, own in made.clips(motions):
            layout = layout or own
            if own != layout:
                raise OptionError(_difference(name, own, self.names[0], layout))
            self.names.append(name)
            self._clips.append(clip)
        if layout is None:
            raise OptionError("there is no motion")
        self.joints = list(layout.names)
        """The names of the joints."""
        self.columns = dict(layout.slices())
        """The columns of each feature: ``windows.columns["rotations"]`` is a slice."""
        self._windows = [
            (clip, first) for clip, frames in enumerate(self._clips) for first in self._firsts(frames.frames)
        ]
        if not self._windows:
            longest = max(clip.frames for clip in self._clips)
            raise OptionError(f"no clip has {length} frames, the longest has {longest}: padding='edge' pads them")
        self.statistics = self._statistics(statistics, made)
        """Mean and standard deviation of the columns."""
        if len(self.statistics.mean) != layout.width:
            count = len(self.statistics.mean)
            raise OptionError(f"statistics have {count} columns, but the features of these motions have {layout.width}")
        self._normalize = normalize

    def __len__(self) -> int:
        return len(self._windows)

    def __repr__(self) -> str:
        frames = f"{self.length} frames and {len(self.statistics.mean)} columns"
        return f"<mocap.torch.Windows: {len(self)} windows of {frames} over {len(self._clips)} clips>"

    def __getitem__(self, index: int) -> dict[str, Any]:
        """A window as tensors.

        Raises:
            ImportError: If PyTorch is not installed.
        """
        torch = importlib.import_module("torch")
        window = self.arrays(index)
        tensors = {name: torch.from_numpy(window[name]) for name in ("features", "mask")}
        return {**window, **tensors}

    def __iter__(self) -> Iterator[dict[str, Any]]:
        return (self[index] for index in range(len(self)))

    def set_epoch(self, epoch: int) -> None:
        """With a ``seed``, chooses other shifts of the windows. Equal epochs give equal shifts.

        Call this method before the loader begins an epoch. Workers that stay alive between epochs
        (``persistent_workers``) do not notice the call.
        """
        self.epoch = epoch

    def arrays(self, index: int) -> dict[str, Any]:
        """A window as NumPy arrays."""
        if not -len(self) <= index < len(self):
            raise IndexError(f"there is no window {index}: there are {len(self)}")
        index %= len(self)
        number, first = self._windows[index]
        clip = self._clips[number]
        if self.seed is not None:
            shift = np.random.default_rng([self.seed, self.epoch, index]).integers(self.stride)
            first = min(first + int(shift), max(clip.frames - self.length, first))
        frames = np.array(clip.frames_of(first, self.length), np.float32)
        if self._normalize:
            frames = (frames - self.statistics.mean) / self.statistics.std
        count = len(frames)
        if count < self.length:
            fill = frames[-1:] if self.padding == "edge" else np.zeros_like(frames[:1])
            frames = np.concatenate([frames, np.repeat(fill, self.length - count, axis=0)])
        mask = np.arange(self.length) < count
        return {"features": np.ascontiguousarray(frames, np.float32), "mask": mask, "clip": number, "first": first}

    def restored(self, features: Any) -> Any:
        """Converts features of windows, or of a model, back to their units: the inverse of the normalization."""
        return features * self.statistics.std + self.statistics.mean if self._normalize else features

    def _firsts(self, frames: int) -> range:
        """The first frames of the windows of a clip."""
        if self.padding == "drop":
            return range(0, frames - self.length + 1, self.stride)
        # The last window is the first window that reaches the end.
        last = -(-max(frames - self.length, 0) // self.stride) * self.stride
        return range(0, last + 1 if frames else 0, self.stride)

    def _statistics(self, given: Statistics | StrPath | None, made: _Maker) -> Statistics:
        if isinstance(given, Statistics):
            return given
        path = made.path("statistics", *(clip.key for clip in self._clips)) if given is None else Path(given)
        if path is not None and path.exists():
            return Statistics.read(path)
        computed = _measured(self._clips, self.columns.get("contacts"))
        if path is not None:
            computed.save(path)
        return computed


class _Layout(NamedTuple):
    """The columns of a clip."""

    names: tuple[str, ...]
    rate: float
    widths: tuple[tuple[str, int], ...]

    @property
    def width(self) -> int:
        return sum(width for _, width in self.widths)

    def slices(self) -> Iterator[tuple[str, slice]]:
        first = 0
        for name, width in self.widths:
            yield name, slice(first, first + width)
            first += width


class _Clip:
    """The frames of a clip, in memory or in a mapped file."""

    def __init__(self, table: NDArray[np.float32] | Path, frames: int, key: str) -> None:
        self._table = table
        self.frames = frames
        self.key = key

    def frames_of(self, first: int, count: int) -> NDArray[np.float32]:
        # Map the file again, because a mapping cannot be sent to the workers of a loader.
        table = np.load(self._table, mmap_mode="r") if isinstance(self._table, Path) else self._table
        part: NDArray[np.float32] = table[first : first + count]
        return part


class _Maker:
    """Makes the tables of clips."""

    def __init__(self, features: tuple[Feature, ...], options: Options, cache: Path | None) -> None:
        self.features = features
        changes: dict[str, Any] = {"velocities": True} if "velocities" in features else {}
        changes |= {"contacts": options.contacts or True} if "contacts" in features else {}
        self.options = Options(**{**vars(options), **changes})
        self.cache = cache
        if cache is not None:
            cache.mkdir(parents=True, exist_ok=True)

    def path(self, *parts: str) -> Path | None:
        """The file of the cache for these key parts."""
        if self.cache is None or "" in parts:
            return None
        text = json.dumps([parts, self.features, self.options.to_json()])
        # Use no extension of a motion, because the folder may be among the inputs.
        return self.cache / f"{hashlib.sha256(text.encode()).hexdigest()[:32]}.cached"

    def clips(self, motions: Source | Iterable[Source]) -> Iterator[tuple[str, _Clip, _Layout]]:
        is_one = isinstance(motions, (Scene, PackedClip, str, os.PathLike))
        sources: Iterable[Source] = [motions] if is_one else motions  # type: ignore[list-item, assignment]
        for number, source in enumerate(sources):
            if isinstance(source, PackedClip):
                yield self._of_scene(f"clip {number}", source.to_scene())
            elif isinstance(source, Scene):
                yield self._of_scene(source._name(None), source)
            else:
                for path in files_of([source], "parquet"):
                    is_part = path.lower().endswith(".parquet")
                    yield from self._of_part(path) if is_part else [self._of_file(path)]

    def _of_file(self, path: str) -> tuple[str, _Clip, _Layout]:
        try:
            state = os.stat(path)
        except OSError as failure:
            raise of_file(failure, path) from None
        key = f"{os.path.abspath(path)} {state.st_size} {state.st_mtime_ns}"
        cached = self.path(key)
        if cached is None:
            return self._of_scene(path, read(path))
        table = cached.with_suffix(".frames")
        # The layout is written last.
        if not cached.exists():
            _, clip, layout = self._of_scene(path, read(path))
            _save(table, lambda file: np.save(file, clip.frames_of(0, clip.frames)))
            widths = json.dumps([layout.names, layout.rate, layout.widths, clip.frames])
            _save(cached, lambda file: np.savez(file, layout=np.array(widths)))
        with np.load(cached, allow_pickle=False) as loaded:
            names, rate, columns, frames = json.loads(str(loaded["layout"]))
        layout = _Layout(tuple(names), rate, tuple((name, width) for name, width in columns))
        return path, _Clip(table, frames, key), layout

    def _of_scene(self, name: str, scene: Scene) -> tuple[str, _Clip, _Layout]:
        motion = scene.to_numpy(self.options)
        arrays: dict[str, Any] = {feature: getattr(motion, feature) for feature in self.features}
        return self._of_arrays(name, arrays, motion.names, motion.frame_rate)

    def _of_arrays(
        self, name: str, arrays: dict[str, Any], names: Sequence[str], rate: float
    ) -> tuple[str, _Clip, _Layout]:
        flat = {feature: np.asarray(array, np.float32).reshape(len(array), -1) for feature, array in arrays.items()}
        table = np.concatenate([flat[feature] for feature in self.features], axis=1)
        layout = _Layout(tuple(names), rate, tuple((feature, flat[feature].shape[1]) for feature in self.features))
        return name, _Clip(table, len(table), ""), layout

    def _of_part(self, path: str) -> Iterator[tuple[str, _Clip, _Layout]]:
        """The rows of a file of ``mocap pack``, without rows of unreadable files."""
        parquet = importlib.import_module("pyarrow.parquet")
        try:
            file = parquet.ParquetFile(path)
        except OSError as failure:
            raise of_file(failure, path) from None
        with file:
            missing = [name for name in ("clip", "names", *self.features) if name not in file.schema_arrow.names]
            if missing:
                raise OptionError(f"{path} has no {', '.join(missing)}: mocap pack writes them, with the options for them")
            columns = ["clip", "error", "names", "frames", "frame_rate", *self.features]
            for batch in file.iter_batches(batch_size=1, columns=columns):
                row = {name: batch.column(at)[0] for at, name in enumerate(batch.schema.names)}
                # A dataset has no rows of files that could not be read.
                if "error" in row and row["error"].as_py() is not None:
                    continue
                frames, names = row["frames"].as_py(), row["names"].as_py()
                arrays: dict[str, Any] = {name: _numbers(row[name].values).reshape(frames, -1) for name in self.features}
                yield self._of_arrays(row["clip"].as_py(), arrays, names, row["frame_rate"].as_py())


def _numbers(values: Any) -> NDArray[np.float32]:
    """The numbers of an Arrow list, or of a list of lists with equal lengths."""
    if hasattr(values, "flatten") and hasattr(values.type, "list_size"):
        values = values.flatten()
    return np.asarray(values.to_numpy(zero_copy_only=False), np.float32)


def _save(path: Path, write: Any) -> None:
    """Writes a complete file or nothing."""
    beside = path.with_name(f"{path.name}.{os.getpid()}.tmp")
    try:
        with open(beside, "wb") as file:
            write(file)
        os.replace(beside, path)
    except OSError as failure:
        raise of_file(failure, path) from None


def _measured(clips: Sequence[_Clip], contacts: slice | None) -> Statistics:
    """Mean and deviation over the frames of all clips, in double precision, clip by clip (Chan, Golub and LeVeque)."""
    count, mean, squares = 0, np.zeros(1), np.zeros(1)
    for clip in clips:
        frames = np.asarray(clip.frames_of(0, clip.frames), np.float64)
        if not len(frames):
            continue
        own = frames.mean(axis=0)
        away = own - mean
        whole = count + len(frames)
        squares = squares + ((frames - own) ** 2).sum(axis=0) + away**2 * (count * len(frames) / whole)
        mean = mean + away * (len(frames) / whole)
        count = whole
    deviation = np.sqrt(squares / max(count, 1))
    deviation[deviation < _SMALLEST_DEVIATION] = 1.0
    if contacts is not None:
        mean[contacts], deviation[contacts] = 0.0, 1.0
    return Statistics(mean.astype(np.float32), deviation.astype(np.float32), count)


def _difference(name: str, own: _Layout, first: str, layout: _Layout) -> str:
    """The reason why two clips have different columns."""
    if own.names != layout.names:
        what = f"{len(own.names)} joints, and {first} {len(layout.names)}"
        if len(own.names) == len(layout.names):
            joint, other = next(pair for pair in zip(own.names, layout.names) if pair[0] != pair[1])
            what = f"the joint {joint!r} where {first} has {other!r}"
        return f"{name} has {what}: retarget the motions to one skeleton, or name joints that all have in options"
    if own.rate != layout.rate:
        return f"{name} has {own.rate:g} frames a second, and {first} {layout.rate:g}: give fps in options"
    return f"{name} has other columns than {first}"
