"""Checks inverse kinematics in Python by lengths, goals and matrices."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mocap
from mocap import ik

ARM = ["LeftArm", "LeftForeArm", "LeftHand"]


def rotated(quaternion: np.ndarray, vector: np.ndarray) -> np.ndarray:
    axis, w = quaternion[:3].astype(float), float(quaternion[3])
    return vector + 2 * np.cross(axis, np.cross(axis, vector) + w * vector)


def test_two_bones_reach_their_goal() -> None:
    joints = np.array([[0, 1, 0], [0, 0.5, 0.1], [0, 0, 0]])
    for goal in ([0.2, 0.3, 0.0], [0.1, 0.4, -0.3], [0.0, 0.5, 0.5]):
        found = ik.two_bone(joints, goal)
        middle = joints[0] + rotated(found.upper, joints[1] - joints[0])
        end = middle + rotated(found.lower, joints[2] - joints[1])
        np.testing.assert_allclose(end, goal, atol=1e-5)
        np.testing.assert_allclose([found.middle, found.end], [middle, end], atol=1e-5)
        assert found.distance < 1e-5
    far = ik.two_bone(joints, [0, 10, 0])
    lengths = np.linalg.norm(np.diff(joints, axis=0), axis=1).sum()
    assert far.distance == pytest.approx(9 - lengths, abs=1e-4)
    bent = ik.two_bone(joints, [0, 0.3, 0], pole=[5, 0.5, 0])
    assert bent.middle[0] > 0.1 and abs(bent.middle[2]) < 1e-4


def test_a_chain_keeps_its_lengths() -> None:
    tail = np.array([[x, 0, 0] for x in range(5)], float)
    found = ik.chain(tail, [1, 2, 1])
    np.testing.assert_allclose(found.positions[-1], [1, 2, 1], atol=1e-3)
    np.testing.assert_allclose(np.linalg.norm(np.diff(found.positions, axis=0), axis=1), 1, atol=1e-4)
    np.testing.assert_array_equal(found.positions[0], tail[0])


def test_a_limb_of_a_scene_reaches_its_goal(walk: Path) -> None:
    scene = mocap.edit.prepare(mocap.read(walk))
    names = [node.name for node in scene.nodes]
    hand = names.index("LeftHand")
    before = scene.pose(30)
    goal = before[hand, :3, 3] + [0.05, 0.1, 0.05]
    found = ik.bend(scene, 30, ARM, goal, rotation=[0, 0, 0, 1])
    assert found.distance < 1e-4
    np.testing.assert_allclose(found.matrices[hand, :3, 3], goal, atol=1e-4)
    np.testing.assert_allclose(found.matrices[hand, :3, :3], np.eye(3), atol=1e-4)
    # Nodes that are not below the shoulder do not move.
    below = {index for index in range(len(names)) if names.index("LeftArm") in ancestors(scene, index)}
    for index in set(range(len(names))) - below:
        np.testing.assert_array_equal(found.matrices[index], before[index])
    local = ik.bend(scene, 30, ARM, goal, space="local").matrices
    chained: list[np.ndarray] = []
    for matrix, node in zip(local.astype(float), scene.nodes):
        chained.append(matrix if node.parent is None else chained[node.parent] @ matrix)
    np.testing.assert_allclose(chained[hand][:3, 3], goal, atol=1e-4)
    longer = ik.bend(scene, 30, ["LeftShoulder", *ARM], goal)
    assert longer.distance < 1e-3


def ancestors(scene: mocap.Scene, index: int) -> list[int]:
    above = [index]
    while (parent := scene.nodes[above[-1]].parent) is not None:
        above.append(parent)
    return above


def test_what_is_no_chain_is_refused(walk: Path) -> None:
    scene = mocap.read(walk)
    for joints, goal, message in [
        (["LeftHand", "LeftArm"], [0, 0, 0], '"LeftHand" is not an ancestor of "LeftArm"'),
        (["LeftArm"], [0, 0, 0], "a chain has at least two joints, got 1"),
        (["LeftArm", "Tail"], [0, 0, 0], "no joint is called 'Tail'"),
        ([0, 9999], [0, 0, 0], "there is no node 9999"),
        (ARM, [0, float("nan"), 0], "goal must be 3 finite numbers"),
    ]:
        with pytest.raises(mocap.OptionError, match=message):
            ik.bend(scene, 0, joints, goal)
    with pytest.raises(mocap.OptionError, match="pole needs three joints, got 2"):
        ik.bend(scene, 0, ARM[:2], [0, 0, 0], pole=[0, 0, 0])
