# Written by `MOCAP_WRITE=1 cargo test -p mocap-bindings`, from the documentation of Rust: do not edit.
"""Functions that read and write files."""

from __future__ import annotations

from typing import Literal

from . import _mocap
from ._call import public
from ._convert import converted, written
from ._job_options import Format, ReadOptions, WriteOptions
from ._options import Axis, Bones, StrPath, TimeRange, Unit, Weights, part, time_range, weights_of
from ._scene import Scene, SceneLike


@public
def read(
    path: StrPath,
    *,
    all_rows: bool = False,
    body: StrPath | None = None,
    clip: int | str | None = None,
    format: Format | None = None,
    joints: StrPath | None = None,
    lengths: Literal["median", "moving"] | None = None,
    markers: StrPath | None = None,
    retime: float | None = None,
    root_offset: Literal["auto", "replace", "add"] = "auto",
    skeleton: StrPath | None = None,
    static: StrPath | None = None,
    strict: bool = False,
    hash: bool = True,
) -> Scene:
    """Reads a motion file.

    >>> scene = mocap.read("walk.bvh", root_offset="add", strict=True)  # doctest: +SKIP

    Args:
        path: The motion file.
        all_rows: Read all rows of the motion, including those beyond the declared number of frames.
        body: The body for arrays of rotations, such as AMASS files. FILE is a model of SMPL, SMPL-H or SMPL-X (.npz
            or .pkl), or a file of any format with a figure. For arrays of a robot, FILE is the robot. Default: generic
            proportions, 1.70 m tall.
        clip: The animation to use of a file that has several: its name, or its number from 0; name:3 is the
            animation whose name is 3. With all, a command for one motion uses the first.
        format: Format of the input. Default: found from its contents, or else from its extension.
        joints: The joints of a file of positions, to solve their rotations. A JSON file, or one of smpl22, smpl24,
            coco17, h36m, mediapipe33, openpose25, mhr70, mhr127. Default: arrays with the joints of SMPL are solved.
        lengths: Lengths of bones that are solved from positions: the median over all frames; or the length in each
            frame, so that joints match their positions.
            ``"median"``: The median of each length over the frames: bones keep their lengths, and joints are near
                their points.
            ``"moving"``: The lengths of each frame: joints are at their points, and bones change their lengths.
        markers: Solve a skeleton from the markers of a file. auto: a known marker set; auto:NAME: the markers of
            one subject; FILE: a JSON object from labels to landmarks. Default: markers stay points.
        retime: Play at this number of frames per second: the motion keeps its frames, and becomes slower or faster.
        root_offset: How the root's OFFSET and its position channels combine.
            ``"auto"``: Adds in two cases. The root's position is near zero in the first frame or in the median of
                all frames, but the OFFSET is not zero. Or the position stays near zero along an OFFSET that puts the
                feet on the floor. Otherwise, replaces.
            ``"replace"``: The position channels replace the OFFSET, as in Assimp and Blender.
            ``"add"``: The position channels are added to the OFFSET.
        skeleton: The skeleton of an .amc motion. Default: the .asf file in its folder with the same prefix, or the
            only .asf file.
        static: A static trial: markers of a standing person. It may have more markers than the motion.
        strict: Treat every warning as an error.
        hash: Compute the SHA-256 of the file, for the provenance; without, it is empty.

    Raises:
        MocapError: Where the file is of no known format, or breaks the rules of its own.
        FileNotFoundError, IsADirectoryError, PermissionError, OSError: Where it cannot be opened.
        MemoryError: Where it would need more memory than the limits allow.
        TypeError: Where there is no such option, or a value has another type.
    """
    return Scene(_mocap.read(path, ReadOptions(
        all_rows=all_rows,
        body=body,
        clip=clip,
        format=format,
        joints=joints,
        lengths=lengths,
        markers=markers,
        retime=retime,
        root_offset=root_offset,
        skeleton=skeleton,
        static=static,
        strict=strict,
        hash=hash,
    )))


