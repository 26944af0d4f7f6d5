"""NumPy in, scene out, NumPy out."""

import numpy as np
import pytest

import mocap

from conftest import REAL

ARRAYS = REAL.parent / "arrays"


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


def test_outputs_of_an_estimator_become_a_take():
    with np.load(ARRAYS / "sam3d_body.npz") as file:
        frame = dict(file)
    take = mocap.from_arrays([frame | {"mask": None}] * 3, frame_rate=25)
    assert take.frame_rate == 25 and len(take.to_numpy().positions) == 3
    assert mocap.from_arrays(frame).to_numpy().positions.shape[0] == 1
    with pytest.raises(ValueError, match="either arrays or positions"):
        mocap.from_arrays()


def test_persons_of_an_estimator_are_told_apart():
    with np.load(ARRAYS / "sam3d_body.npz") as file:
        frame = dict(file)
    at = lambda x, z: frame | {"pred_cam_t": np.array([x, 0.0, z]), "mask": None}
    frames = [[at(-1 + 0.4 * i, 5), at(1 - 0.4 * i, 5.7)][:: 1 if i % 2 else -1] for i in range(6)]
    frames[2] = frames[2][1:]  # only the first person
    frames[4] = []
    for person, way in ((None, 0.4), (0, -0.4)):
        take = mocap.from_arrays(frames, frame_rate=25, person=person)
        assert np.allclose(np.diff(take.to_numpy().positions[:, 0, 0]), way, atol=1e-3)
    with pytest.raises(mocap.MocapError, match="does not have this clip"):
        mocap.from_arrays(frames, frame_rate=25, person=2)


def test_a_folder_of_frames_is_read(tmp_path):
    for index in range(3):
        (tmp_path / f"frame_{index}.npz").write_bytes((ARRAYS / "sam3d_body.npz").read_bytes())
    assert mocap.read(tmp_path, retime=30).frames == 3


def test_shapes_that_do_not_go_together_are_refused():
    positions, rotations = motion()
    for wrong in ({"positions": positions[0]}, {"positions": positions, "names": ["a"]},
                  {"positions": positions, "rotations": rotations},
                  {"positions": positions, "rotations": rotations[:5], "parents": [-1, 0, 1]},
                  {"positions": positions, "rotations": rotations, "parents": [1, -1, 1]}):
        with pytest.raises(ValueError, match="must"):
            mocap.from_arrays(**wrong)


def test_a_body_comes_back_from_smpl(tmp_path):
    scene = mocap.read(REAL / "cmu_short.bvh")
    arrays = scene.to_smpl()
    assert arrays["body_pose"].shape == (75, 63) and arrays["transl"].shape == (75, 3)
    np.savez(tmp_path / "take.npz", **arrays)
    back = mocap.read(tmp_path / "take.npz")
    assert [node.name for node in back.nodes][0] == "pelvis" and back.frames == 75
    # The position of the pelvis follows from the translation and the rest joints.
    assert np.abs(back.pose(0)[0, :3, 3] - (arrays["transl"][0] + arrays["rest_joints"][0])).max() < 1e-5
    assert scene.to_smpl("humanml3d")["vectors"].shape[1] == 263
    with pytest.raises(mocap.MocapError, match="layout must be 'smplx', 'amass', 'kimodo', 'soma', 'mhr' or 'humanml3d', got 'mocap'"):
        scene.to_smpl("mocap")


def test_a_body_is_named_in_reading():
    folder = REAL.parent / "arrays"
    tall = mocap.read(folder / "shaped_smplh.npz", body=folder / "body_smplh.npz")
    generic = mocap.read(folder / "shaped_smplh.npz")
    assert tall.nodes[1].offset != generic.nodes[1].offset
