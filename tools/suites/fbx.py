"""Prints the nodes of an FBX file over time, read by ufbx: seconds, then names and paths.

This script is a separate process, because ufbx's Python module frees scenes in an order that crashes the garbage
collector."""

import gc
import json
import os
import sys

import numpy as np
import ufbx

# Poses of an animation.
TIMES = 40


def main(path):
    gc.disable()
    scene = ufbx.load_file(
        path,
        target_axes=ufbx.axes_right_handed_y_up,
        target_unit_meters=1,
        space_conversion=ufbx.SpaceConversion.MODIFY_GEOMETRY,
    )
    times, anim = [0.0], scene.anim
    if len(scene.anim_stacks):
        anim = scene.anim_stacks[0].anim
        times = np.linspace(anim.time_begin, anim.time_end, TIMES + 1)
    held = [scene.evaluate(anim, float(time)) for time in times]
    nodes = [[[node.name, [*node.node_to_world.c3]] for node in posed.nodes if not node.is_root] for posed in held]
    paths = [[name, [frame[index][1] for frame in nodes]] for index, (name, _) in enumerate(nodes[0])]
    print(json.dumps([times[-1] - times[0], paths]), flush=True)
    os._exit(0)


main(sys.argv[1])