@public
def read_bytes(
    data: bytes,
    name: str,
    *,
    all_rows: bool = False,
    body: StrPath | None = None,
    clip: int | str | None = None,
    format: Format | None = None,
    joints: StrPath | None = None,
    lengths: Literal["median", "moving"] | None = None,
    markers: StrPath | None = None,
    retime: float | None = None,
    root_offset: Literal["auto", "replace", "add"] = "auto",
    skeleton: StrPath | None = None,
    static: StrPath | None = None,
    strict: bool = False,
    hash: bool = True,
) -> Scene:
    """Reads the bytes of a motion file.

    Args:
        data: The bytes of a motion file.
        name: Stands for the file in errors; its extension helps to tell the format.
        all_rows: Read all rows of the motion, including those beyond the declared number of frames.
        body: The body for arrays of rotations, such as AMASS files. FILE is a model of SMPL, SMPL-H or SMPL-X (.npz
            or .pkl), or a file of any format with a figure. For arrays of a robot, FILE is the robot. Default: generic
            proportions, 1.70 m tall.
        clip: The animation to use of a file that has several: its name, or its number from 0; name:3 is the
            animation whose name is 3. With all, a command for one motion uses the first.
        format: Format of the input. Default: found from its contents, or else from its extension.
        joints: The joints of a file of positions, to solve their rotations. A JSON file, or one of smpl22, smpl24,
            coco17, h36m, mediapipe33, openpose25, mhr70, mhr127. Default: arrays with the joints of SMPL are solved.
        lengths: Lengths of bones that are solved from positions: the median over all frames; or the length in each
            frame, so that joints match their positions.
            ``"median"``: The median of each length over the frames: bones keep their lengths, and joints are near
                their points.
            ``"moving"``: The lengths of each frame: joints are at their points, and bones change their lengths.
        markers: Solve a skeleton from the markers of a file. auto: a known marker set; auto:NAME: the markers of
            one subject; FILE: a JSON object from labels to landmarks. Default: markers stay points.
        retime: Play at this number of frames per second: the motion keeps its frames, and becomes slower or faster.
        root_offset: How the root's OFFSET and its position channels combine.
            ``"auto"``: Adds in two cases. The root's position is near zero in the first frame or in the median of
                all frames, but the OFFSET is not zero. Or the position stays near zero along an OFFSET that puts the
                feet on the floor. Otherwise, replaces.
            ``"replace"``: The position channels replace the OFFSET, as in Assimp and Blender.
            ``"add"``: The position channels are added to the OFFSET.
        skeleton: The skeleton of an .amc motion. Default: the .asf file in its folder with the same prefix, or the
            only .asf file.
        static: A static trial: markers of a standing person. It may have more markers than the motion.
        strict: Treat every warning as an error.
        hash: Compute the SHA-256 of the file, for the provenance; without, it is empty.

    Raises:
        MocapError: As :func:`read`.
    """
    return Scene(_mocap.read_bytes(data, name, ReadOptions(
        all_rows=all_rows,
        body=body,
        clip=clip,
        format=format,
        joints=joints,
        lengths=lengths,
        markers=markers,
        retime=retime,
        root_offset=root_offset,
        skeleton=skeleton,
        static=static,
        strict=strict,
        hash=hash,
    )))


