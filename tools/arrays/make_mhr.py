"""Writes the fixtures of SAM 3D Body: `make_mhr.py OUTPUT.npz`. OUTPUT.npz has one person; only the arrays of a motion
remain.

`sam3d_take.npz` is a take of five frames made from OUTPUT.npz, whose camera looks down. `expected_mhr.json` has the
joints that NumPy finds in both, by joint, in metres and the axes of the root: X left, Y up, Z forward.
`expected_soles.json` has the upward directions of the left and the right sole in the same axes: the normal of the
largest flat face below the vertices of a foot.

`sam3d_keypoints.npz` has only the keypoints. `sam3d_persons.npz` has lists of persons as compressed objects with 16-bit
numbers; two persons walk past each other. `sam3d_stack.npz` has the same persons along a first axis, and zeros in place
of a missing person.
"""
import json, pathlib, sys
import numpy as np
from scipy.spatial import ConvexHull

OUT = pathlib.Path(__file__).resolve().parents[2] / "fixtures" / "arrays"
NAMES = "pred_joint_coords pred_global_rots pred_keypoints_3d pred_cam_t".split()
# The axes of the camera (right, down, forward), and the axes of the rotations (right, up, back).
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


def soles(source):
    """The upward directions of the left and the right sole, in the axes of the root."""
    joints, turns = (source[name].astype(float) for name in NAMES[:2])
    points = source["pred_vertices"].astype(float)
    nearest = np.array([np.linalg.norm(joints - point, axis=1).argmin() for point in points])
    found = []
    for leg in (2, 18):  # l_upleg, r_upleg: then the shin, the foot and four more joints to the ball
        foot = points[np.isin(nearest, range(leg + 2, leg + 7))] * FLIP
        shin = (joints[leg + 1] - joints[leg + 2]) * FLIP
        hull = ConvexHull(foot)
        corners = foot[hull.simplices]
        areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        normals = hull.equations[:, :3]
        near = (normals @ normals.T > np.cos(np.radians(10))) * areas
        best = np.where(normals @ shin < -0.3 * np.linalg.norm(shin), near.sum(axis=1), 0).argmax()
        up = -near[best] @ normals
        found.append((up / np.linalg.norm(up)) @ turns[ROOT])
    return found


def persons(frame):
    """Two persons who walk past each other, in lists of changing order. One frame lacks the second person, and one
    lacks both."""
    frames = []
    for index in range(8):
        ways = [(-1.4 + 0.4 * index, 0, 5), (1.4 - 0.4 * index, 0, 5.7)]
        both = [
            {name: frame[name].astype(np.float16) for name in NAMES[:2]} | {"pred_cam_t": np.array(way, np.float16), "mask": None}
            for way in ways
        ]
        frames.append([] if index == 6 else both[:1] if index == 2 else both[:: 1 if index % 2 else -1])
    lists = np.empty(len(frames), object)
    lists[:] = frames
    np.savez_compressed(OUT / "sam3d_persons.npz", outputs=lists, fps=25)
    nobody = {name: np.zeros_like(frame[name]) for name in (*NAMES[:2], NAMES[3])}
    at = lambda people, left: next((p for p in people if (p["pred_cam_t"][2] < 5.5) == left), nobody)
    rows = {n: np.array([[at(people, left)[n] for people in frames] for left in (True, False)], np.float16) for n in nobody}
    np.savez_compressed(OUT / "sam3d_stack.npz", **rows)


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
    persons(frame)
    np.savez_compressed(OUT / "sam3d_keypoints.npz", **{name: frame[name] for name in NAMES[2:]})
    (OUT / "expected_soles.json").write_text(json.dumps(np.round(soles(source), 4).tolist()) + "\n")
    places = in_root(coords, rotations)
    (OUT / "expected_mhr.json").write_text(json.dumps(np.round(places, 5).tolist()) + "\n")


main()
