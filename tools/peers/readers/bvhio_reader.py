"""bvhio: `readAsBvh` gives the End Sites and the number of frames, and the transform hierarchy gives the pose.

The hierarchy gives every joint its own rest rotation and has no End Sites. So the End Site follows the joint's rotation
relative to the rest pose, which is the rotation in the file.
"""

import bvhio
import glm

from answer import hand_back, index_of_frame, node


def read(file, frame, _root):
    bvh = bvhio.readAsBvh(file)
    root = bvhio.convertBvhToHierarchy(bvh.Root)
    frames = bvh.FrameCount
    root.loadRestPose(recursive=True)
    rest = [joint.RotationWorld for joint, _, _ in root.layout()]
    if frames:
        root.loadPose(index_of_frame(frame, frames), recursive=True)

    nodes = []
    parents = []
    layout = zip(root.layout(), bvh.Root.layout(), rest)
    for (joint, _, depth), (source, _, _), rest_rotation in layout:
        del parents[depth:]
        index = len(nodes)
        nodes.append(node(joint.Name, parents[-1] if parents else None, joint.PositionWorld))
        parents.append(index)
        # Without an End Site in the file, bvhio invents one of length 1, which cannot be distinguished from a real one.
        turn = joint.RotationWorld * glm.inverse(rest_rotation)
        tip = joint.PositionWorld + turn * source.EndSite
        nodes.append(node("End Site", index, tip, end=True, optional=True))
    return frames, 1 / bvh.FrameTime if bvh.FrameTime else None, nodes


hand_back(read)
