"""Scenes, and their motions as arrays."""

from __future__ import annotations

import html
import io
import json
import os
import sys
import tempfile
import webbrowser
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _mocap
from ._array_options import OptionChanges, Options, Unpack, changed, takes_fields
from ._call import public
from ._errors import OptionError, of_file
from ._job_options import ReadOptions
from ._options import Bones, StrPath, names_of
from ._picture import Picture, positive
from ._points import numbers
from ._report import Columns, Report, parsed

# A notebook stores its outputs, so do not embed a larger page by default.
_LARGEST_CELL = 20_000_000


@dataclass(frozen=True, repr=False)
class Motion:
    """A motion as arrays of F frames and J joints. Coordinates are right-handed.

    Attributes:
        positions: float32, (F, J, 3): x, y, z in the unit and the axes of the output.
        rotations: float32, (F, J, 4), (F, J, 6), (F, J, 3, 3) or (F, J, 3); see ``Options.rot``.
        velocities: float32, (F, J, 3), in units per second; ``None`` unless requested.
        contacts: bool, (F, J): whether a foot is in contact with the ground; ``None`` unless requested.
        names: The names of the joints; they may repeat.
        parents: int32, (J,): indices into ``names``; -1 for a joint without a parent.
        offsets: float32, (J, 3): rest offsets from the parents, in the axes of the parents and the unit of the output.
        frame_rate: Frames per second; 0 without a motion.
        header_json: ``header`` as JSON.
    """

    positions: NDArray[np.float32]
    rotations: NDArray[np.float32]
    velocities: NDArray[np.float32] | None
    contacts: NDArray[np.bool_] | None
    names: list[str]
    parents: NDArray[np.int32]
    offsets: NDArray[np.float32]
    frame_rate: float
    header_json: str

    def __repr__(self) -> str:
        counts = f"{len(self.positions)} frames and {len(self.names)} joints"
        return f"<mocap.Motion of {counts} at {self.frame_rate:g} a second>"

    def _repr_html_(self) -> str:
        arrays = {name: getattr(self, name) for name in ("positions", "rotations", "velocities", "contacts")}
        given = {name: f"{array.dtype} {array.shape}" for name, array in arrays.items() if array is not None}
        return Report(given | {"names": ", ".join(self.names), "frame_rate": self.frame_rate})._repr_html_()

    @cached_property
    def header(self) -> Report:
        """The meaning and the origin of the numbers: unit, axes, joints, source file, decisions, steps."""
        header: Report = parsed(self.header_json)
        return header


