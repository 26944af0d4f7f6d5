"""Tests motions on robots: the arrays equal the program's, and stay within the limits of the robot's file."""

from __future__ import annotations

import pickle
import re
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


def test_a_slow_robot_gets_a_slower_motion(tmp_path: Path) -> None:
    slow = tmp_path / "slow.urdf"
    text = ROBOT.read_text()
    limits = {float(value) for value in re.findall(r'velocity="([^"]+)"', text)}
    slow.write_text(re.sub(r'velocity="[^"]+"', 'velocity="1.5"', text))
    assert min(limits) > 1.5
    walk = FIXTURES / "real" / "cmu_12_01_walk.bvh"
    motion = mocap.Robot(slow).retarget(walk, fps=30, time_scale="auto")
    # Equal except for the rounding of the product.
    assert np.abs(np.diff(motion.dof_pos, axis=0)).max() * 30 <= 1.5 * (1 + 1e-9)
    scale = motion.report["time_scale"]
    assert 0.1 < scale < 0.9 and motion.report["slowed_by"] in motion.dof_names
    half = mocap.Robot(ROBOT).retarget(walk, fps=30, time_scale=0.5)
    assert len(half.qpos) == 2 * len(mocap.Robot(ROBOT).retarget(walk, fps=30).qpos) - 1
    with pytest.raises(ValueError, match="time_scale: expected auto or a factor above 0, got 0"):
        mocap.Robot(ROBOT).retarget(walk, time_scale=0)


def test_a_motion_is_scored_against_its_reference(tmp_path: Path) -> None:
    robot, walk = mocap.Robot(ROBOT), FIXTURES / "real" / "cmu_short.bvh"
    motion = robot.retarget(walk, passes=1)
    motion.save(tmp_path / "walk.npz")
    found = robot.score(walk, tmp_path / "walk.npz")
    assert found["scores"]["mpbpe_local"] == pytest.approx(motion.report["scores"]["mpbpe_local"], rel=1e-4)
    as_scene = robot.score(mocap.read(walk), mocap.read(tmp_path / "walk.npz", body=ROBOT))
    assert as_scene == found
    with pytest.raises(ValueError, match="no arrays of a robot's joints"):
        robot.score(walk, mocap.read(walk))


def test_a_motion_is_saved_for_trainers(tmp_path: Path) -> None:
    robot, short = mocap.Robot(ROBOT), mocap.read(FIXTURES / "real" / "cmu_short.bvh")
    motion = robot.retarget(short, fps=50, passes=1)
    motion.save(tmp_path / "walk.npz")
    np.testing.assert_array_equal(np.load(tmp_path / "walk.npz")["dof_pos"], motion.dof_pos)
    motion.save(tmp_path / "mjlab.npz", "mjlab")
    mjlab = np.load(tmp_path / "mjlab.npz")
    assert {"fps", "joint_pos", "joint_vel", "body_pos_w", "body_quat_w", "body_lin_vel_w", "body_ang_vel_w"} <= set(mjlab.files)
    np.testing.assert_allclose(mjlab["joint_pos"], motion.dof_pos, atol=1e-6)
    motion.save(tmp_path / "gmr.pkl", "gmr")
    with pytest.raises(ValueError, match="readers of unitree-csv expect 30 frames per second, and the motion has 50"):
        motion.save(tmp_path / "walk.csv", "unitree-csv")
    with pytest.raises(ValueError, match="to must be one of npz, pkl, csv, qpos, gmr"):
        motion.save(tmp_path / "walk.txt")
    (tmp_path / "mine.npz").write_text("mine")
    with pytest.raises(mocap.MocapError, match="would replace"):
        motion.save(tmp_path / "mine.npz")
    motion.save(tmp_path / "mine.npz", overwrite=True)
    copy = pickle.loads(pickle.dumps(motion))
    np.testing.assert_array_equal(copy.dof_pos, motion.dof_pos)
    with pytest.raises(ValueError, match="in the process that made it"):
        copy.save(tmp_path / "copy.npz")


