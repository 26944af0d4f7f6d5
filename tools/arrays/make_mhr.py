"""Writes the fixtures of SAM 3D Body: `make_mhr.py OUTPUT.npz`, an output of one person, cut to what a motion needs.

`sam3d_take.npz` is a take of five frames planted from it, whose camera looks down. `expected_mhr.json` has the joints
that NumPy finds in both, by joint, in metres and the axes of the root: X left, Y up, Z forward.
"""
import json, pathlib, sys
import numpy as np

OUT = pathlib.Path(__file__).resolve().parents[2] / "fixtures" / "arrays"
NAMES = "pred_joint_coords pred_global_rots pred_keypoints_3d pred_cam_t".split()
# The camera's axes (right, down, forward) and those of the rotations (right, up, back).
FLIP = np.array([1.0, -1.0, -1.0])
ROOT = 1


def in_root(coords, rotations):
    """Joints from the root, in its axes."""
    return ((coords - coords[ROOT]) * FLIP) @ rotations[ROOT]


def about(axis, degrees):
    x, y, z = axis
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.radians(degrees)
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def main():
    source = np.load(sys.argv[1])
    frame = {name: source[name].astype(np.float32) for name in NAMES}
    np.savez_compressed(OUT / "sam3d_body.npz", **frame)
    coords, rotations = (frame[name].astype(float) for name in NAMES[:2])
    take = []
    for index, scale in enumerate((1.0, 1.03, 1.0, 0.96, 1.0)):
        turn = about((1, 0, 0), 20) @ about((0, 1, 0), 15 * index)  # +Y up
        flipped = (coords - coords[ROOT]) * FLIP @ turn.T * FLIP * scale
        camera = (np.array([0.2 * index, 0.3, 6.0])) * scale
        take.append((flipped + coords[ROOT], turn @ rotations, camera + (scale - 1) * coords[ROOT]))
    stacked = [np.array(arrays, np.float32) for arrays in zip(*take)]
    stacked[0][2, 5] = np.nan
    np.savez_compressed(OUT / "sam3d_take.npz", **dict(zip(("pred_joint_coords", "pred_global_rots", "pred_cam_t"), stacked)))
    places = in_root(coords, rotations)
    (OUT / "expected_mhr.json").write_text(json.dumps(np.round(places, 5).tolist()) + "\n")


main()
