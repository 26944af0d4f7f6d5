"""Retargets motions to robots."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _mocap
from ._call import public
from ._errors import OptionError
from ._files import read
from ._options import Bones, StrPath, Weights, as_json, names_of, weights_of
from ._report import Report, parsed
from ._retarget import _locks
from ._scene import Scene, SceneLike, native_of
from ._words import Feet, Floor, RobotFormat

@dataclass(frozen=True, repr=False)
class RobotMotion:
    """A motion of a robot with F frames and J joints; float64, in metres and radians, +Z up.

    Attributes:
        fps: Frames per second.
        root_pos: (F, 3): the position of the base.
        root_rot: (F, 4): the rotation of the base, x, y, z, w.
        dof_pos: (F, J): the positions of the joints, within their limits.
        dof_names: The names of the joints.
        contacts: bool, (F, 2): whether the left and the right foot of the source are at rest.
        qpos: (F, 7 + J): MuJoCo's order, with rotations as w, x, y, z.
        report: The retargeting quality with a verdict. Empty for frames of a stream, which has its own report.
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
        """Writes the solved motion, as ``mocap robot`` does. Changes of the arrays have no effect.

        Args:
            path: The file to write.
            to: The format; ``None`` takes the format of the extension, ``.npz``, ``.pkl`` or ``.csv``.
            overwrite: Whether to replace a file that this package did not write.

        Raises:
            MocapError: If another program's file exists, or the file cannot be written.
            ValueError: For an unknown format, for a format with another frame rate, for a motion from another process,
                and for frames of a stream.
        """
        if self._clip is None:
            reason = "the frames of a stream and a motion from a pickle have only arrays"
            raise OptionError(f"{reason}: save the result of Robot.retarget in the process that made it")
        self._clip.save(path, to, overwrite)

    def __repr__(self) -> str:
        return f"<mocap.RobotMotion of {len(self.qpos)} frames and {len(self.dof_names)} joints at {self.fps:g} a second>"

    def _repr_html_(self) -> str:
        counts = {"frames": len(self.qpos), "fps": self.fps, "joints": len(self.dof_names)}
        return Report({**counts, **self.report})._repr_html_()