@public
def convert(
    source: SceneLike,
    target: StrPath,
    *,
    drop_first_frame: Literal["auto", "yes", "no"] = "no",
    fps: float | None = None,
    rest: str | None = None,
    root: Literal["keep", "in-place", "extract"] = "keep",
    t_pose_first: bool = False,
    trim: TimeRange | None = None,
    bones: Bones | StrPath | None = None,
    unit: Unit | float | None = None,
    up: Axis | None = None,
    bone_axis: Literal["y", "x", "none"] | None = None,
    channels: Literal["auto", "3", "6"] = "auto",
    digits: int | None = None,
    order: Literal["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"] | None = None,
    sidecar: bool = False,
    embed: bool = False,
    fbx_rest: Literal["rotation", "pre-rotation"] | None = None,
    fbx_version: Literal["7.4", "7.5"] = "7.5",
    fbx_target: Literal["blender", "unreal", "unity", "maya", "motionbuilder"] | None = None,
    textures: Literal["embedded", "beside"] = "embedded",
    overwrite: bool = False,
    keep_constant: bool = False,
    mesh: Literal["segmented", "skinned", "none"] | None = None,
    names: Literal["vrm", "mixamo", "unreal", "cmu", "godot", "unity", "mhr", "soma"] | StrPath | Bones | None = None,
    skeleton_only: bool = False,
    compress: Literal["none", "int16", "meshopt", "meshopt-khr"] | None = None,
    max_error: float | None = None,
    shell_distance: float | None = None,
    out_unit: Unit | float | None = None,
    out_up: Literal["y", "z"] | None = None,
    to: StrPath | None = None,
    all_rows: bool = False,
    body: StrPath | None = None,
    clip: int | str | None = None,
    format: Format | None = None,
    joints: StrPath | None = None,
    lengths: Literal["median", "moving"] | None = None,
    markers: StrPath | None = None,
    retime: float | None = None,
    root_offset: Literal["auto", "replace", "add"] = "auto",
    skeleton: StrPath | None = None,
    static: StrPath | None = None,
    strict: bool = False,
    weights: Weights | None = None,
) -> int:
    """Writes a motion in the format of the target's extension, as ``mocap formats`` lists them; returns the bytes
    written. glTF, VRM animations and packed clips are in metres with +Y up, FBX says what it is in, and BVH keeps the
    unit and the axes of its source.

    Args:
        source: The motion file, or a scene; options of reading are for files alone.
        target: The file to write; it is whole or absent. A file that may be somebody's source is not replaced.
        drop_first_frame: Whether to drop the first frame; auto: drop it if it is a rest pose and the motion jumps
            after it.
            ``"auto"``: Drop the first frame if it is a rest pose and the motion jumps after it.
            ``"yes"``: Drop the first frame.
            ``"no"``: Keep the first frame.
        fps: Resample to this number of frames per second, at the same playback speed. For an input without a valid
            rate, set its rate.
        rest: Rest pose: zero (as in the file; in BVH all rotations are 0), t-pose, a-pose (arms 45 degrees down),
            or frame:N.
        root: The root motion: kept, removed, or moved to a joint above the root.
            ``"keep"``: Keep root motion in the root joint.
            ``"in-place"``: Remove root motion.
            ``"extract"``: Move root motion to a new joint above the root.
        t_pose_first: Insert the T-pose before the first frame, on the floor.
        trim: Part to keep, both ends included: A..B in seconds, or Af..Bf in frames; either end is optional.
        bones: The joint of each bone, if the guess is wrong: a JSON file, or the names here.
        unit: Unit of length of the input: auto, m, dm, cm, mm, inch, cmu (5.6444 cm), or metres in one unit.
        up: The up axis of the input; auto: from the feet to the head.
        bone_axis: Rotate the axes of joints at rest so that this axis points along the bone, and another is the
            bending axis. Positions do not change. Blender draws bones along +Y. Default: none; for the target blender
            y.
            ``"y"``: +Y, as Blender draws bones; joints bend about +X.
            ``"x"``: +X, as in Unreal; joints bend about +Z.
            ``"none"``: Joints keep the axes of the input.
        channels: Which joints have position channels.
            ``"auto"``: The ROOT, and joints whose position differs from their OFFSET in some frame.
            ``"3"``: Only the ROOT. Other joints keep their position of the first frame, and their position motion
                is lost.
            ``"6"``: Every joint.
        digits: Decimals of every number. Default: enough to read back the same motion.
        order: Order of the rotation channels. Default: each joint's own, or else ZXY.
        sidecar: For a .bvh OUTPUT, also write OUTPUT.json with its provenance. Every command reads this file,
            including verify.
        embed: Embed the buffer in a .gltf file, instead of writing a separate .bin file.
        fbx_rest: Where to store the rotations of the rest pose. Default: rotation; for the target maya
            pre-rotation.
            ``"rotation"``: ``Lcl Rotation``, as Blender writes: curves have the complete rotation.
            ``"pre-rotation"``: ``PreRotation``, which Maya shows as joint orient: all rotations of the rest pose
                are zero. Assimp 5.2 applies the pre-rotation of animated joints twice.
        fbx_version: Version of the file.
            ``"7.4"``: 7.4, of FBX 2014 and 2015: files of at most 4 GiB.
            ``"7.5"``: 7.5, of FBX 2016 and newer.
        fbx_target: The program whose conventions the file follows: unit, axes, root, frame rate.
            ``"blender"``: Blender: centimetres with +Y up, and +Y of joints along their bones unless an option sets
                the bone axis.
            ``"unreal"``: Unreal Engine: centimetres with +Z up, no node above the skeleton, a whole frame rate.
            ``"unity"``: Unity: metres with +Y up.
            ``"maya"``: Maya: centimetres with +Y up, the rest pose as joint orient.
            ``"motionbuilder"``: MotionBuilder: centimetres with +Y up, a root named ``Reference``, a whole frame
                rate.
        textures: Where to store the images of textures.
            ``"embedded"``: In the file itself.
            ``"beside"``: In separate files beside the FBX file.
        overwrite: Whether the output may replace a file that may be a source. An input is never replaced.
        keep_constant: Keep constant tracks in the animation. By default they become part of the rest pose.
        mesh: How to draw the skeleton of a file without meshes. Default: skinned; for .fbx none.
            ``"segmented"``: One mesh per node.
            ``"skinned"``: One mesh with bones.
            ``"none"``: No mesh.
        names: Names of joints in the output: vrm, mixamo, unreal, cmu, godot, unity, mhr, soma, or a JSON file. The
            file has {"bones": {"hips": "NAME", ...}}, as ``mocap skeleton --json`` prints. Default: the names in the
            input.
        skeleton_only: Write only the skeleton and its motion, without the meshes, materials and other contents of
            the input.
        compress: How to store the keys. Default with a largest error: int16, otherwise none.
            ``"none"``: 32-bit floats, which every client reads.
            ``"int16"``: Rotations as 16-bit normalised integers, half the size. This is core glTF without an
                extension, but Assimp reads wrong values.
            ``"meshopt"``: Streams of ``EXT_meshopt_compression``, which the file then requires. Needs the feature
                ``meshopt``.
            ``"meshopt-khr"``: Streams of ``KHR_meshopt_compression`` version 1, slightly smaller. The file then
                requires the extension. Needs the feature ``meshopt``.
        max_error: Remove keys and bits, but keep every joint and end site within this distance of its position in
            every frame, in metres. Fails if the format cannot keep this distance. Default with a compression: 1mm.
        shell_distance: Also keep points at this distance around each joint, such as the skin, within the largest
            error. ACL uses 3cm. Default: 0, only joints and end sites.
        out_unit: Unit of length of the output: m, dm, cm, mm, inch, cmu, or metres in one unit. Default: the
            input's; glTF is in metres.
        out_up: Up axis of the output. Default: the input's; glTF has +Y up.
            ``"y"``: +Y.
            ``"z"``: +Z.
        to: The output format, as a file extension, if it differs from the extension of the output. Or the name of
            an array layout, such as amass, humanml3d, qpos or gmr.
        all_rows: Read all rows of the motion, including those beyond the declared number of frames.
        body: The body for arrays of rotations, such as AMASS files. FILE is a model of SMPL, SMPL-H or SMPL-X (.npz
            or .pkl), or a file of any format with a figure. For arrays of a robot, FILE is the robot. Default: generic
            proportions, 1.70 m tall.
        clip: The animation to use of a file that has several: its name, or its number from 0; name:3 is the
            animation whose name is 3. With all, a command for one motion uses the first.
        format: Format of the input. Default: found from its contents, or else from its extension.
        joints: The joints of a file of positions, to solve their rotations. A JSON file, or one of smpl22, smpl24,
            coco17, h36m, mediapipe33, openpose25, mhr70, mhr127. Default: arrays with the joints of SMPL are solved.
        lengths: Lengths of bones that are solved from positions: the median over all frames; or the length in each
            frame, so that joints match their positions.
            ``"median"``: The median of each length over the frames: bones keep their lengths, and joints are near
                their points.
            ``"moving"``: The lengths of each frame: joints are at their points, and bones change their lengths.
        markers: Solve a skeleton from the markers of a file. auto: a known marker set; auto:NAME: the markers of
            one subject; FILE: a JSON object from labels to landmarks. Default: markers stay points.
        retime: Play at this number of frames per second: the motion keeps its frames, and becomes slower or faster.
        root_offset: How the root's OFFSET and its position channels combine.
            ``"auto"``: Adds in two cases. The root's position is near zero in the first frame or in the median of
                all frames, but the OFFSET is not zero. Or the position stays near zero along an OFFSET that puts the
                feet on the floor. Otherwise, replaces.
            ``"replace"``: The position channels replace the OFFSET, as in Assimp and Blender.
            ``"add"``: The position channels are added to the OFFSET.
        skeleton: The skeleton of an .amc motion. Default: the .asf file in its folder with the same prefix, or the
            only .asf file.
        static: A static trial: markers of a standing person. It may have more markers than the motion.
        strict: Treat every warning as an error.
        weights: The weights of solvers that differ from their defaults, as ``{"markers": {"slide": 0.02}}``;
            docs/weights.md lists them.

    Raises:
        MocapError: Where the source cannot be read or the target cannot be written.
        ValueError: Where no written format has the extension, or an option has no effect on it.
    """
    read = ReadOptions(
        all_rows=all_rows,
        body=body,
        clip=clip,
        format=format,
        joints=joints,
        lengths=lengths,
        markers=markers,
        retime=retime,
        root_offset=root_offset,
        skeleton=skeleton,
        static=static,
        strict=strict,
    )
    write = WriteOptions(
        bone_axis=bone_axis,
        channels=channels,
        digits=digits,
        order=order,
        sidecar=sidecar,
        embed=embed,
        fbx_rest=fbx_rest,
        fbx_version=fbx_version,
        fbx_target=fbx_target,
        textures=textures,
        overwrite=overwrite,
        keep_constant=keep_constant,
        mesh=mesh,
        names=names,
        skeleton_only=skeleton_only,
        compress=compress,
        max_error=max_error,
        shell_distance=shell_distance,
        out_unit=out_unit,
        out_up=out_up,
        to=to,
    )
    job = {
        "read": read.to_job(),
        "source": part(
            ("frames/drop-first-frame", drop_first_frame),
            ("frames/fps", fps),
            ("frames/rest", rest),
            ("frames/root", root),
            ("frames/t-pose-first", t_pose_first),
            ("frames/trim", time_range(trim)),
            ("map", bones),
            ("space/unit", unit),
            ("space/up", up),
        ),
        "write": write.to_job(),
        "weights": weights_of(weights),
    }
    return converted(source, target, job)


