"""bvh_anim, through the program of `bvh_anim/`. bvh_anim only parses numbers, so this script computes the poses.

    BVH_ANIM_DUMP=PROGRAM python3 bvh_anim_reader.py FILE last|FRAME replace|add OUT

The kinematics are those of the expected result, whose rule for the root's OFFSET is an argument. So the positions are
right if the names, the channels and the values are the file's.
"""

import json
import os

import kinematics
from answer import hand_back, node, output_of


def local(joint, motion, adds):
    place = list(joint["offset"])
    turn = kinematics.IDENTITY
    for channel, index in joint["channels"]:
        value = motion[index]
        axis = "XYZ".index(channel[0])
        if channel.endswith("position"):
            place[axis] = value + (joint["offset"][axis] if adds else 0.0)
        else:
            turn = kinematics.product(turn, kinematics.rotation_about(axis, value))
    return kinematics.product(kinematics.translation(place), turn)


def read(file, frame, root):
    bvh = json.loads(output_of(os.environ["BVH_ANIM_DUMP"], file, frame))
    # JSON has no NaN: it is written as null.
    motion = [float("nan") if value is None else value for value in bvh["values"]]

    nodes = []
    worlds = []
    index = []
    for joint in bvh["joints"]:
        parent = joint["parent"]
        matrix = local(joint, motion, adds=root == "add" and parent is None)
        world = matrix if parent is None else kinematics.product(worlds[parent], matrix)
        worlds.append(world)
        index.append(len(nodes))
        nodes.append(node(joint["name"], None if parent is None else index[parent], kinematics.position(world)))
        if joint["end_site"] is not None:
            tip = kinematics.product(world, kinematics.translation(joint["end_site"]))
            nodes.append(node("End Site", index[-1], kinematics.position(tip), end=True))
    return bvh["frames"], bvh["rate"], nodes


hand_back(read)
