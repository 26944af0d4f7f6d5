"""pybvh, as its quick start reads a file: `read_bvh_file`, then `node_positions`, which include the End Sites."""

import pybvh

from answer import hand_back, index_of_frame, node


def read(file, frame, _root):
    bvh = pybvh.read_bvh_file(file)
    frames = bvh.frame_count
    positions = bvh.node_positions(index_of_frame(frame, frames)) if frames else bvh.rest_pose_positions()
    index = {id(item): at for at, item in enumerate(bvh.nodes)}
    nodes = [
        node(item.name, None if item.is_root() else index[id(item.parent)], place, end=item.is_end_site())
        for item, place in zip(bvh.nodes, positions)
    ]
    return frames, 1 / bvh.frame_time if bvh.frame_time else None, nodes


hand_back(read)
