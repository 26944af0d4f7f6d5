"""bvhio: `readAsBvh` for the End Sites and the count of frames, its transform hierarchy for the pose.

The hierarchy gives every joint a rest rotation of its own and has no End Sites. The End Site hangs from the joint's
turn since the rest pose, which is what the file means by a rotation.
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
        # Where the file has no End Site there is a made-up one of length one; a leaf cannot be told apart.
        turn = joint.RotationWorld * glm.inverse(rest_rotation)
        tip = joint.PositionWorld + turn * source.EndSite
        nodes.append(node("End Site", index, tip, end=True, optional=True))
    return frames, 1 / bvh.FrameTime if bvh.FrameTime else None, nodes


hand_back(read)
