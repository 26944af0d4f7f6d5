"""Compares joint angles and gait with angles that NumPy computes from positions."""

import numpy as np
import pytest

import mocap

from conftest import REAL


def test_knees_bend_as_positions_say():
    scene = mocap.read(REAL / "cmu_12_01_walk.bvh")
    angles = scene.joint_angles()
    motion = scene.to_numpy()
    at = {name: motion.positions[:, index] for index, name in enumerate(motion.names)}
    thigh, shin = at["RightLeg"] - at["RightUpLeg"], at["RightFoot"] - at["RightLeg"]
    cosine = np.sum(thigh * shin, 1) / np.linalg.norm(thigh, axis=1) / np.linalg.norm(shin, axis=1)
    bent = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    # The first frame is a T-pose.
    assert np.abs(angles["knee_angle_r"] - bent)[1:].max() < 3.0
    assert angles["time"][120] == pytest.approx(1.0, abs=1e-4)


def test_a_walk_has_steps():
    gait = mocap.read(REAL / "cmu_12_01_walk.bvh").gait()
    assert 80 < gait["cadence"] < 110 and not gait["in_place"]
    assert len(gait["left"]["heel_strikes"]) == 3 and len(gait["right"]["toe_offs"]) == 3
    assert 55 < gait["left"]["stance"]["mean"] < 72


def test_what_is_no_walk_is_an_error():
    with pytest.raises(mocap.MocapError):
        mocap.read(REAL / "lecture_Test.bvh").joint_angles()


def test_forces_and_events_of_a_laboratory() -> None:
    scene = mocap.read(REAL / "py_c3d_motion.c3d")
    forces = scene.ground_forces()
    # The values of ezc3d at the same sample, minus the mean of the frames that FORCE_PLATFORM:ZERO names.
    assert forces["ground_force_1_vy"][1244] == pytest.approx(817.35, abs=0.01)
    assert scene.analog()["FX1"][0] == pytest.approx(-26.66)
    recorded = scene.recorded
    assert recorded is not None and [event["label"] for event in recorded["events"]] == ["RIC", "RHS", "RTO"]
    assert mocap.read(REAL / "cmu_short.bvh").recorded is None
