"""`mocap`, through its own command line: `mocap info` for the count of frames, `mocap pose --world` for the nodes.

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
    # A parent is given by name: where names are equal it is the last one before, as nodes stand depth-first.
    index = {}
    for item in mocap("pose", file, "--tick", str(tick), "--world")["nodes"]:
        # An End Site is a node like others here, which `None` says.
        nodes.append(node(item["name"], index.get(item["parent"]), item["translation"], end=None))
        index[item["name"]] = len(nodes) - 1
    return frames, info["ticks_per_second"], nodes


hand_back(read)
