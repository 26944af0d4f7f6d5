"""Assimp, through the dump program of `tools/oracle`: its nodes and keys, evaluated at a tick as Assimp documents them.

    ASSIMP_DUMP=PROGRAM python3 assimp_reader.py FILE last|FRAME replace|add OUT
"""

import json
import os

import kinematics
from answer import hand_back, index_of_frame, node, output_of


def key_at(keys, tick):
    """The values of the last key that is not after the tick."""
    return next((key[1:] for key in reversed(keys) if float(key[0]) <= tick), keys[0][1:])


def values(key):
    """Numbers that JSON cannot represent are words in the dump."""
    return [float(value) for value in key]


def local(scene_node, channel, tick):
    if channel is None:
        cells = values(scene_node["matrix"])
        return [cells[row * 4 : row * 4 + 4] for row in range(4)]
    move = kinematics.translation(values(key_at(channel["pos"], tick)))
    turn = kinematics.rotation(*values(key_at(channel["rot_wxyz"], tick)))
    stretch = kinematics.scaling(values(key_at(channel["scl"], tick)))
    return kinematics.product(kinematics.product(move, turn), stretch)


def read(file, frame, _root):
    scene = json.loads(output_of(os.environ["ASSIMP_DUMP"], file, "none", "json"))
    if "error" in scene:
        raise SystemExit(scene["error"])

    animation = scene["animations"][0] if scene["animations"] else None
    # The duration is the tick of the last key.
    frames = round(float(animation["duration"])) + 1 if animation else 0
    tick = index_of_frame(frame, frames)
    channels = {channel["node"]: channel for channel in animation["channels"]} if animation else {}

    nodes = []
    worlds = []
    # Nodes are depth-first with their number of children: the parent is the last node that still lacks a child.
    open_nodes = []
    for scene_node in scene["nodes"]:
        parent = open_nodes[-1][0] if open_nodes else None
        matrix = local(scene_node, channels.get(scene_node["name"]), tick)
        world = matrix if parent is None else kinematics.product(worlds[parent], matrix)
        end = scene_node["name"].startswith("EndSite_")
        nodes.append(node(scene_node["name"], parent, kinematics.position(world), end=end))
        worlds.append(world)
        if open_nodes:
            open_nodes[-1][1] -= 1
        open_nodes.append([len(nodes) - 1, scene_node["nchild"]])
        while open_nodes and open_nodes[-1][1] == 0:
            open_nodes.pop()
    return frames, float(animation["ticks_per_second"]) if animation else None, nodes


hand_back(read)
