"""Compares BVH with pybvh, in the unit and the axes of the file."""

import numpy as np
import pybvh

from motion import Motion, Refused, unique
from packages import crate, debian, wheel
from packages import files as found

# Options for the properties that a BVH file does not state; they keep its numbers.
OPTIONS = ["--unit", "m", "--up", "y"]
# The largest number of compared frames.
FRAMES = 200


def files(_everything):
    places = [debian("assimp-testmodels"), wheel("kagra", "0.1.4"), crate("bvh_anim", "0.4.0")]
    for place in places:
        for path in found(place, ".bvh"):
            yield path, motion, motion


def motion(path):
    try:
        read = pybvh.read_bvh_file(str(path))
        places = read.node_positions()
    except Exception as error:  # pybvh has no error of its own.
        raise Refused(repr(error)) from error
    joints = [(index, node.name) for index, node in enumerate(read.nodes) if not node.is_end_site()]
    frames = np.unique(np.linspace(0, len(places) - 1, FRAMES).round().astype(int))
    paths = unique([(name, places[frames, index]) for index, name in joints])
    # pybvh reads 0.0083333 as 1/120.
    stated = next(line for line in path.read_text(errors="replace").splitlines() if line.startswith("Frame Time:"))
    frame_time = float(stated.split(":")[1])
    return Motion((len(places) - 1) * frame_time, paths, frames * frame_time)
