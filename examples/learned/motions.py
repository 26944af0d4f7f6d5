"""The walks that the network learns from: clips of fixtures/ on one body, mirrored, and bent along arcs."""

import pathlib

import mocap
import numpy as np
from mocap import edit

FIXTURES = pathlib.Path(__file__).resolve().parents[2] / "fixtures"
BODY = FIXTURES / "real/cmu_12_01_walk.bvh"
# Each clip from second to second, without its first and last step from and to rest.
CLIPS = {
    "real/cmu_12_01_walk.bvh": (0.0, 4.3),
    "real/cmu_02_01.amc": (0.0, 2.8),
    "skeletons/bvhtoolbox_walk01.bvh": (0.5, 4.1),
    "real/motionbuilder_vicon_walk.bvh": (0.3, 8.8),
}
# Curvatures of the arcs along which a straight walk is bent, in 1/m, to the left; mirrored clips go to the right.
CURVATURES = (-1.2, -0.7, -0.35, 0.0, 0.35, 0.7, 1.2)
# A clip whose ends are nearer to each other than this part of its length is no straight walk.
STRAIGHT = 0.9
# Points of an arc.
ARC_POINTS = 9


def bent(scene):
    """The scene, and where it is a straight walk, also the scene along each arc."""
    hips = scene.to_numpy(fps=30).positions[:, 0][:, [0, 2]]
    length = np.linalg.norm(np.diff(hips[::10], axis=0), axis=1).sum()
    if np.linalg.norm(hips[-1] - hips[0]) < STRAIGHT * length:
        return [scene]
    found = []
    for curvature in CURVATURES:
        along = np.linspace(0, length, ARC_POINTS)
        angle = curvature * along
        x = (1 - np.cos(angle)) / curvature if curvature else 0 * along
        z = np.sin(angle) / curvature if curvature else along
        found.append(edit.warp_path(scene, list(zip(x.tolist(), z.tolist())))[0])
    return found


def scenes():
    """All motions, in metres with +Y up, on the skeleton of BODY."""
    for path, (first, last) in CLIPS.items():
        scene = edit.prepare(mocap.retarget(FIXTURES / path, BODY)[0])
        for part in bent(edit.trim(scene, first, last)[0]):
            part = edit.foot_lock(edit.ground(part)[0])[0]
            yield part
            yield edit.mirror(part)[0]


def write(folder):
    """Writes the motions as packed clips, which motion matching and the motion graph are given."""
    pathlib.Path(folder).mkdir(parents=True, exist_ok=True)
    paths = []
    for number, scene in enumerate(scenes()):
        paths.append(pathlib.Path(folder) / f"walk{number:02}.mclip")
        edit.write(edit.resample(scene, rate=60)[0], paths[-1])
    return paths
