"""NumPy in, scene out, NumPy out."""

import numpy as np
import pytest

import mocap


def motion():
    """A chain of three joints that bends about Z."""
    angles = np.linspace(0, 1, 10)
    zero, one = np.zeros_like(angles), np.ones_like(angles)
    bend = np.stack([np.stack([np.cos(angles), -np.sin(angles), zero], -1),
                     np.stack([np.sin(angles), np.cos(angles), zero], -1), np.stack([zero, zero, one], -1)], -2)
    rotations = np.stack([bend, bend, np.broadcast_to(np.eye(3), bend.shape)], 1)
    root = np.stack([angles, one, zero], -1)
    elbow = root + bend @ [0, 0.5, 0]
    return np.stack([root, elbow, elbow + bend @ bend @ [0, 0.25, 0]], 1), rotations


def test_arrays_come_back():
    positions, rotations = motion()
    scene = mocap.from_arrays(positions=positions, rotations=rotations, names=["a", "b", "c"], parents=[-1, 0, 1], frame_rate=50)
    back = scene.to_numpy(rot="matrix")
    assert np.abs(back.positions - positions).max() < 1e-6
    assert np.abs(back.rotations.reshape(rotations.shape) - rotations).max() < 1e-6


def test_shapes_that_do_not_go_together_are_refused():
    positions, rotations = motion()
    for wrong in ({"positions": positions[0]}, {"positions": positions, "names": ["a"]},
                  {"positions": positions, "rotations": rotations},
                  {"positions": positions, "rotations": rotations[:5], "parents": [-1, 0, 1]},
                  {"positions": positions, "rotations": rotations, "parents": [1, -1, 1]}):
        with pytest.raises(ValueError, match="must"):
            mocap.from_arrays(**wrong)
