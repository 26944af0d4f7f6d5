"""Motions on robots: arrays that are those of the program, within the limits of the robot's file."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

import mocap

FIXTURES = Path(__file__).resolve().parents[3] / "fixtures"
ROBOT = FIXTURES / "robots" / "h1.urdf"


def test_a_walk_is_put_on_a_robot_within_its_limits() -> None:
    robot = mocap.Robot(ROBOT)
    motion = robot.retarget(mocap.read(FIXTURES / "real" / "cmu_12_01_walk.bvh"), fps=30)
    frames = len(motion.qpos)
    assert motion.fps == 30
    assert motion.dof_pos.shape == (frames, 19) and motion.contacts.shape == (frames, 2)
    np.testing.assert_array_equal(motion.qpos[:, :3], motion.root_pos)
    np.testing.assert_array_equal(motion.qpos[:, 3:7], motion.root_rot[:, [3, 0, 1, 2]])
    np.testing.assert_array_equal(motion.qpos[:, 7:], motion.dof_pos)
    limits = {joint.get("name"): joint.find("limit") for joint in ET.parse(ROBOT).getroot().findall("joint")}
    for name, values in zip(motion.dof_names, motion.dof_pos.T):
        limit = limits[name]
        assert limit is not None
        assert values.min() >= float(limit.get("lower", "nan")) and values.max() <= float(limit.get("upper", "nan"))
    assert motion.report["limit_violations"] == 0


def test_two_passes_are_smoother_than_one() -> None:
    robot, walk = mocap.Robot(ROBOT), mocap.read(FIXTURES / "real" / "cmu_12_01_walk.bvh")
    one, two = (np.diff(robot.retarget(walk, passes=passes).dof_pos, 2, axis=0) for passes in (1, 2))
    assert np.percentile(np.abs(two), 99) < 0.5 * np.percentile(np.abs(one), 99)
    with pytest.raises(ValueError, match="1 or 2, got 3"):
        robot.retarget(walk, passes=3)  # type: ignore[arg-type]


def test_what_is_no_humanoid_is_refused() -> None:
    with pytest.raises(mocap.MocapError, match="not a humanoid"):
        mocap.Robot(ROBOT).retarget(mocap.read(FIXTURES / "real" / "lecture_Test.bvh"))
    with pytest.raises(mocap.MocapError, match="not a robot"):
        mocap.Robot(FIXTURES / "real" / "lecture_Test.bvh")
