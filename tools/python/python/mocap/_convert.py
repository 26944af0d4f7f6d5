"""Writes motions to files by jobs."""

from __future__ import annotations

from typing import Any

from . import _mocap
from ._errors import OptionError
from ._job_options import ReadOptions, WriteOptions
from ._options import StrPath, as_json
from ._scene import Scene, SceneLike

_AS_READ = ReadOptions().to_job()


def converted(source: SceneLike, target: StrPath, job: dict[str, Any]) -> int:
    """Runs a job on a file or a scene. Returns the number of written bytes."""
    if isinstance(source, Scene):
        if job.get("read", _AS_READ) != _AS_READ:
            raise OptionError("the source is a scene, so its file was read before: give reading options to mocap.read")
        return _mocap.write_scene(source._native, target, as_json(job))
    return _mocap.convert(source, target, as_json(job))


def written(scene: SceneLike, target: StrPath, options: WriteOptions) -> None:
    """Writes a scene, or a file without changes."""
    converted(scene, target, {"write": options.to_job()})
