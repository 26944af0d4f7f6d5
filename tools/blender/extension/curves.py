"""Actions: f-curves of bones for Blender 4.2 (one list), and for Blender 4.4 and later (layers and slots)."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import bpy
import numpy as np

_LINEAR = 1
_TRANSFORMS = ("location", "rotation_quaternion", "rotation_euler", "rotation_axis_angle", "scale")


class Track(NamedTuple):
    """A property of a bone over the frames."""

    bone: str
    path: str
    """``location``, ``scale``, or the rotation property of the bone's mode."""
    values: np.ndarray
    """(frames, 3 or 4); one row for a constant value."""


def new_action(name: str, owner: bpy.types.Object) -> bpy.types.Action:
    """Makes an action, with a slot for an object if this version of Blender has slots."""
    action = bpy.data.actions.new(name)
    if hasattr(action, "slots"):
        action.slots.new(id_type="OBJECT", name=owner.name)
    return action


def assign(owner: bpy.types.Object, action: bpy.types.Action) -> None:
    """Assigns an action to an object."""
    animation = owner.animation_data_create()
    animation.action = action
    if hasattr(animation, "action_slot") and animation.action_slot is None:
        animation.action_slot = action.slots[0]


def write(action: bpy.types.Action, owner: bpy.types.Object, tracks: Iterable[Track], frames: range) -> None:
    """Writes the transforms of bones to the slot of an object, replacing the curves of the same bones."""
    tracks = list(tracks)
    holder = _holder(action, owner)
    ours = {_path(track.bone, name) for track in tracks for name in _TRANSFORMS}
    for curve in [curve for curve in holder.fcurves if curve.data_path in ours]:
        holder.fcurves.remove(curve)
    groups = {group.name: group for group in holder.groups}
    for track in tracks:
        if track.bone not in groups:
            groups[track.bone] = holder.groups.new(track.bone)
        # A constant value gets keys at both ends, so that the action is as long as the motion.
        times = np.array(frames if len(track.values) == len(frames) else [frames[0], frames[-1]], dtype=np.float64)
        for index, column in enumerate(np.broadcast_to(track.values, (len(times), track.values.shape[1])).T):
            curve = holder.fcurves.new(_path(track.bone, track.path), index=index)
            curve.group = groups[track.bone]
            points = curve.keyframe_points
            points.add(len(times))
            points.foreach_set("co", np.stack([times, column], axis=1).ravel())
            points.foreach_set("interpolation", [_LINEAR] * len(times))
            curve.update()


def _path(bone: str, name: str) -> str:
    return f'pose.bones["{bpy.utils.escape_identifier(bone)}"].{name}'


def _holder(action: bpy.types.Action, owner: bpy.types.Object) -> Any:
    """The owner of the f-curves: the action in Blender 4.2 and 4.3, the channels of a slot in later versions."""
    if not hasattr(action, "layers"):
        return action
    animation = owner.animation_data
    is_assigned = animation is not None and animation.action == action and animation.action_slot is not None
    slot = animation.action_slot if is_assigned else action.slots[0]
    layer = action.layers[0] if len(action.layers) else action.layers.new("Layer")
    strip = layer.strips[0] if len(layer.strips) else layer.strips.new(type="KEYFRAME")
    return strip.channelbag(slot, ensure=True)