class Scene:
    """The contents of a file: a tree of nodes and its motions. :func:`mocap.read` makes a scene. A scene never
    changes."""

    def __init__(self, native: _mocap.Scene) -> None:
        self._native = native

    def __repr__(self) -> str:
        clips = f", the first of {len(self.clips)} clips" if len(self.clips) > 1 else ""
        return f"<mocap.Scene of {len(self.nodes)} nodes, {self.frames} frames at {self.frame_rate:g} a second{clips}>"

    def __reduce__(self) -> tuple[Any, tuple[bytes]]:
        # Worker processes send scenes to each other.
        return _unpickled, (self._native.state(),)

    def to_html(self, name: str | None = None) -> str:
        """A page with the player of ``mocap view``. The page works offline and without other files.

        Args:
            name: The name of the motion; by default the name of its file.
        """
        return _mocap.page([(self._name(name), self._native)])

    @public
    def show(self, path: StrPath | None = None) -> Any:
        """Shows the motion in a player: in the cell of a notebook, or else in a browser.

        Args:
            path: A file to write the page to, instead of showing it.

        Returns:
            The page for the notebook cell; ``None`` outside a notebook.

        Raises:
            OSError: If the page cannot be written.
        """
        page = self.to_html()
        if path is not None:
            try:
                Path(path).write_text(page, encoding="utf-8")
            except OSError as failure:
                raise of_file(failure, path) from None
            return None
        if _in_notebook():
            return _Page(page)
        # The browser reads it after this process has ended.
        with tempfile.NamedTemporaryFile("w", suffix=".html", prefix="mocap-", delete=False, encoding="utf-8") as file:
            file.write(page)
        webbrowser.open(Path(file.name).as_uri())
        return None

    def _repr_html_(self) -> str:
        page = self.to_html()
        if len(page) > _LARGEST_CELL:
            size = f"{len(page) / 1e6:.0f} MB"
            return f"<code>{html.escape(repr(self))}</code>: a player of {size} is shown by <code>scene.show()</code>"
        return _Page(page)._repr_html_()

    @public
    def plot(self, *joints: str, name: str | None = None, width: int = 960) -> Picture:
        """Draws curves of joints over time: the position in the world, and the rotation relative to the parent in
        degrees.

        >>> scene.plot("LeftFoot", "RightFoot").save("feet.svg")  # doctest: +SKIP

        Args:
            joints: The names of the joints, or of their bones; without names, the root.
            name: The name of the motion in the picture; by default the name of its file.
            width: In pixels.

        Raises:
            OptionError: If no joint and no bone has a name.
        """
        named = list(joints) or [node.name for node in self.nodes[:1]]
        return Picture(_mocap.plot(self._native, self._name(name), named, positive("width", width)))

    @public
    def sheet(self, *, poses: int = 8, name: str | None = None, width: int = 1600) -> Picture:
        """Draws poses over time in a row, with the path of the root, as ``mocap sheet`` does.

        Args:
            poses: The number of poses.
            name: The name of the motion in the picture; by default the name of its file.
            width: In pixels.
        """
        return Picture(_mocap.sheet([(self._name(name), self._native)], positive("poses", poses), positive("width", width)))

    def _name(self, name: str | None) -> str:
        origin = self.metadata.get("origin") or {}
        return name if name is not None else str(origin.get("name") or "motion")

    @public
    def figure(self, bones: Bones | None = None) -> Report:
        """The properties that the file does not state, such as unit, axes and bones, each with confidence and reason.

        Keys: ``survey`` with ``unit``, ``up`` and ``frame_rate``; ``up`` and ``facing`` of the body; ``rest_pose``;
        ``asymmetry``; and ``humanoid`` with ``found``, ``reason`` and ``bones``, in each of which ``joint`` is an index of
        :attr:`nodes`.

        Args:
            bones: The joints of known bones: ``{"leftFoot": "ankle_L"}``; ``None`` for an absent bone.

        Raises:
            MocapError: If no joint has a given name.
        """
        figure: Report = parsed(self._native.figure(names_of(bones)))
        return figure

    @property
    def bones(self) -> dict[str, str]:
        """The joint of each humanoid bone, by the names of VRM; empty if the skeleton is not a humanoid.

        The argument ``bones=`` of other functions takes such a dictionary, or only the corrected entries.

        >>> scene.bones["leftFoot"]  # doctest: +SKIP
        'LeftFoot'
        """
        nodes = self.nodes
        found = self.figure()["humanoid"]["bones"]
        return {bone: nodes[joint["joint"]].name for bone, joint in found.items()}

    @property
    def nodes(self) -> list[_mocap.Node]:
        """The nodes, depth-first: parents precede their children.

        Each has ``name``, ``kind`` (``"joint"``, ``"end_site"`` or ``"group"``), ``parent`` (an index in this list or
        ``None``), ``offset`` (x, y, z to the parent at rest, in the file's unit) and ``rotation_order`` (such as
        ``"ZXY"``, or ``None``). ``humanoid_bone`` is the bone of a humanoid, if the file states it. ``face`` is for
        nodes of a VRM animation: an expression such as ``"blink"``, or the gaze ``"lookAt"``. The weight of an
        expression is x of the node's position.
        """
        return self._native.nodes

    @property
    def clips(self) -> list[str]:
        """The names of the clips (animations), in the order of the file. Every function uses the first clip.

        :meth:`clip` selects another clip, and ``mocap.read(path, clip="run")`` reads only that clip.

        >>> mocap.read("hero.glb").clips  # doctest: +SKIP
        ['idle', 'run', 'walk']
        """
        return self._native.clips

    @public
    def clip(self, clip: int | str) -> Scene:
        """The scene with only one of its clips.

        >>> run = scene.clip("run")  # doctest: +SKIP

        Args:
            clip: The name of the clip, or its number from 0.

        Raises:
            MocapError: If there is no such clip; the message lists the clips.
        """
        if isinstance(clip, int) and clip < 0:
            raise OptionError(f"clip must be a number from 0, got {clip}")
        return Scene(self._native.clip(clip))

    @property
    def frames(self) -> int:
        """The number of frames."""
        return self._native.frames

    @property
    def frame_rate(self) -> float:
        """Frames per second; 0 without a motion."""
        return self._native.frame_rate

    @property
    def warnings(self) -> list[str]:
        """The warnings of the reader, each as code and sentence."""
        return self._native.warnings

    @property
    def metadata(self) -> Report:
        """The origin of the scene, and the decisions of the reader."""
        metadata: Report = parsed(self._native.metadata_json)
        return metadata

    # Programs call this method for every frame, so it checks its arguments only at their use.
    def pose(self, tick: float, *, space: Literal["world", "local"] = "world") -> NDArray[np.float32]:
        """The matrices of all nodes at a tick, float32, (nodes, 4, 4), for column vectors.

        Args:
            tick: The time in ticks; in BVH a tick is a frame. Poses between two frames are interpolated. Ticks outside
                the motion give the first or last pose.
            space: ``"world"`` for matrices relative to the world, ``"local"`` relative to the parents.
        """
        return self._native.pose_matrices(tick, is_world(space))

    @public
    def chain(self, joint: str, tick: float = 0.0, *, point: ArrayLike | None = None) -> Report:
        """The separate matrices from the root to a joint, T = J0 L1 J1 L2 J2 ...

        Keys: ``chain``, and ``point_in_world`` if ``point`` is given. An entry of ``chain`` has ``symbol`` (``"J0"``,
        ``"L1"``), ``joint``, ``node``, ``matrix``, and ``product``, the product of all matrices up to this one.
        Matrices are lists of rows. A J also has ``order``, and its angles in this order as ``degrees``. An angle is
        positive counter-clockwise for a viewer towards whom the axis points.

        >>> scene.chain("Wrist", 9, point=[0.5, 0, 0])["point_in_world"]  # doctest: +SKIP
        [0.66514313, 2.0790663, 0.0]

        Args:
            joint: The name of a joint or an end site.
            tick: As for :meth:`pose`.
            point: A point attached to the joint, in its axes and in the unit of the scene.

        Raises:
            MocapError: If no joint has this name.
        """
        local = None if point is None else numbers(point, "point", 3)
        chain: Report = parsed(self._native.chain(joint, tick, local))
        return chain

    @takes_fields
    def to_numpy(self, options: Options = Options(), **changes: Unpack[OptionChanges]) -> Motion:
        """The motion as arrays. Takes :class:`Options`, its fields by name, or both.

        >>> motion = scene.to_numpy(rot="6d", space="world", fps=30)  # doctest: +SKIP
        >>> motion.positions.shape, motion.rotations.shape  # doctest: +SKIP
        ((300, 31, 3), (300, 31, 6))

        Raises:
            MocapError: If an option is invalid, such as a pattern that no joint's name matches.
            TypeError: If there is no such option.
        """
        return Motion(**self._native.arrays(changed(options, changes).to_json()))

    @public
    def to_smpl(self, layout: Literal["smplx", "amass", "kimodo", "soma", "mhr", "humanml3d"] = "smplx") -> Columns:
        """The motion of a humanoid in a layout of SMPL-X, SOMA or MHR; see ``docs/arrays.md``.

        Rotations are relative to the T-pose, for 55 joints; fingers begin at a flat hand; ``rest_joints`` has the joints of
        the body itself. ``humanml3d`` has one array, ``"vectors"``: 263 numbers a frame, at 20 frames a second.

        >>> scene.to_smpl()["body_pose"].shape  # doctest: +SKIP
        (300, 63)

        Raises:
            MocapError: If no humanoid is found, or there is no motion; and for another layout.
        """
        loaded = np.load(io.BytesIO(self._native.smpl(layout)))
        if isinstance(loaded, np.ndarray):
            return Columns({"vectors": loaded})
        return Columns({name: loaded[name] for name in loaded.files})

    def joint_angles(self) -> Columns:
        """The joint angles of a humanoid by the definitions of the International Society of Biomechanics.

        A column of ``float64`` for each name, in degrees: ``hip_flexion_r``, ``knee_angle_l``, ...; ``time`` is in seconds,
        and ``pelvis_tx``, ``pelvis_ty``, ``pelvis_tz`` in metres. ``docs/biomechanics.md`` defines every column.
        ``pandas.DataFrame(scene.joint_angles())`` is a table of them.

        >>> scene.joint_angles()["knee_angle_r"].max()  # doctest: +SKIP
        61.2

        Raises:
            MocapError: If no humanoid is found, or there is no motion.
        """
        rate, names, values = self._native.joint_angles()
        table = values.reshape(-1, len(names))
        return Columns({"time": np.arange(len(table)) / rate, **dict(zip(names, table.T))})

    def analog(self) -> Columns:
        """The analog channels of a C3D file: a column of ``float64`` for each; ``time`` is in seconds.

        Their units, with the events and the force plates of the file, are in :attr:`recorded`.

        Raises:
            MocapError: If the file has no analog channels.
        """
        return self._time_series(of_ground=False)

    def ground_forces(self) -> Columns:
        """The ground reaction forces of the force plates of a C3D file, in newtons and metres, +Y up.

        For plate 1 ``ground_force_1_vx`` ... is the force, ``ground_force_1_px`` ... the centre of pressure,
        ``ground_moment_1_mx`` ... the free moment, as OpenSim names them; ``time`` is in seconds.

        Raises:
            MocapError: If the file has no force plates of a known type.
        """
        return self._time_series(of_ground=True)

    def _time_series(self, of_ground: bool) -> Columns:
        rate, names, values = self._native.time_series(of_ground)
        table = values.reshape(-1, len(names))
        return Columns({"time": np.arange(len(table)) / rate, **dict(zip(names, table.T))})

    @property
    def recorded(self) -> Report | None:
        """The data of a C3D file besides markers: ``events`` with ``time`` in seconds, ``channels`` and ``plates``.

        ``None`` for files without such data.
        """
        recorded: Report | None = parsed(self._native.recorded())
        return recorded

    @property
    def solved(self) -> Report | None:
        """The residuals of a skeleton that was solved from markers.

        Keys: ``markers``, ``rms_of_seconds``, ``joints`` with lengths and deviations in metres, ``swaps``, ``filled`` and
        ``frames``; ``None`` for other scenes.
        """
        solved: Report | None = parsed(self._native.solved())
        return solved

    def gait(self) -> Report:
        """The heel strikes and toe offs of a walk, its strides, and the means of a gait laboratory.

        Keys: ``strides``, ``cadence`` in steps a minute, ``alternates``, ``events_of_file``, ``events_of_plates``,
        ``in_place``, and ``left`` and ``right``. Each side has:

        - ``cycles``: the mean angles of each per cent of the stride
        - ``heel_strikes`` and ``toe_offs`` in seconds
        - ``stride_length``, ``step_length``, ``step_width`` in metres, ``stride_time``, ``step_time`` in seconds,
          ``stance`` in per cent, ``speed`` in metres per second: each has ``mean``, ``deviation`` and ``count``, or is
          ``None``

        For an animal on four legs, the keys are ``frame_rate``, ``stretches`` and ``paws``. A stretch has ``gait``,
        such as ``"trot"``, ``confidence``, ``frames``, ``strides``, ``duty_factor``, ``lag`` and ``speed``.

        Raises:
            MocapError: If no humanoid and no animal is found, or no foot of a humanoid makes a stride.
        """
        gait: Report = parsed(self._native.gait())
        return gait

    @takes_fields
    def to_arrow(
        self, options: Options = Options(), *, clip: str = "", **changes: Unpack[OptionChanges]
    ) -> _mocap.ArrowTable:
        """The motion as a table with a row for each frame and joint.

        The result has almost no methods of its own: ``pyarrow.table(...)``, ``polars.DataFrame(...)``, DuckDB and every
        other library with the Arrow PyCapsule interface take it without a copy. Columns: ``clip``, ``frame``, ``time``
        in seconds, ``joint``, ``x``, ``y``, ``z``, the rotation's (``qx`` ... ``qw``, ``r00`` ..., ``ex`` ``ey``
        ``ez``), and, on request, ``vx``, ``vy``, ``vz`` and ``contact``.

        Raises:
            MocapError: As for :meth:`to_numpy`.
        """
        return self._native.arrow(changed(options, changes, "clip").to_json(), clip)


