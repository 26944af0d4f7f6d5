"""``rerun-importer-mocap``: converts the motion of a file to a recording of rerun.

The viewer of rerun starts every executable called ``rerun-importer-NAME`` with the path of a file, and reads a
recording from its standard output: https://rerun.io/docs/concepts/logging-and-ingestion/importers/overview
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _mocap
from ._array_options import Options
from ._errors import MocapError
from ._files import read
from ._job_options import ReadOptions
from ._scene import Motion, Scene

# Tells the viewer to use another importer: EXTERNAL_IMPORTER_INCOMPATIBLE_EXIT_CODE of rerun.
_NOT_MINE = 66
# Most files with these extensions are no motions.
_ARRAYS = ("npz", "npy", "pt", "pth", "pkl", "pickle", "parquet", "csv")
# The largest number of skin vertices over time; above this, only some frames have the skin.
_MOST_BYTES = 256 << 20
# The number of frames whose vertices are sent together.
_FRAMES = 64
_JOINT = (230, 230, 230)
_IN_CONTACT = (80, 200, 90)
_LINK = (110, 160, 220)
_AXES = {"y": "RIGHT_HAND_Y_UP", "z": "RIGHT_HAND_Z_UP", "-y": "RIGHT_HAND_Y_DOWN", "-z": "RIGHT_HAND_Z_DOWN"}


def main() -> int:
    """Answers the viewer's request; the exit code says whether the file is a motion."""
    parser = argparse.ArgumentParser(prog="rerun-importer-mocap", description="Motion capture for the viewer of rerun.")
    parser.add_argument("path", help="the file")
    parser.add_argument("--application-id", help="the application of the recording")
    parser.add_argument("--recording-id", help="the recording")
    parser.add_argument("--entity-path-prefix", help="the entity below which the motion is written")
    parser.add_argument("--static", action="store_true", help="write the first frame only, without times")
    # The viewer also passes the open recording and the time of its opening.
    args, _ = parser.parse_known_args()
    extension = Path(args.path).suffix.lower().lstrip(".")
    # A character may have a motion too.
    if extension not in (*_mocap.extensions(), "vrm") or not os.path.isfile(args.path):
        return _NOT_MINE
    try:
        scene = read(args.path)
    except MocapError as error:
        if error.code == "unknown-format" or extension in _ARRAYS:
            return _NOT_MINE
        print(error, file=sys.stderr)
        return 1
    # The viewer's own importer reads characters without a motion.
    if scene.frames == 0:
        return _NOT_MINE
    try:
        import rerun  # type: ignore[import-not-found, unused-ignore]
    except ModuleNotFoundError:
        print('rerun-importer-mocap needs rerun-sdk: pip install "mocap-kit[rerun]"', file=sys.stderr)
        return 1
    recording = rerun.RecordingStream(args.application_id or "rerun-importer-mocap", recording_id=args.recording_id)
    root = (args.entity_path_prefix or rerun.new_entity_path([Path(args.path).stem])).rstrip("/")
    recording.stdout(default_blueprint=_views(rerun, root))
    _Logger(rerun, recording, root, scene, args.static).log(args.path)
    recording.flush()
    return 0


def _views(rerun: Any, root: str) -> Any:
    """The first view of the viewer: the figure, and beside it the contacts and the curves."""
    views = rerun.blueprint
    figure = views.Spatial3DView(origin=root, name="figure")
    names = ("contacts", "positions", "rotations")
    plots = [views.TimeSeriesView(origin=f"{root}/{name}", name=name) for name in names]
    return views.Blueprint(views.Horizontal(figure, views.Vertical(*plots), column_shares=[2, 1]))