class Robot:
    """A robot from a URDF file or a MuJoCo XML file.

    >>> robot = mocap.Robot("g1.urdf")                               # doctest: +SKIP
    >>> motion = robot.retarget("walk.bvh", fps=50)                  # doctest: +SKIP
    >>> motion.report["verdict"], motion.dof_pos.shape               # doctest: +SKIP
    ('good', (218, 29))

    Raises:
        MocapError: If the file cannot be read.
    """

    @public
    def __init__(self, path: StrPath) -> None:
        self._native = _mocap.Robot(path)
        self._path = path

    def __repr__(self) -> str:
        return f"<mocap.Robot {self.name!r} of {len(self.dof_names)} joints>"

    def _repr_html_(self) -> str:
        return Report(name=self.name, joints=", ".join(self.dof_names))._repr_html_()

    @property
    def name(self) -> str:
        """The name of the robot."""
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
        time_scale: float | Literal["auto"] = 1.0,
        map: Bones | None = None,
        bones: Bones | None = None,
        weights: Weights | None = None,
    ) -> RobotMotion:
        """Retargets the first motion of a scene to the robot.

        Args:
            source: A motion of a humanoid, a scene or the path of a file, with any names, rest pose, unit and axes.
            fps: Frames per second; ``None`` takes the rate of the source.
            feet: ``"lock"`` holds feet still while the source feet are in contact.
            velocity_limits: With one pass, whether joints also stay within the velocity limits of the robot's file.
            passes: 1 solves frame by frame, which is faster. 2 then solves all frames of a window together, so that
                joints move smoothly within their velocity limits.
            floor: The height of the floor. ``"auto"``: under the feet in contact, so that a slightly raised foot is
                lowered; ``"z=0"``: height 0 of the source's file; ``"keep"``: the mean floor of the source, without a
                change of heights.
            time_scale: The playback speed as a factor. ``"auto"`` slows the motion down just as far as the robot's
                limits of velocity and effort need; the report has the factor under ``time_scale``.
            map: The links of bones, to correct mocap's choice: ``{"leftFoot": "left_ankle_link"}``; ``None`` for an
                absent bone.
            bones: The source joints of bones, to correct mocap's choice.
            weights: Weights of solvers that differ from their defaults, such as ``{"robot": {"hand": 1.0}}`` or
                ``{"foot_lock": {"aim": 0.9}}``; docs/weights.md lists them.

        Raises:
            MocapError: If the source or the robot is not a humanoid, or if a name is unknown.
            ValueError: If ``passes`` is neither 1 nor 2, ``floor`` is unknown, or ``time_scale`` is not above 0.
        """
        names = (names_of(map), names_of(bones), as_json(weights_of(weights)))
        arrays, report, clip = self._native.retarget(
            native_of(source), fps, _locks(feet), velocity_limits, passes, floor, str(time_scale), *names
        )
        return RobotMotion(dof_names=self.dof_names, report=parsed(report), _clip=clip, **arrays)

    @public
    def score(self, reference: SceneLike, motion: SceneLike, *, bones: Bones | None = None) -> Report:
        """Scores a motion of the robot against its reference, as ``mocap score`` does. Neither motion changes.

        >>> robot.score("walk.bvh", "policy.npz")["scores"]["mpbpe_local"]   # doctest: +SKIP
        0.031

        Args:
            reference: A motion of a person, or of a robot that ``mocap.read(..., body=...)`` names.
            motion: The motion of the robot, from any program: the path of a file with the positions of its joints, or
                the scene of such a file, read with the robot as ``body``.
            bones: The joints of the reference's bones, to correct mocap's choice.

        Returns:
            The report of the motion, with ``scores`` and ``verdict``. docs/scores.md defines the scores.

        Raises:
            MocapError: If ``motion`` is no motion of the robot, or no frame is in both motions.
        """
        moved = motion if isinstance(motion, Scene) else read(motion, body=self._path)
        report: Report = parsed(self._native.score(native_of(reference), native_of(moved), names_of(bones)))
        return report

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
        """Begins to retarget a live motion, pose by pose.

        >>> stream = robot.stream(skeleton, fps=60)                              # doctest: +SKIP
        >>> for pose in poses:                                                   # doctest: +SKIP
        ...     if (frame := stream.push(pose)) is not None:
        ...         send(frame.qpos[0])

        Args:
            source: The skeleton of the poses. If the scene has a motion, it determines the floor.
            fps: Poses per second, from 1 to 1000; ``None`` takes the rate of the motion of ``source``.
            feet: This argument and the others are as for :meth:`retarget`. With one pass the delay is 0.1 s, with two
                passes 0.6 s.
        """
        names = (names_of(map), names_of(bones), as_json(weights_of(weights)))
        native = native_of(source)
        rate = native.frame_rate if fps is None else fps
        return RobotStream(self.dof_names, self._native.stream(native, rate, _locks(feet), passes, floor, *names))


class RobotStream:
    """Retargets a stream of poses to a robot, with a delay of :attr:`delay` seconds. :meth:`Robot.stream` begins a
    stream."""

    def __init__(self, dof_names: list[str], native: _mocap.RobotStream) -> None:
        self.dof_names = dof_names
        self._native = native

    def __repr__(self) -> str:
        return f"<mocap.RobotStream of {len(self.dof_names)} joints, {self.delay:.2f} s late>"

    @property
    def delay(self) -> float:
        """The delay of a frame in seconds."""
        return self._native.delay

    def push(self, pose: ArrayLike) -> RobotMotion | None:
        """Takes the next pose. Returns the finished frame as a motion of one frame, or ``None`` at first.

        Args:
            pose: The matrix of each node relative to its parent, (nodes, 4, 4), as from ``Scene.pose(tick,
                space="local")``.

        Raises:
            ValueError: If the shape is wrong, or a number is not finite.
        """
        matrices = np.ascontiguousarray(pose, np.float32)
        expected = (self._native.nodes, 4, 4)
        if matrices.shape != expected:
            raise OptionError(f"pose must have the shape {expected}, got {matrices.shape}")
        if not np.isfinite(matrices).all():
            raise OptionError("a number in pose is not finite")
        arrays = self._native.push(matrices)
        return None if arrays is None else self._frames(arrays)

    def finish(self) -> RobotMotion:
        """Returns the remaining frames at the end. Later poses continue the stream."""
        return self._frames(self._native.finish())

    @property
    def report(self) -> Report | None:
        """The quality of the frames of the last 30 s; ``None`` before the first frame."""
        report = self._native.report()
        return None if report is None else parsed(report)

    def _frames(self, arrays: dict[str, Any]) -> RobotMotion:
        return RobotMotion(dof_names=self.dof_names, report=Report(), **arrays)
