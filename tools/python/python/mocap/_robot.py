"""Motions on robots."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _mocap
from ._call import public
from ._errors import OptionError
from ._options import Bones, StrPath, Weights, as_json, names_of, weights_of
from ._report import Report, parsed
from ._retarget import _locks
from ._scene import SceneLike, native_of
from ._words import Feet, Floor, RobotFormat

@dataclass(frozen=True, repr=False)
class RobotMotion:
    """A motion of a robot with F frames and J joints; float64, in metres and radians, +Z up.

    Attributes:
        fps: Frames a second.
        root_pos: (F, 3): the base.
        root_rot: (F, 4): x, y, z, w.
        dof_pos: (F, J): the joints, within their limits.
        dof_names: The names of the joints.
        contacts: bool, (F, 2): whether the left and the right foot of the source are at rest.
        qpos: (F, 7 + J): MuJoCo's order, with rotations as w, x, y, z.
        report: How well the motion sits on the robot, and a verdict; empty for frames of a stream, which has one of its own.
    """

    fps: float
    root_pos: NDArray[np.float64]
    root_rot: NDArray[np.float64]
    dof_pos: NDArray[np.float64]
    dof_names: list[str]
    contacts: NDArray[np.bool_]
    qpos: NDArray[np.float64]
    report: Report
    _clip: _mocap.RobotClip | None = field(default=None, repr=False, compare=False)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_clip": None}

    @public
    def save(
        self, path: StrPath, to: RobotFormat | None = None, *, overwrite: bool = False
    ) -> None:
        """Writes the motion, as ``mocap robot`` does: what was solved, whatever became of the arrays.

        Args:
            path: The file to write.
            to: Its format; ``None`` for that of its extension, ``.npz``, ``.pkl`` or ``.csv``.
            overwrite: Whether to replace a file that this package did not write.

        Raises:
            MocapError: Where another file is there, or the file cannot be written.
            ValueError: For a format that does not exist, for one whose readers expect another frame rate, for a motion that
                came from another process, and for frames of a stream.
        """
        if self._clip is None:
            reason = "the frames of a stream, and a motion that was pickled, have their arrays alone"
            raise OptionError(f"{reason}: save what Robot.retarget gave, in the process that solved it")
        self._clip.save(path, to, overwrite)

    def __repr__(self) -> str:
        return f"<mocap.RobotMotion of {len(self.qpos)} frames and {len(self.dof_names)} joints at {self.fps:g} a second>"

    def _repr_html_(self) -> str:
        counts = {"frames": len(self.qpos), "fps": self.fps, "joints": len(self.dof_names)}
        return Report({**counts, **self.report})._repr_html_()


class Robot:
    """A robot of a URDF file, or of an XML file of MuJoCo.

    >>> robot = mocap.Robot("g1.urdf")                               # doctest: +SKIP
    >>> motion = robot.retarget("walk.bvh", fps=50)                  # doctest: +SKIP
    >>> motion.report["verdict"], motion.dof_pos.shape               # doctest: +SKIP
    ('good', (218, 29))

    Raises:
        MocapError: Where the file cannot be read.
    """

    @public
    def __init__(self, path: StrPath) -> None:
        self._native = _mocap.Robot(path)

    def __repr__(self) -> str:
        return f"<mocap.Robot {self.name!r} of {len(self.dof_names)} joints>"

    def _repr_html_(self) -> str:
        return Report(name=self.name, joints=", ".join(self.dof_names))._repr_html_()

    @property
    def name(self) -> str:
        """Its name."""
        return self._native.name

    @property
    def dof_names(self) -> list[str]:
        """The names of the joints, in the order of ``dof_pos``."""
        return self._native.dof_names

    @public
    def retarget(
        self,
        source: SceneLike,
        *,
        fps: float | None = None,
        feet: Feet = "lock",
        velocity_limits: bool = False,
        passes: Literal[1, 2] = 2,
        floor: Floor = "auto",
        map: Bones | None = None,
        bones: Bones | None = None,
        weights: Weights | None = None,
    ) -> RobotMotion:
        """The first motion of a scene on the robot.

        Args:
            source: A motion of a humanoid, a scene or the path of a file, with any names, rest pose, unit and axes.
            fps: Frames a second; ``None`` for those of the source.
            feet: ``"lock"`` holds feet still while those of the source stand.
            velocity_limits: With one pass, whether joints keep within the velocities of the robot's file, too.
            passes: 1 solves frame by frame, which is faster; 2 then solves all frames of a window together, so that
                joints move smoothly, within their velocities and without jumps.
            floor: Where the floor is: ``"auto"``, under the feet that stand, so that one that stands a little too high comes
                down; ``"z=0"``, at height 0 of the source's file; ``"keep"``, where the source has it in the mean, with no
                height changed.
            map: The names of links for bones, where the guess is wrong: ``{"leftFoot": "left_ankle_link"}``; ``None`` for
                a bone that the robot does not have.
            bones: The names of joints of the source for bones, likewise.
            weights: The weights of solvers that differ from their defaults, as ``{"robot": {"hand": 1.0}}`` or
                ``{"foot_lock": {"aim": 0.9}}``; docs/weights.md lists them.

        Raises:
            MocapError: Where the source or the robot is not a humanoid, with the reason, and for a name that is none.
            ValueError: Where ``passes`` is neither 1 nor 2, and for a ``floor`` that there is not.
        """
        names = (names_of(map), names_of(bones), as_json(weights_of(weights)))
        arrays, report, clip = self._native.retarget(native_of(source), fps, _locks(feet), velocity_limits, passes, floor, *names)
        return RobotMotion(dof_names=self.dof_names, report=parsed(report), _clip=clip, **arrays)

    @public
    def stream(
        self,
        source: SceneLike,
        *,
        fps: float | None = None,
        feet: Feet = "lock",
        passes: Literal[1, 2] = 2,
        floor: Floor = "auto",
        map: Bones | None = None,
        bones: Bones | None = None,
        weights: Weights | None = None,
    ) -> RobotStream:
        """Begins a motion that comes pose by pose.

        >>> stream = robot.stream(skeleton, fps=60)                              # doctest: +SKIP
        >>> for pose in poses:                                                   # doctest: +SKIP
        ...     if (frame := stream.push(pose)) is not None:
        ...         send(frame.qpos[0])

        Args:
            source: The skeleton of the poses, and a motion of it that shows where its floor is, if there is one.
            fps: Poses a second, from 1 to 1000; ``None`` for the rate of the motion of ``source``.
            feet: As for :meth:`retarget`, and so are the others. With one pass frames come 0.1 s later, with two 0.6 s.
        """
        names = (names_of(map), names_of(bones), as_json(weights_of(weights)))
        native = native_of(source)
        rate = native.frame_rate if fps is None else fps
        return RobotStream(self.dof_names, self._native.stream(native, rate, _locks(feet), passes, floor, *names))


class RobotStream:
    """A motion on a robot while it comes: poses in, frames out, :attr:`delay` seconds later. :meth:`Robot.stream` begins one."""

    def __init__(self, dof_names: list[str], native: _mocap.RobotStream) -> None:
        self.dof_names = dof_names
        self._native = native

    def __repr__(self) -> str:
        return f"<mocap.RobotStream of {len(self.dof_names)} joints, {self.delay:.2f} s late>"

    @property
    def delay(self) -> float:
        """How many seconds later a frame is given back."""
        return self._native.delay

    def push(self, pose: ArrayLike) -> RobotMotion | None:
        """Takes the next pose, and gives back the frame whose time has come, a motion of one frame; ``None`` at first.

        Args:
            pose: The matrix of each node of the skeleton to its parent, (nodes, 4, 4), as ``Scene.pose(tick, space="local")``
                gives them.

        Raises:
            ValueError: For another shape, and where a number is not finite.
        """
        matrices = np.ascontiguousarray(pose, np.float32)
        expected = (self._native.nodes, 4, 4)
        if matrices.shape != expected:
            raise OptionError(f"pose must have the shape {expected}, got {matrices.shape}")
        if not np.isfinite(matrices).all():
            raise OptionError("a number of pose is not finite")
        arrays = self._native.push(matrices)
        return None if arrays is None else self._frames(arrays)

    def finish(self) -> RobotMotion:
        """The frames that are left, at the end. Poses that come afterwards go on from there."""
        return self._frames(self._native.finish())

    @property
    def report(self) -> Report | None:
        """How well the frames of the last 30 s sit on the robot; ``None`` before the first frame."""
        report = self._native.report()
        return None if report is None else parsed(report)

    def _frames(self, arrays: dict[str, Any]) -> RobotMotion:
        return RobotMotion(dof_names=self.dof_names, report=Report(), **arrays)
