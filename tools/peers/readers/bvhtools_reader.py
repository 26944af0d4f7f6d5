"""bvhTools: `readBvh` and `getFKAtFrame`, which gives every joint and End Site by its name."""

import contextlib
import io

from bvhTools.bvhIO import readBvh

from answer import hand_back, index_of_frame, node, said


def read(file, frame, _root):
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        bvh = readBvh(file)
    said.extend(line for line in printed.getvalue().splitlines() if "WARNING" in line)
    frames = bvh.motion.numFrames
    pose = bvh.getFKAtFrame(index_of_frame(frame, frames)) if frames else None
    nodes = []

    def visit(joint, parent, origin):
        # Without frames, bvhTools gives no pose; the OFFSETs give the rest pose.
        place = pose[joint.name][1] if pose else [a + b for a, b in zip(origin, joint.offset)]
        index = len(nodes)
        # The pose has one entry per name. If two nodes have the same name, it is the entry of the later node.
        if bvh.skeleton.getJoint(joint.name) is not joint:
            return
        nodes.append(node(joint.name, parent, place, end=joint.name.endswith("_EndSite")))
        for child in joint.children:
            visit(child, index, place)

    visit(bvh.skeleton.root, None, [0.0, 0.0, 0.0])
    return frames, 1 / bvh.motion.frameTime if bvh.motion.frameTime else None, nodes


hand_back(read)