SceneLike: TypeAlias = Scene | str | os.PathLike[str]
"""A motion: a scene, or the path of a file."""


def native_of(motion: SceneLike) -> _mocap.Scene:
    """The scene of a motion. A path is read first."""
    return motion._native if isinstance(motion, Scene) else _mocap.read(motion, ReadOptions())


class _Page:
    """A page in a notebook cell, in its own iframe."""

    def __init__(self, page: str) -> None:
        self._page = page

    def __repr__(self) -> str:
        return f"<a player of {len(self._page) / 1e6:.1f} MB, which a notebook shows>"

    def _repr_html_(self) -> str:
        # The contents of the iframe have neither the notebook's permissions nor its style.
        style = "width:100%;height:560px;border:0"
        page = html.escape(self._page, quote=True)
        return f'<iframe sandbox="allow-scripts allow-downloads" style="{style}" srcdoc="{page}"></iframe>'


def is_world(space: str) -> bool:
    """Whether a space is ``"world"`` and not ``"local"``."""
    if space not in ("world", "local"):
        raise OptionError(f"space must be world or local, got {space!r}")
    return space == "world"


def _in_notebook() -> bool:
    # In a notebook, IPython is already imported.
    loaded: Any = sys.modules.get("IPython")
    shell = loaded.get_ipython() if loaded is not None else None
    return shell is not None and "IPKernelApp" in getattr(shell, "config", {})


def _unpickled(state: bytes) -> Scene:
    return Scene(_mocap.scene_of(state))