def test_a_map_says_which_link_is_which_bone() -> None:
    robot, short = mocap.Robot(ROBOT), mocap.read(FIXTURES / "real" / "cmu_short.bvh")
    plain = robot.retarget(short, passes=1)
    same = robot.retarget(short, passes=1, map={"leftFoot": "left_ankle_link"}, bones={"leftFoot": "LeftFoot"})
    np.testing.assert_array_equal(plain.dof_pos, same.dof_pos)
    other = robot.retarget(short, passes=1, map={"leftUpperArm": None, "leftLowerArm": None, "leftHand": None})
    assert not np.array_equal(plain.dof_pos, other.dof_pos)
    with pytest.raises(mocap.MocapError, match='no link is called "ankle"'):
        robot.retarget(short, map={"leftFoot": "ankle"})


def test_what_is_no_humanoid_is_refused() -> None:
    with pytest.raises(mocap.MocapError, match="not a humanoid"):
        mocap.Robot(ROBOT).retarget(mocap.read(FIXTURES / "real" / "lecture_Test.bvh"))
    with pytest.raises(mocap.MocapError, match="not a robot"):
        mocap.Robot(FIXTURES / "real" / "lecture_Test.bvh")


def test_a_motion_is_put_on_a_robot_while_it_comes() -> None:
    robot, walk = mocap.Robot(ROBOT), mocap.read(FIXTURES / "real" / "cmu_short.bvh")
    stream = robot.stream(walk, fps=30)
    assert abs(stream.delay - 0.6) < 1e-6 and stream.report is None
    count, frames = 50, []
    for tick in range(count):
        frame = stream.push(walk.pose(tick, space="local"))
        assert (frame is None) == (tick < 18)
        if frame is not None:
            assert frame.qpos.shape == (1, 26) and frame.report == {}
            frames.append(frame.dof_pos[0])
    left = stream.finish()
    assert len(left.qpos) == 18 and left.fps == 30
    positions = np.vstack([*frames, left.dof_pos])
    report = stream.report
    assert report is not None and (report["frames"], report["passes"]) == (count, 2)
    np.testing.assert_allclose(report["max_velocity"], np.abs(np.diff(positions, axis=0)).max() * 30)
    with pytest.raises(ValueError, match="Robot.retarget"):
        left.save("walk.npz")


def test_poses_that_are_none_are_refused() -> None:
    robot, walk = mocap.Robot(ROBOT), mocap.read(FIXTURES / "real" / "cmu_short.bvh")
    stream, pose = robot.stream(walk, passes=1), walk.pose(0, space="local")
    with pytest.raises(ValueError, match="shape"):
        stream.push(pose[1:])
    pose[3, 0, 0] = np.nan
    with pytest.raises(ValueError, match="not finite"):
        stream.push(pose)
    with pytest.raises(mocap.MocapError, match="from 1 to 1000"):
        robot.stream(walk, fps=0)


def test_weights_change_the_motion_and_wrong_ones_are_named() -> None:
    robot = mocap.Robot(ROBOT)
    walk = FIXTURES / "real" / "cmu_short.bvh"
    usual = robot.retarget(walk)
    other = robot.retarget(walk, weights={"robot": {"joint_smoothing": 1.0}})
    assert np.abs(usual.dof_pos - other.dof_pos).max() > 1e-3
    np.testing.assert_array_equal(usual.dof_pos, robot.retarget(walk, weights={"robot": {}}).dof_pos)
    with pytest.raises(mocap.OptionError, match="hnad: there is no hnad in weights.robot; known keys: "):
        robot.retarget(walk, weights={"robot": {"hnad": 1.0}})
    with pytest.raises(mocap.OptionError, match="the weight hand of robot must be from 0.0002 to 200, got 1000"):
        robot.retarget(walk, weights={"robot": {"hand": 1000.0}})
