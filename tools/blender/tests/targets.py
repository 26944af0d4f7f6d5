"""Armatures that Blender itself makes or reads, with different rest poses, rolls, scales and axes."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import bpy
from conftest import FIXTURES
from mathutils import Euler, Matrix

SKELETONS = FIXTURES / "skeletons"
CHARACTERS = FIXTURES / "characters"


def read(path: Path) -> bpy.types.Object:
    """An armature of a file, by Blender's own importers, at rest and without an action."""
    before, actions = set(bpy.data.objects), set(bpy.data.actions)
    if path.suffix in (".glb", ".gltf", ".vrm"):
        bpy.ops.import_scene.gltf(filepath=str(path))
    elif path.suffix == ".fbx":
        bpy.ops.import_scene.fbx(filepath=str(path))
    else:
        bpy.ops.import_anim.bvh(filepath=str(path), global_scale=0.01, axis_up="Y", axis_forward="-Z")
    (armature,) = [one for one in bpy.data.objects if one not in before and one.type == "ARMATURE"]
    armature.animation_data_clear()
    for action in set(bpy.data.actions) - actions:
        bpy.data.actions.remove(action)
    for bone in armature.pose.bones:
        bone.matrix_basis = Matrix()
    activate(armature)
    return armature


def activate(armature: bpy.types.Object) -> None:
    if bpy.context.object is not None and bpy.context.object.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    for other in bpy.context.scene.objects:
        other.select_set(False)
    armature.select_set(True)
    bpy.context.view_layer.objects.active = armature


def rolled(armature: bpy.types.Object) -> None:
    """Rolls each bone about itself, each by its own angle."""
    bpy.ops.object.mode_set(mode="EDIT")
    for number, bone in enumerate(armature.data.edit_bones):
        bone.roll += math.radians(37 * number % 360 - 180)
    bpy.ops.object.mode_set(mode="OBJECT")


def resting(turns: dict[str, tuple[float, float, float]]) -> Callable[[bpy.types.Object], None]:
    """Turns bones about the axes of the armature, in degrees, and makes this pose the rest pose."""

    def change(armature: bpy.types.Object) -> None:
        for name, degrees in turns.items():
            bone = armature.pose.bones[name]
            turn = Euler([math.radians(one) for one in degrees]).to_matrix().to_4x4()
            at = Matrix.Translation(bone.matrix.translation)
            bone.matrix = at @ turn @ at.inverted() @ bone.matrix
            bpy.context.view_layer.update()
        bpy.ops.object.mode_set(mode="POSE")
        bpy.ops.pose.armature_apply()
        bpy.ops.object.mode_set(mode="OBJECT")

    return change


def placed(
    scale: float = 1.0, degrees: tuple[float, float, float] = (0, 0, 0), at: tuple[float, float, float] = (0, 0, 0)
):
    """Moves, scales and turns the object, and shrinks its bones, so that the character keeps its size."""

    def change(armature: bpy.types.Object) -> None:
        armature.data.transform(Matrix.Scale(1 / scale, 4))
        turn = Euler([math.radians(one) for one in degrees]).to_matrix().to_4x4()
        armature.matrix_world = Matrix.Translation(at) @ turn @ Matrix.Scale(scale, 4) @ armature.matrix_world

    return change


def laid(armature: bpy.types.Object) -> None:
    """Turns the bones to another axis of the armature, and turns the object back."""
    turn = Matrix.Rotation(math.radians(90), 4, "X")
    armature.data.transform(turn)
    armature.matrix_world = armature.matrix_world @ turn.inverted()


def mode(name: str) -> Callable[[bpy.types.Object], None]:
    """Sets the rotation mode of all bones."""

    def change(armature: bpy.types.Object) -> None:
        for bone in armature.pose.bones:
            bone.rotation_mode = name

    return change


def loose(armature: bpy.types.Object) -> None:
    """Bones that do not turn with their parents, move along other axes, or do not inherit a scale."""
    for number, bone in enumerate(armature.data.bones):
        bone.use_inherit_rotation = number % 3 != 0
        bone.use_local_location = number % 2 == 0
        bone.inherit_scale = ("FULL", "NONE", "ALIGNED")[number % 3]


def connected(armature: bpy.types.Object) -> None:
    """Connects each bone that begins where its parent ends."""
    bpy.ops.object.mode_set(mode="EDIT")
    for bone in armature.data.edit_bones:
        if bone.parent is not None and (bone.head - bone.parent.tail).length < 1e-5:
            bone.use_connect = True
    bpy.ops.object.mode_set(mode="OBJECT")


def posed_before(armature: bpy.types.Object) -> None:
    """Leaves the bones in some pose, without keys."""
    for number, bone in enumerate(armature.pose.bones):
        bone.rotation_mode = "QUATERNION"
        bone.rotation_quaternion = Euler((0.1 * (number % 5), 0.2, 0)).to_quaternion()
        bone.location = (0.01, 0, 0.02)


# Poses of human_cmu.gltf, whose arms point obliquely down at rest: the same body in other rest poses.
ARMS_DOWN = {"LeftArm": (0, 35, 0), "RightArm": (0, -35, 0)}
T_POSE = {"LeftArm": (0, -38, 0), "RightArm": (0, 38, 0)}
BENT = {"LeftForeArm": (0, 0, 25), "RightForeArm": (0, 0, -25), "LeftLeg": (20, 0, 0), "RightLeg": (20, 0, 0)}
