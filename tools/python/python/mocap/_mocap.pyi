"""The native half. Use the package `mocap` instead, which documents what is here."""

import os
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from ._options import ReadOptions, WriteOptions

__all__ = [
    "ArrowTable",
    "Node",
    "Robot",
    "RobotClip",
    "Scene",
    "Survey",
    "add_motions",
    "contacts",
    "convert",
    "edit",
    "examine",
    "extensions",
    "metres_in",
    "prepare",
    "read",
    "read_bytes",
    "retarget",
    "run",
    "survey",
    "table",
    "write",
]

@final
class Node:
    name: str
    kind: str
    parent: int | None
    offset: list[float]
    rotation_order: str | None

@final
class Scene:
    @property
    def nodes(self) -> list[Node]: ...
    @property
    def frames(self) -> int: ...
    @property
    def frame_rate(self) -> float: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def metadata_json(self) -> str: ...
    def pose_matrices(self, tick: float, world: bool) -> NDArray[np.float32]: ...
    def arrays(self, options: str) -> dict[str, Any]: ...
    def smpl(self, layout: str) -> bytes: ...
    def arrow(self, options: str, clip: str) -> ArrowTable: ...

@final
class Robot:
    def __new__(cls, path: str | os.PathLike[str]) -> Robot: ...
    @property
    def name(self) -> str: ...
    @property
    def dof_names(self) -> list[str]: ...
    def retarget(
        self,
        source: Scene,
        fps: float | None,
        lock_feet: bool,
        velocity_limits: bool,
        passes: int,
        floor: str,
        map: str | None,
        bones: str | None,
    ) -> tuple[dict[str, Any], str, RobotClip]: ...

@final
class RobotClip:
    def save(self, path: str | os.PathLike[str], to: str | None, overwrite: bool) -> None: ...

@final
class ArrowTable:
    @property
    def num_rows(self) -> int: ...
    @property
    def column_names(self) -> list[str]: ...
    def __len__(self) -> int: ...
    def __arrow_c_schema__(self) -> object: ...
    def __arrow_c_array__(self, requested_schema: object | None = None) -> tuple[object, object]: ...
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...

@final
class Survey:
    def __len__(self) -> int: ...
    def rows_json(self) -> str: ...
    @property
    def files(self) -> list[str]: ...
    @property
    def problem(self) -> str | None: ...
    def arrow(self) -> ArrowTable: ...
    def write(self, path: str | os.PathLike[str], overwrite: bool) -> None: ...

def survey(paths: list[str], records: list[str], options: str, read: ReadOptions) -> Survey: ...
def examine(files: list[tuple[str, bytes]], options: str, read: ReadOptions) -> list[str]: ...
def extensions() -> list[str]: ...
def read(path: str | os.PathLike[str], options: ReadOptions) -> Scene: ...
def read_bytes(data: bytes, name: str, options: ReadOptions) -> Scene: ...
def run(job: str) -> str: ...
def convert(
    source: str | os.PathLike[str],
    target: str | os.PathLike[str],
    metres_per_unit: float | None,
    up: str | None,
    fps: float | None,
    rest: str,
    t_pose_first: bool,
    names: str | None,
    read: ReadOptions,
    write: WriteOptions,
) -> int: ...
def table(files: list[tuple[str, bytes]], shape: str, options: str, read: ReadOptions) -> ArrowTable: ...
def metres_in(unit: str) -> float: ...
def prepare(scene: Scene, metres_per_unit: float | None, up: str | None) -> Scene: ...
def edit(scene: Scene, step: str, other: Scene | None, bones: str | None) -> tuple[Scene, str]: ...
def contacts(scene: Scene, options: str) -> str: ...
def write(scene: Scene, target: str | os.PathLike[str], options: WriteOptions) -> None: ...
def retarget(source: Scene, target: Scene, scale: float | None, lock_feet: bool) -> tuple[Scene, str]: ...
def add_motions(
    motions: list[tuple[str, Scene]],
    character: str | os.PathLike[str],
    target: str | os.PathLike[str],
    scale: float | None,
    lock_feet: bool,
    replace: bool,
) -> str: ...