class _Logger:
    """Writes a scene below an entity, in the unit and the axes of the file, which the entity converts to metres."""

    def __init__(self, rerun: Any, recording: Any, root: str, scene: Scene, is_static: bool) -> None:
        self.rr = rerun
        self.recording = recording
        self.root = root
        self.scene = scene
        self.frames = 1 if is_static else scene.frames
        self.is_static = is_static

    def log(self, path: str) -> None:
        rr, scene = self.rr, self.scene
        guessed = scene.figure()["survey"]
        axes = getattr(rr.ViewCoordinates, _AXES[guessed["up"]["value"]])
        self._static(self.root, axes, rr.Transform3D(scale=guessed["metres_per_unit"]))
        for warning in scene.warnings:
            self._static(f"{self.root}/warnings", rr.TextLog(warning, level="WARN"))
        if len(scene.clips) > 1:
            others = ", ".join(scene.clips[1:])
            self._static(f"{self.root}/clips", rr.TextLog(f"shown: {scene.clips[0]}; not shown: {others}"))
        motion = scene.to_numpy(Options(rot="euler"))
        contacts = self._contacts()
        self._skeleton(motion, contacts)
        self._skin(path)
        if not self.is_static:
            self._curves(motion, contacts)

    def _contacts(self) -> NDArray[np.bool_] | None:
        """The joints in contact with the ground, frame by frame; ``None`` if there are no feet."""
        try:
            return self.scene.to_numpy(Options(contacts=True)).contacts
        except MocapError:
            return None

    def _skeleton(self, motion: Motion, contacts: NDArray[np.bool_] | None) -> None:
        rr, count = self.rr, len(motion.names)
        positions = motion.positions[: self.frames]
        colours = np.full((self.frames, count, 3), _JOINT, np.uint8)
        if contacts is not None:
            colours[contacts[: self.frames]] = _IN_CONTACT
        joints, links = f"{self.root}/joints", f"{self.root}/links"
        # The viewer shows the names under the pointer.
        self._static(joints, rr.Points3D.from_fields(labels=motion.names, show_labels=False, radii=[-3.0]))
        points = rr.Points3D.columns(positions=positions.reshape(-1, 3), colors=colours.reshape(-1, 3))
        self._columns(joints, points.partition([count] * self.frames))
        parents = np.asarray(motion.parents)
        children = np.flatnonzero(parents >= 0)
        if len(children) > 0:
            strips = np.stack([positions[:, parents[children]], positions[:, children]], axis=2)
            self._static(links, rr.LineStrips3D.from_fields(radii=[-1.5], colors=[_LINK]))
            lines = rr.LineStrips3D.columns(strips=list(strips.reshape(-1, 2, 3)))
            self._columns(links, lines.partition([len(children)] * self.frames))

    def _skin(self, path: str) -> None:
        rr = self.rr
        skin = _mocap.skin(path, ReadOptions())
        parts = skin.parts()
        if not parts:
            return
        vertices = sum(count for _, count, _ in parts)
        step = -(-vertices * 12 * self.frames // _MOST_BYTES)
        if step > 1:
            said = f"the skin is written once every {step} frames, because it has {vertices} vertices in {self.frames} frames"
            self._static(f"{self.root}/skin", rr.TextLog(said))
        frames = np.arange(0, self.frames, step)
        for part, (name, count, colour) in enumerate(parts):
            entity = f"{self.root}/skin/{rr.escape_entity_path_part(f'{part} {name}')}"
            triangles = skin.triangles(part)
            # The viewer needs normals; all frames use those of the first frame.
            first = skin.vertices(part, 0.0)
            mesh = rr.Mesh3D.from_fields(
                triangle_indices=triangles, vertex_normals=_normals(first, triangles), albedo_factor=colour
            )
            self._static(entity, mesh)
            for batch in np.split(frames, range(_FRAMES, len(frames), _FRAMES)):
                deformed = np.concatenate([skin.vertices(part, float(tick)) for tick in batch])
                columns = rr.Mesh3D.columns(vertex_positions=deformed)
                self._columns(entity, columns.partition([count] * len(batch)), batch)

    def _curves(self, motion: Motion, contacts: NDArray[np.bool_] | None) -> None:
        rr = self.rr
        for entity, names, values in self._series(motion, contacts):
            self._static(entity, rr.SeriesLines(names=names))
            width = len(names)
            columns = rr.Scalars.columns(scalars=np.asarray(values, np.float64).reshape(-1))
            self._columns(entity, columns.partition([width] * self.frames))

    def _series(
        self, motion: Motion, contacts: NDArray[np.bool_] | None
    ) -> Iterator[tuple[str, list[str], NDArray[Any]]]:
        """Entities with the names and the values of their curves: degrees, and positions in the unit of the file."""
        part = self.rr.escape_entity_path_part
        # Names may repeat, and entities must not.
        names = [name if motion.names.count(name) == 1 else f"{name} {at}" for at, name in enumerate(motion.names)]
        nodes = {node.name: node for node in self.scene.nodes}
        for joint, name in enumerate(names):
            if nodes[motion.names[joint]].kind == "end_site":
                continue
            if motion.parents[joint] < 0:
                yield f"{self.root}/positions/{part(name)}", _named(name), motion.positions[:, joint]
            yield f"{self.root}/rotations/{part(name)}", _named(name), motion.rotations[:, joint]
        if contacts is not None:
            for foot in np.flatnonzero(contacts.any(axis=0)):
                name = names[foot]
                yield f"{self.root}/contacts/{part(name)}", [name], contacts[:, foot]

    def _static(self, entity: str, *values: Any) -> None:
        self.rr.log(entity, *values, static=True, recording=self.recording)

    def _columns(self, entity: str, columns: Any, frames: NDArray[np.int64] | None = None) -> None:
        """Writes a row for each frame, by default for all frames."""
        rr = self.rr
        ticks = np.arange(self.frames) if frames is None else frames
        times = [
            rr.TimeColumn("tick", sequence=ticks),
            rr.TimeColumn("time", duration=ticks / (self.scene.frame_rate or 1.0)),
        ]
        rr.send_columns(entity, [] if self.is_static else times, columns, recording=self.recording)


def _named(joint: str) -> list[str]:
    return [f"{joint} {axis}" for axis in "xyz"]


def _normals(vertices: NDArray[np.float32], triangles: NDArray[np.uint32]) -> NDArray[np.float32]:
    """The sums of the normals of the triangles about each vertex, weighted by area."""
    corners = vertices[triangles]
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sums = np.zeros_like(vertices)
    for corner in range(3):
        np.add.at(sums, triangles[:, corner], faces)
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    lengths[lengths == 0] = 1
    normals: NDArray[np.float32] = sums / lengths
    return normals


if __name__ == "__main__":
    sys.exit(main())
