"""Blender as a Python module: the BVH operator, with axes that do not change the file's numbers.

A joint becomes a bone, whose head is the joint and whose tail is the End Site. Blender gives a tail to every bone, so
tails are compared only with End Sites that the file has. A bone without a tip has a length of 0.1, and its tail has no
meaning.
"""

# Python finds the second import only after the first.
import bpy
import addon_utils

from answer import hand_back, index_of_frame, node

MADE_UP_LENGTH = 0.1


def read(file, frame, _root):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon_utils.enable("io_anim_bvh")
    result = bpy.ops.import_anim.bvh(
        filepath=file,
        axis_forward="Y",
        axis_up="Z",
        frame_start=1,
        use_fps_scale=False,
        update_scene_fps=True,
        update_scene_duration=True,
    )
    if result != {"FINISHED"}:
        raise RuntimeError("the operator was cancelled")

    scene = bpy.context.scene
    armature = next(item for item in scene.objects if item.type == "ARMATURE")
    action = armature.animation_data.action if armature.animation_data else None
    curves = action.fcurves if action and hasattr(action, "fcurves") else curves_of_layers(action)
    frames = max((len(curve.keyframe_points) for curve in curves), default=0)
    if frames:
        scene.frame_set(1 + index_of_frame(frame, frames))
    bpy.context.view_layer.update()

    nodes = []
    index = {}
    for bone in armature.pose.bones:
        index[bone.name] = len(nodes)
        parent = index[bone.parent.name] if bone.parent else None
        nodes.append(node(bone.name, parent, armature.matrix_world @ bone.head))
        if abs(bone.bone.length - MADE_UP_LENGTH) < 1e-6:
            continue
        tail = armature.matrix_world @ bone.tail
        nodes.append(node("tail", index[bone.name], tail, end=True, optional=True))
    return frames, scene.render.fps / scene.render.fps_base, nodes


def curves_of_layers(action):
    """The curves of an action that keeps them in layers, as actions do since Blender 5.0."""
    if action is None:
        return []
    bags = (bag for layer in action.layers for strip in layer.strips for bag in strip.channelbags)
    return [curve for bag in bags for curve in bag.fcurves]


hand_back(read)
