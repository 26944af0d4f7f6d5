"""The operators of the panel: import, retarget, clean, foot lock, loop. If an operator fails, it changes nothing."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import bpy
import mocap
import numpy as np
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, FloatProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from . import curves, glb, jobs, overrides, report, rig

EXTENSIONS = mocap.extensions()

_RATES = (
    ("SET", "Set the Scene's", "The scene takes the frame rate of the file, and every frame of the file gets a key"),
    ("KEEP", "Keep the Scene's", "The motion is resampled to the frame rate of the scene, at the same speed"),
)
# A frame rate within this distance of a whole number is rounded.
_WHOLE = 1e-3


class _Operator:
    """An operator that reports an error of mocap as Blender's own."""

    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        self.names: dict[str, str] = {}
        try:
            self.make(context)
        except (mocap.MocapError, rig.ArmatureError) as failure:
            self.report({"ERROR"}, report.of_error(failure, self.names))
            return {"CANCELLED"}
        return {"FINISHED"}

    def make(self, context: bpy.types.Context) -> None:
        """Runs the operator. Errors are raised before anything has changed."""
        raise NotImplementedError

    def tell(self, told: Sequence[str]) -> None:
        self.report({"INFO"}, "\n".join(told))

    def file_of(
        self, armature: bpy.types.Object, scene: bpy.types.Scene, folder: Path, name: str, poses: np.ndarray
    ) -> Path:
        """Writes an armature with its poses in frames, as the input file of a job."""
        path = folder / f"{name}.glb"
        self.names[str(path)] = f"armature {armature.name!r}"
        tree = rig.tree_of(armature, scene)
        glb.write(path, tree, poses, frame_rate(scene), rig.skin_of(armature, scene, tree))
        return path


class _FilesOperator(_Operator, ImportHelper):
    """An operator on files from the file browser, or on dropped files."""

    directory: StringProperty(subtype="DIR_PATH", options={"SKIP_SAVE", "HIDDEN"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"SKIP_SAVE", "HIDDEN"})
    filter_glob: StringProperty(default=";".join(f"*.{one}" for one in EXTENSIONS), options={"HIDDEN"})
    unit: StringProperty(
        name="Unit",
        description="Unit of length of the files: m, cm, mm, inch, cmu, or a length in metres; inferred if empty",
    )
    up: EnumProperty(
        name="Up",
        description="Up axis of the files",
        items=[("AUTO", "Automatic", "The axis that the file states, or else inferred"), ("y", "+Y", ""), ("z", "+Z", "")],
    )
    solve: BoolProperty(name="Solve Markers", description="Solve a skeleton from the markers of C3D and TRC files")

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if self.directory and self.files:
            return self.execute(context)
        return ImportHelper.invoke(self, context, event)

    def paths(self) -> list[str]:
        names = [one.name for one in self.files if one.name]
        return [os.path.join(self.directory, name) for name in names] if names else [self.filepath]

    def job(self, scene: bpy.types.Scene, inputs: Sequence[str]) -> dict[str, Any]:
        """The input of a job."""
        source: dict[str, Any] = {"inputs": list(inputs), "space": {}, "frames": {}}
        if self.unit:
            source["space"]["unit"] = self.unit
        if self.up != "AUTO":
            source["space"]["up"] = self.up
        if self.rate == "KEEP":
            source["frames"]["fps"] = frame_rate(scene)
        return {"source": source, "read": {"markers": "auto"} if self.solve else {}}