@public
def write(
    scene: SceneLike,
    target: StrPath,
    *,
    bone_axis: Literal["y", "x", "none"] | None = None,
    channels: Literal["auto", "3", "6"] = "auto",
    digits: int | None = None,
    order: Literal["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"] | None = None,
    sidecar: bool = False,
    embed: bool = False,
    fbx_rest: Literal["rotation", "pre-rotation"] | None = None,
    fbx_version: Literal["7.4", "7.5"] = "7.5",
    fbx_target: Literal["blender", "unreal", "unity", "maya", "motionbuilder"] | None = None,
    textures: Literal["embedded", "beside"] = "embedded",
    overwrite: bool = False,
    keep_constant: bool = False,
    mesh: Literal["segmented", "skinned", "none"] | None = None,
    names: Literal["vrm", "mixamo", "unreal", "cmu", "godot", "unity", "mhr", "soma"] | StrPath | Bones | None = None,
    skeleton_only: bool = False,
    compress: Literal["none", "int16", "meshopt", "meshopt-khr"] | None = None,
    max_error: float | None = None,
    shell_distance: float | None = None,
    out_unit: Unit | float | None = None,
    out_up: Literal["y", "z"] | None = None,
    to: StrPath | None = None,
) -> None:
    """Writes a scene in the format of the target's extension, as ``mocap formats`` lists them; the file is whole or
    absent. A file that may be somebody's source is not replaced.

    glTF and FBX record the steps; BVH and ``.mclip`` have no field for them.

    Args:
        scene: The scene, or a motion file.
        target: The file to write; it is whole or absent. A file that may be somebody's source is not replaced.
        bone_axis: Rotate the axes of joints at rest so that this axis points along the bone, and another is the
            bending axis. Positions do not change. Blender draws bones along +Y. Default: none; for the target blender
            y.
            ``"y"``: +Y, as Blender draws bones; joints bend about +X.
            ``"x"``: +X, as in Unreal; joints bend about +Z.
            ``"none"``: Joints keep the axes of the input.
        channels: Which joints have position channels.
            ``"auto"``: The ROOT, and joints whose position differs from their OFFSET in some frame.
            ``"3"``: Only the ROOT. Other joints keep their position of the first frame, and their position motion
                is lost.
            ``"6"``: Every joint.
        digits: Decimals of every number. Default: enough to read back the same motion.
        order: Order of the rotation channels. Default: each joint's own, or else ZXY.
        sidecar: For a .bvh OUTPUT, also write OUTPUT.json with its provenance. Every command reads this file,
            including verify.
        embed: Embed the buffer in a .gltf file, instead of writing a separate .bin file.
        fbx_rest: Where to store the rotations of the rest pose. Default: rotation; for the target maya
            pre-rotation.
            ``"rotation"``: ``Lcl Rotation``, as Blender writes: curves have the complete rotation.
            ``"pre-rotation"``: ``PreRotation``, which Maya shows as joint orient: all rotations of the rest pose
                are zero. Assimp 5.2 applies the pre-rotation of animated joints twice.
        fbx_version: Version of the file.
            ``"7.4"``: 7.4, of FBX 2014 and 2015: files of at most 4 GiB.
            ``"7.5"``: 7.5, of FBX 2016 and newer.
        fbx_target: The program whose conventions the file follows: unit, axes, root, frame rate.
            ``"blender"``: Blender: centimetres with +Y up, and +Y of joints along their bones unless an option sets
                the bone axis.
            ``"unreal"``: Unreal Engine: centimetres with +Z up, no node above the skeleton, a whole frame rate.
            ``"unity"``: Unity: metres with +Y up.
            ``"maya"``: Maya: centimetres with +Y up, the rest pose as joint orient.
            ``"motionbuilder"``: MotionBuilder: centimetres with +Y up, a root named ``Reference``, a whole frame
                rate.
        textures: Where to store the images of textures.
            ``"embedded"``: In the file itself.
            ``"beside"``: In separate files beside the FBX file.
        overwrite: Whether the output may replace a file that may be a source. An input is never replaced.
        keep_constant: Keep constant tracks in the animation. By default they become part of the rest pose.
        mesh: How to draw the skeleton of a file without meshes. Default: skinned; for .fbx none.
            ``"segmented"``: One mesh per node.
            ``"skinned"``: One mesh with bones.
            ``"none"``: No mesh.
        names: Names of joints in the output: vrm, mixamo, unreal, cmu, godot, unity, mhr, soma, or a JSON file. The
            file has {"bones": {"hips": "NAME", ...}}, as ``mocap skeleton --json`` prints. Default: the names in the
            input.
        skeleton_only: Write only the skeleton and its motion, without the meshes, materials and other contents of
            the input.
        compress: How to store the keys. Default with a largest error: int16, otherwise none.
            ``"none"``: 32-bit floats, which every client reads.
            ``"int16"``: Rotations as 16-bit normalised integers, half the size. This is core glTF without an
                extension, but Assimp reads wrong values.
            ``"meshopt"``: Streams of ``EXT_meshopt_compression``, which the file then requires. Needs the feature
                ``meshopt``.
            ``"meshopt-khr"``: Streams of ``KHR_meshopt_compression`` version 1, slightly smaller. The file then
                requires the extension. Needs the feature ``meshopt``.
        max_error: Remove keys and bits, but keep every joint and end site within this distance of its position in
            every frame, in metres. Fails if the format cannot keep this distance. Default with a compression: 1mm.
        shell_distance: Also keep points at this distance around each joint, such as the skin, within the largest
            error. ACL uses 3cm. Default: 0, only joints and end sites.
        out_unit: Unit of length of the output: m, dm, cm, mm, inch, cmu, or metres in one unit. Default: the
            input's; glTF is in metres.
        out_up: Up axis of the output. Default: the input's; glTF has +Y up.
            ``"y"``: +Y.
            ``"z"``: +Z.
        to: The output format, as a file extension, if it differs from the extension of the output. Or the name of
            an array layout, such as amass, humanml3d, qpos or gmr.

    Raises:
        MocapError: Where the target cannot be written.
        ValueError: Where no written format has the extension, or an option has no effect on it.
    """
    options = WriteOptions(
        bone_axis=bone_axis,
        channels=channels,
        digits=digits,
        order=order,
        sidecar=sidecar,
        embed=embed,
        fbx_rest=fbx_rest,
        fbx_version=fbx_version,
        fbx_target=fbx_target,
        textures=textures,
        overwrite=overwrite,
        keep_constant=keep_constant,
        mesh=mesh,
        names=names,
        skeleton_only=skeleton_only,
        compress=compress,
        max_error=max_error,
        shell_distance=shell_distance,
        out_unit=out_unit,
        out_up=out_up,
        to=to,
    )
    written(scene, target, options)
