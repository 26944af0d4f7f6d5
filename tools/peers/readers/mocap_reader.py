"""`mocap`, through its command line: `mocap info` gives the number of frames, `mocap pose --world` the nodes.

    MOCAP=PROGRAM python3 mocap_reader.py FILE last|FRAME replace|add OUT
"""

import json
import os

from answer import hand_back, index_of_frame, node, output_of


def mocap(*arguments):
    return json.loads(output_of(os.environ["MOCAP"], *arguments, "--json"))


def read(file, frame, _root):
    info = mocap("info", file)
    frames = info["frames"]
    tick = max(index_of_frame(frame, frames), 0)
    nodes = []
    # The output gives a parent by name. If names are equal, the parent is the last node with this name before the
    # child, because nodes are depth-first.
    index = {}
    for item in mocap("pose", file, "--tick", str(tick), "--world")["nodes"]:
        # This output does not distinguish End Sites from joints, hence `None`.
        nodes.append(node(item["name"], index.get(item["parent"]), item["translation"], end=None))
        index[item["name"]] = len(nodes) - 1
    return frames, info["ticks_per_second"], nodes


hand_back(read)