class ImportMotion(_FilesOperator, bpy.types.Operator):
    """Import motion files of every format of mocap as armatures with actions"""

    bl_idname = "mocap.import_motion"
    bl_label = "Import Motion"

    rate: EnumProperty(name="Frame Rate", items=_RATES, default="SET")

    def make(self, context: bpy.types.Context) -> None:
        outcomes = [(path, *self._read(context.scene, path)) for path in self.paths()]
        told: list[str] = []
        made: list[bpy.types.ID] = []
        try:
            for path, outcome, is_along in outcomes:
                armature, nodes = rig.build(context, Path(path).stem, outcome, is_along)
                made += [armature, armature.data]
                tracks = tracks_of_clips(context.scene, armature, outcome, nodes)
                actions = write_clips(context.scene, armature, outcome, tracks, None, self.rate == "SET")
                made += actions
                lines = report.lines(outcome.report)
                told += [f"{Path(path).name}: {len(nodes)} bones, {len(actions)} actions", *lines]
                for action in actions:
                    report.keep(action, lines)
        except BaseException:
            bpy.data.batch_remove(made)
            raise
        self.tell(told)

    def _read(self, scene: bpy.types.Scene, path: str) -> tuple[jobs.Outcome, bool]:
        """Converts a file. Returns the result, and whether +Y of its joints is along the limbs."""
        job = self.job(scene, [path])
        write = {"mesh": "none", "keep-constant": True, "skeleton-only": True}
        with jobs.folder() as folder:
            try:
                return jobs.run({**job, "write": {**write, "bone-axis": "y"}}, folder / "motion.glb"), True
            except mocap.MocapError as failure:
                # The axes of a joint with a non-uniform scale cannot be aligned.
                if failure.code != "unrepresentable":
                    raise
            return jobs.run({**job, "write": write}, folder / "motion.glb"), False


