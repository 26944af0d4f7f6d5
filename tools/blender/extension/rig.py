"""Converts between the armatures of Blender and the nodes of mocap."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np
from mathutils import Matrix, Vector

from . import curves, glb, jobs

# mocap has +Y up, Blender +Z.
_UP = np.array(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)), dtype=np.float64)
# The length of a bone without an end, as a fraction of the figure's largest extent.
_TIP = 0.03
# A bone points at a child if the cosine of the angle between its axis and the child is at least this value.
_ALONG = 0.95
# The largest difference of equal values: of rotations, scales, and locations relative to the longest bone.
_STILL = 1e-5


class ArmatureError(ValueError):
    """The armature cannot be used; the message has the reason."""


def to_blender(scene: bpy.types.Scene) -> np.ndarray:
    """The matrix from metres with +Y up to the units of a scene with +Z up."""
    return np.diag([1 / scene.unit_settings.scale_length] * 3 + [1.0]) @ _UP


def bones_of(armature: bpy.types.Object) -> list[bpy.types.Bone]:
    """The bones, depth-first."""
    found: list[bpy.types.Bone] = []
    todo = [bone for bone in reversed(armature.data.bones) if bone.parent is None]
    while todo:
        found.append(todo.pop())
        todo += reversed(found[-1].children)
    return found


def tree_of(armature: bpy.types.Object, scene: bpy.types.Scene) -> glb.Tree:
    """The rest pose of an armature as mocap's nodes: a node for the object, and the bones below it.

    Raises:
        ArmatureError: Where it has no bones, or its scale is no single positive number.
    """
    bones = bones_of(armature)
    if not bones:
        raise ArmatureError(f"the armature {armature.name!r} has no bones")
    scale = np.array(armature.matrix_world.to_scale())
    if np.linalg.det(np.array(armature.matrix_world.to_3x3())) <= 0 or np.ptp(scale) > 1e-3 * scale.max():
        numbers = ", ".join(f"{number:.3g}" for number in scale)
        advice = "apply the scale (Ctrl+A in Object Mode)"
        raise ArmatureError(
            f"the armature {armature.name!r} has the scale {numbers}, expected one positive number: {advice}"
        )
    names = [armature.name, *(bone.name for bone in bones)]
    index = {bone.name: number + 1 for number, bone in enumerate(bones)}
    parents = [-1, *(index[bone.parent.name] if bone.parent else 0 for bone in bones)]
    to_world = np.linalg.inv(to_blender(scene)) @ np.array(armature.matrix_world, dtype=np.float64)
    rest = [np.eye(4), *(np.array(bone.matrix_local, dtype=np.float64) for bone in bones)]
    return glb.Tree(names, parents, to_world @ np.array(rest))


def poses_of(armature: bpy.types.Object, scene: bpy.types.Scene, frames: range) -> np.ndarray:
    """The world matrices of the nodes of :func:`tree_of` in frames, as Blender evaluates them."""
    order = [armature.pose.bones.find(bone.name) for bone in bones_of(armature)]
    numbers = np.empty(16 * len(order), dtype=np.float32)
    poses = []
    # Use a separate scene, so that each frame only evaluates the armature and its dependencies.
    alone = bpy.data.scenes.new("mocap")
    try:
        alone.collection.objects.link(armature)
        alone.render.fps, alone.render.fps_base = scene.render.fps, scene.render.fps_base
        layer = alone.view_layers[0]
        for frame in frames:
            alone.frame_set(frame)
            layer.update()
            evaluated = armature.evaluated_get(layer.depsgraph)
            evaluated.pose.bones.foreach_get("matrix", numbers)
            # Blender stores matrices in column-major order.
            bones = numbers.reshape(-1, 4, 4).transpose(0, 2, 1)[order].astype(np.float64)
            world = np.array(evaluated.matrix_world, dtype=np.float64)
            poses.append(world @ np.concatenate([np.eye(4)[None], bones]))
    finally:
        bpy.data.scenes.remove(alone)
        # Restore the pose: Blender has set the armature to the last frame.
        scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)
    return np.linalg.inv(to_blender(scene)) @ np.array(poses)


def skin_of(armature: bpy.types.Object, scene: bpy.types.Scene, tree: glb.Tree) -> glb.Skin | None:
    """The vertices that an armature moves; mocap finds the soles of the feet among them."""
    index = {name: number for number, name in enumerate(tree.names) if number > 0}
    from_blender = np.linalg.inv(to_blender(scene))
    positions, nodes, weights = [], [], []
    # Search all data, because objects of an instanced collection are in no scene.
    for thing in bpy.data.objects:
        modifiers = [one for one in thing.modifiers if one.type == "ARMATURE" and one.object == armature]
        if thing.type != "MESH" or not modifiers or not len(thing.data.vertices):
            continue
        places = np.empty(3 * len(thing.data.vertices), dtype=np.float32)
        thing.data.vertices.foreach_get("co", places)
        to_world = from_blender @ np.array(thing.matrix_world, dtype=np.float64)
        places = places.reshape(-1, 3) @ to_world[:3, :3].T + to_world[:3, 3]
        node_of = {group.index: index[group.name] for group in thing.vertex_groups if group.name in index}
        for place, vertex in zip(places, thing.data.vertices):
            found = sorted(
                ((one.weight, node_of[one.group]) for one in vertex.groups if one.group in node_of), reverse=True
            )
            found = [one for one in found[:4] if one[0] > 0]
            if not found:
                continue
            whole = sum(weight for weight, _ in found)
            positions.append(place)
            nodes.append([node for _, node in found] + [1] * (4 - len(found)))
            weights.append([weight / whole for weight, _ in found] + [0.0] * (4 - len(found)))
    if not positions:
        return None
    return glb.Skin(np.array(positions), np.array(nodes), np.array(weights))


def build(
    context: bpy.types.Context, name: str, outcome: jobs.Outcome, is_along: bool
) -> tuple[bpy.types.Object, list[int]]:
    """Makes an armature of the joints of an outcome.

    Returns it, and the node of each bone in the order of :func:`bones_of`.

    ``is_along`` says that +Y of the joints is along the limbs.
    """
    tree, joints = outcome.tree, set(outcome.joints)
    if not joints:
        raise ArmatureError(f"{name}: there are no joints")
    rest = to_blender(context.scene) @ tree.world
    heads = rest[:, :3, 3]
    extent = float(np.ptp(heads, axis=0).max()) or 1 / context.scene.unit_settings.scale_length
    above = [_above(tree.parents, joints, node) for node in range(len(tree.parents))]
    armature = bpy.data.objects.new(name, bpy.data.armatures.new(name))
    try:
        _link(context, armature)
        names: dict[int, str] = {}
        bpy.ops.object.mode_set(mode="EDIT")
        for node in outcome.joints:
            ends = [heads[other] - heads[node] for other, up in enumerate(above) if up == node]
            bone = armature.data.edit_bones.new(tree.names[node])
            bone.tail = (0, 1, 0)
            bone.matrix = _frame(rest[node], [] if is_along else ends)
            bone.length = _length(np.array(bone.matrix)[:3, 1], ends, extent)
            if above[node] >= 0:
                bone.parent = armature.data.edit_bones[names[above[node]]]
            names[node] = bone.name
        bpy.ops.object.mode_set(mode="OBJECT")
    except BaseException:
        remove(armature)
        raise
    node_of = {bone: node for node, bone in names.items()}
    return armature, [node_of[bone.name] for bone in bones_of(armature)]


def remove(armature: bpy.types.Object) -> None:
    """Removes a new armature."""
    data = armature.data
    bpy.data.objects.remove(armature)
    bpy.data.armatures.remove(data)


def poses_for(
    armature: bpy.types.Object,
    scene: bpy.types.Scene,
    nodes: Sequence[int],
    tree: glb.Tree,
    clip: jobs.Clip,
    placed: np.ndarray,
) -> np.ndarray:
    """The matrices of bones in the armature, frame by frame, that place the bones at the nodes of a clip.

    ``tree`` has the nodes where the bones are at rest. ``placed`` is the matrix of the armature to the world in all
    frames, or an array with one for each frame.
    """
    nodes = list(nodes)
    bones = np.array([np.array(bone.matrix_local, dtype=np.float64) for bone in bones_of(armature)])
    rest = to_blender(scene) @ tree.world[nodes]
    from_node = np.linalg.inv(rest) @ np.array(armature.matrix_world, dtype=np.float64) @ bones
    to_armature = np.linalg.inv(placed).reshape(-1, 1, 4, 4)
    return to_armature @ to_blender(scene) @ clip.poses[:, nodes] @ from_node


def tracks_of(armature: bpy.types.Object, poses: np.ndarray) -> list[curves.Track]:
    """The tracks to key so that bones have these matrices, (frames, bones, 4, 4). Each rotation is in the mode of its
    bone.

    A location or a scale that stays as at rest gets no key.
    """
    bones = bones_of(armature)
    index = {bone.name: number for number, bone in enumerate(bones)}
    matrices = [[Matrix(one) for one in frame] for frame in poses]
    size = max(bone.length for bone in bones)
    tracks = []
    for number, bone in enumerate(bones):
        above = index[bone.parent.name] if bone.parent else None
        basis = [_basis(bone, frame, number, above).decompose() for frame in matrices]
        locations, turns, scales = (list(parts) for parts in zip(*basis))
        mode = armature.pose.bones[bone.name].rotation_mode
        tracks.append(_track(bone.name, *_rotations(mode, turns), _STILL, None))
        # The location of a connected bone has no effect.
        locations = np.zeros((1, 3)) if bone.use_connect else np.array(locations)
        tracks.append(_track(bone.name, "location", locations, _STILL * size, np.zeros(3)))
        tracks.append(_track(bone.name, "scale", np.array(scales), _STILL, np.ones(3)))
    return [track for track in tracks if track is not None]


def reset(armature: bpy.types.Object) -> None:
    """Resets locations and scales of bones to rest. Keyed values follow their keys."""
    for posed in armature.pose.bones:
        posed.location, posed.scale = (0, 0, 0), (1, 1, 1)


def _basis(bone: bpy.types.Bone, frame: Sequence[Matrix], number: int, above: int | None) -> Matrix:
    parents = {} if above is None else {"parent_matrix": frame[above], "parent_matrix_local": bone.parent.matrix_local}
    return bone.convert_local_to_pose(frame[number], bone.matrix_local, invert=True, **parents)


def _track(bone: str, path: str, values: np.ndarray, close: float, rest: np.ndarray | None) -> curves.Track | None:
    """The track of a property: one row if it is constant, nothing if it stays at rest."""
    if np.abs(values - values[0]).max() <= close:
        values = values[:1]
        if rest is not None and np.abs(values - rest).max() <= close:
            return None
    return curves.Track(bone, path, values)


def _rotations(mode: str, turns: list) -> tuple[str, np.ndarray]:
    """Rotations in the mode of a bone, without jumps: the property and its values."""
    for before, turn in zip(turns, turns[1:]):
        if before.dot(turn) < 0:
            turn.negate()
    if mode == "QUATERNION":
        return "rotation_quaternion", np.array([list(turn) for turn in turns])
    if mode == "AXIS_ANGLE":
        pairs = [turn.to_axis_angle() for turn in turns]
        return "rotation_axis_angle", np.array([[angle, *axis] for axis, angle in pairs])
    angles = [turns[0].to_euler(mode)]
    for turn in turns[1:]:
        angles.append(turn.to_euler(mode, angles[-1]))
    return "rotation_euler", np.array([list(one) for one in angles])


def _above(parents: Sequence[int], joints: set[int], node: int) -> int:
    """The nearest ancestor of a node that is a joint, or -1."""
    node = parents[node]
    while node >= 0 and node not in joints:
        node = parents[node]
    return node


def _frame(node: np.ndarray, ends: Sequence[np.ndarray]) -> Matrix:
    """The matrix of a bone: at its node, with the rotation of the node, turned so that +Y points to the nearest end."""
    location, rotation, _ = Matrix(node).decompose()
    along = rotation @ Vector((0, 1, 0))
    towards = [Vector(end).normalized() for end in ends if np.linalg.norm(end) > 1e-9]
    if towards:
        rotation = along.rotation_difference(max(towards, key=along.dot)) @ rotation
    return Matrix.LocRotScale(location, rotation, None)


def _length(axis: np.ndarray, ends: Sequence[np.ndarray], extent: float) -> float:
    """The length of a bone that points along an axis."""
    reached = [float(end @ axis) for end in ends if end @ axis > _ALONG * np.linalg.norm(end)]
    return max([*reached, 0.1 * _TIP * extent]) if reached else _TIP * extent


def _link(context: bpy.types.Context, armature: bpy.types.Object) -> None:
    """Adds an armature to the scene, makes it active and the only selected object, in Object Mode."""
    layer = context.view_layer
    if layer.objects.active is not None and layer.objects.active.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    # Objects cannot be added to a linked collection. In a hidden or excluded collection, objects have no Edit Mode.
    if context.collection.is_editable:
        context.collection.objects.link(armature)
    if not armature.visible_get(view_layer=layer):
        for collection in armature.users_collection:
            collection.objects.unlink(armature)
        context.scene.collection.objects.link(armature)
    for other in list(context.selected_objects):
        other.select_set(False)
    armature.select_set(True)
    layer.objects.active = armature
