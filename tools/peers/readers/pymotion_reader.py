"""PyMotion: `BVH.load` and `fk`, as its README computes world positions.

Its `fk` accepts offsets of one frame, so this script passes the local positions: the OFFSETs for joints without
position channels, and the file's positions for the others. `fk` omits the End Sites, so the script adds each to its
joint.
"""

import numpy as np
from pymotion.io.bvh import BVH
from pymotion.ops.skeleton import fk

from answer import hand_back, index_of_frame, node


def read(file, frame, _root):
    bvh = BVH()
    bvh.load(file)
    rotations, positions, parents, offsets, end_sites, end_site_parents = bvh.get_data()
    frames = len(positions)
    if frames:
        at = index_of_frame(frame, frames)
        local_rotations, local_positions = rotations[at], positions[at]
    else:
        local_rotations, local_positions = np.tile([1.0, 0.0, 0.0, 0.0], (len(offsets), 1)), offsets
    places, turns = fk(local_rotations, local_positions[0], local_positions, parents)

    names = bvh.data["names"]
    nodes = [
        node(name, None if index == 0 else int(parents[index]), places[index]) for index, name in enumerate(names)
    ]
    for offset, parent in zip(end_sites, end_site_parents):
        nodes.append(node("End Site", int(parent), places[parent] + turns[parent] @ offset, end=True))
    frame_time = bvh.data["frame_time"]
    return frames, 1 / frame_time if frame_time else None, nodes


hand_back(read)