class _Retarget(_Operator):
    """Retargets motions to the bones of the active armature."""

    feet: EnumProperty(
        name="Feet",
        items=[
            ("lock", "Lock", "A foot is held still while the foot of the source is in ground contact"),
            ("free", "Free", "Feet are not corrected"),
        ],
    )
    scale: EnumProperty(
        name="Steps",
        description="Scale of the path",
        items=[
            ("auto", "By the Legs", "By the ratio of the leg lengths"),
            ("none", "As the Source", "The path of the source, in metres"),
        ],
    )
    in_place: BoolProperty(name="In Place", description="Keep the figure in place over the ground")
    color: BoolProperty(
        name="Colour Limbs",
        description="Colour bones by their mean angle to the source: green up to 1 degree, yellow up to 3, then red",
        default=True,
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        armature = overrides.armature_of(context.active_object)
        return armature is not None and armature.mode != "EDIT"

    def retarget(
        self,
        context: bpy.types.Context,
        job: Mapping[str, Any],
        names: Sequence[str],
        frames: range | None,
        sets_rate: bool,
    ) -> None:
        """Runs a job on the active armature. The clips get these names, and begin in these frames."""
        armature = overrides.armature_of(context.active_object)
        scene = context.scene
        source = dict(job["source"])
        if self.in_place:
            source["frames"] = {**source.get("frames", {}), "root": "in-place"}
        with jobs.folder() as folder:
            character: dict[str, Any] = {"file": self.file_of(armature, scene, folder, "target", np.empty(0))}
            bones = mocap.read(character["file"], hash=False).bones
            character |= {"scale": self.scale, "feet": self.feet, **({"names-of-clips": list(names)} if names else {})}
            outcome = jobs.run({**job, "source": source, "target": {"character": character}}, folder / "motion.glb")
        nodes = list(range(1, len(armature.data.bones) + 1))
        tracks = tracks_of_clips(scene, armature, outcome, nodes)
        armature = overrides.editable(context, armature)
        actions = write_clips(scene, armature, outcome, tracks, frames, sets_rate)
        told = report.lines(outcome.report)
        for action in actions:
            report.keep(action, told)
        if self.color:
            report.color(armature, outcome.report["clips"][0]["limbs"], bones)
        self.tell(told)


class RetargetFiles(_Retarget, _FilesOperator, bpy.types.Operator):
    """Retarget motion files to the active armature, with any rest pose; each file becomes an action"""

    bl_idname = "mocap.retarget_files"
    bl_label = "Retarget to Active Armature"

    rate: EnumProperty(name="Frame Rate", items=_RATES, default="KEEP")

    def make(self, context: bpy.types.Context) -> None:
        self.retarget(context, self.job(context.scene, self.paths()), [], None, self.rate == "SET")


class RetargetSelected(_Retarget, bpy.types.Operator):
    """Retarget the action of the other selected armature to the active armature"""

    bl_idname = "mocap.retarget_selected"
    bl_label = "Retarget from Selected Armature"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return super().poll(context) and _other(context) is not None

    def make(self, context: bpy.types.Context) -> None:
        other = _other(context)
        action = action_of(other)
        with jobs.folder() as folder:
            frames = frames_of(action)
            poses = rig.poses_of(other, context.scene, frames)
            file = self.file_of(other, context.scene, folder, "source", poses)
            self.retarget(context, {"source": {"inputs": [file]}}, [action.name], frames, False)


class _Step(_Operator):
    """Applies a step of mocap to the action of the active armature."""

    into_copy: BoolProperty(name="Keep the Original", description="Write the result into a copy of the action")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        armature = context.active_object
        is_armature = armature is not None and armature.type == "ARMATURE"
        return is_armature and armature.mode != "EDIT" and action_of(armature) is not None

    def step(self) -> dict[str, Any]:
        """The step in the form of a job."""
        raise NotImplementedError

    def finish(self, action: bpy.types.Action, frames: range) -> None:
        """Sets the properties of an action besides its curves. The curves are in these frames."""

    def make(self, context: bpy.types.Context) -> None:
        armature, scene = context.active_object, context.scene
        action = action_of(armature)
        frames = frames_of(action)
        poses = rig.poses_of(armature, scene, frames)
        with jobs.folder() as folder:
            file = self.file_of(armature, scene, folder, "motion", poses)
            source = {"inputs": [file], "frames": {"drop-first-frame": "auto"}}
            outcome = jobs.run({"source": source, "steps": [self.step()]}, folder / "changed.glb")
        clip = outcome.clips[0]
        first = self.first(frames, len(clip.poses))
        # The indices of the object's matrices in the frames of the result.
        places = np.clip(first - frames.start + np.arange(len(clip.poses)), 0, len(frames) - 1)
        placed = rig.to_blender(scene) @ poses[places, 0]
        frames = range(first, first + len(clip.poses))
        nodes = list(range(1, len(armature.data.bones) + 1))
        tracks = rig.tracks_of(armature, rig.poses_for(armature, scene, nodes, outcome.tree, clip, placed))
        armature = overrides.editable(context, armature)
        if self.into_copy or action.library is not None:
            if action.library is None:
                # Blender saves no data without a user.
                action.use_fake_user = True
            action = action.copy()
            curves.assign(armature, action)
        curves.write(action, armature, tracks, frames)
        rig.reset(armature)
        self.finish(action, frames)
        told = report.lines(outcome.report)
        report.keep(action, told)
        self.tell(told)

    def first(self, frames: range, count: int) -> int:
        """The frame of the first key."""
        return first_of(frames, count)


class Clean(_Step, bpy.types.Operator):
    """Clean the action: time, flips, noise, lengths, floor, contacts"""

    bl_idname = "mocap.clean"
    bl_label = "Clean"

    def step(self) -> dict[str, Any]:
        return mocap.edit.clean.step().to_dict()


class FootLock(_Step, bpy.types.Operator):
    """Hold the feet still while they are in contact with the ground"""

    bl_idname = "mocap.foot_lock"
    bl_label = "Foot Lock"

    def step(self) -> dict[str, Any]:
        return mocap.edit.foot_lock.step().to_dict()


class Loop(_Step, bpy.types.Operator):
    """Cut the action to a loop, whose last frame equals its first frame"""

    bl_idname = "mocap.loop"
    bl_label = "Loop"

    shortest: FloatProperty(
        name="Shortest", description="The shortest loop to look for", default=0.6, min=0.05, unit="TIME_ABSOLUTE"
    )
    longest: FloatProperty(
        name="Longest", description="The longest loop to look for", default=4.0, min=0.05, unit="TIME_ABSOLUTE"
    )
    in_place: BoolProperty(name="In Place", description="The loop stays in place over the ground")

    def step(self) -> dict[str, Any]:
        step = mocap.edit.loop_clip.step(shortest=self.shortest, longest=self.longest, in_place=self.in_place)
        return step.to_dict()

    def first(self, frames: range, count: int) -> int:
        return frames.start

    def finish(self, action: bpy.types.Action, frames: range) -> None:
        action.use_frame_range = action.use_cyclic = True
        action.frame_start, action.frame_end = frames[0], frames[-1]


def tracks_of_clips(
    scene: bpy.types.Scene, armature: bpy.types.Object, outcome: jobs.Outcome, nodes: Sequence[int]
) -> list[list[curves.Track]]:
    """The tracks to key for each clip of an outcome."""
    placed = np.array(armature.matrix_world, dtype=np.float64)
    poses = (rig.poses_for(armature, scene, nodes, outcome.tree, clip, placed) for clip in outcome.clips)
    return [rig.tracks_of(armature, pose) if len(pose) else [] for pose in poses]


def write_clips(
    scene: bpy.types.Scene,
    armature: bpy.types.Object,
    outcome: jobs.Outcome,
    tracks: Sequence[list[curves.Track]],
    frames: range | None,
    sets_rate: bool,
) -> list[bpy.types.Action]:
    """Makes an action of each clip of an outcome. The armature gets the first action.

    The clips begin where the scene does, or in the frames of their source.
    """
    moving = [(clip, keys) for clip, keys in zip(outcome.clips, tracks) if keys]
    actions: list[bpy.types.Action] = []
    for clip, keys in moving:
        action = curves.new_action(clip.name, armature)
        if not actions:
            curves.assign(armature, action)
        # Blender saves no data without a user.
        action.use_fake_user = bool(actions)
        count = len(clip.poses)
        first = scene.frame_start if frames is None else first_of(frames, count)
        curves.write(action, armature, keys, range(first, first + count))
        actions.append(action)
    if moving:
        rig.reset(armature)
    if moving and sets_rate:
        set_frame_rate(scene, moving[0][0].frame_rate)
        scene.frame_end = max(scene.frame_start + len(clip.poses) - 1 for clip, _ in moving)
    return actions


def frame_rate(scene: bpy.types.Scene) -> float:
    """Frames per second of a scene."""
    return scene.render.fps / scene.render.fps_base


def set_frame_rate(scene: bpy.types.Scene, rate: float) -> None:
    """Sets the frames per second of a scene, which Blender stores as a quotient."""
    whole = max(1, round(rate))
    scene.render.fps = whole
    scene.render.fps_base = 1.0 if abs(rate - whole) < _WHOLE else whole / rate


def action_of(armature: bpy.types.Object) -> bpy.types.Action | None:
    """The action of an armature."""
    return armature.animation_data.action if armature.animation_data else None


def frames_of(action: bpy.types.Action) -> range:
    """The frames in which an action has keys."""
    first, last = action.curve_frame_range
    return range(int(np.floor(first)), int(np.ceil(last)) + 1)


def first_of(frames: range, count: int) -> int:
    """The first frame of a result with this number of frames. A dropped rest pose was in the first frame of the
    source."""
    return frames.start + max(0, len(frames) - count)


def _other(context: bpy.types.Context) -> bpy.types.Object | None:
    """The other selected armature, if exactly one has an action."""
    chosen = [one for one in context.selected_objects if one != context.active_object and one.type == "ARMATURE"]
    return chosen[0] if len(chosen) == 1 and action_of(chosen[0]) is not None else None


CLASSES = (ImportMotion, RetargetFiles, RetargetSelected, Clean, FootLock, Loop)
