# Written by `MOCAP_WRITE=1 cargo test -p mocap-bindings`, from the documentation of Rust: do not edit.
"""How files are read and written, as a job has it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from ._options import Axis, Bones, StrPath, Unit, as_json, part

Format = Literal[
    "bvh",
    "gltf",
    "vrma",
    "asf-amc",
    "c3d",
    "trc",
    "fbx",
    "usd",
    "vmd",
    "pmx",
    "bip",
    "urdf",
    "mjcf",
    "mclip",
    "npz",
    "npy",
    "torch",
    "pickle",
    "csv",
    "parquet",
    "mot",
]


@dataclass(frozen=True, kw_only=True)
class ReadOptions:
    """How to read a file.

    Attributes:
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
    """

    all_rows: bool = False
    body: StrPath | None = None
    clip: int | str | None = None
    format: Format | None = None
    joints: StrPath | None = None
    lengths: Literal["median", "moving"] | None = None
    markers: StrPath | None = None
    retime: float | None = None
    root_offset: Literal["auto", "replace", "add"] = "auto"
    skeleton: StrPath | None = None
    static: StrPath | None = None
    strict: bool = False
    hash: bool = True

    def to_job(self) -> dict[str, Any]:
        """The part ``read`` of a job."""
        return part(
            ("all-rows", self.all_rows),
            ("body", self.body),
            ("clip", self.clip),
            ("from", self.format),
            ("joints", self.joints),
            ("lengths", self.lengths),
            ("markers", self.markers),
            ("retime", self.retime),
            ("root-offset", self.root_offset),
            ("skeleton", self.skeleton),
            ("static", self.static),
            ("strict", self.strict),
        )

    @property
    def json(self) -> str:
        """That part as JSON, as the native half reads it."""
        return as_json(self.to_job())


@dataclass(frozen=True, kw_only=True)
class WriteOptions:
    """How to write a file.

    Attributes:
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
    """

    bone_axis: Literal["y", "x", "none"] | None = None
    channels: Literal["auto", "3", "6"] = "auto"
    digits: int | None = None
    order: Literal["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"] | None = None
    sidecar: bool = False
    embed: bool = False
    fbx_rest: Literal["rotation", "pre-rotation"] | None = None
    fbx_version: Literal["7.4", "7.5"] = "7.5"
    fbx_target: Literal["blender", "unreal", "unity", "maya", "motionbuilder"] | None = None
    textures: Literal["embedded", "beside"] = "embedded"
    overwrite: bool = False
    keep_constant: bool = False
    mesh: Literal["segmented", "skinned", "none"] | None = None
    names: Literal["vrm", "mixamo", "unreal", "cmu", "godot", "unity", "mhr", "soma"] | StrPath | Bones | None = None
    skeleton_only: bool = False
    compress: Literal["none", "int16", "meshopt", "meshopt-khr"] | None = None
    max_error: float | None = None
    shell_distance: float | None = None
    out_unit: Unit | float | None = None
    out_up: Literal["y", "z"] | None = None
    to: StrPath | None = None

    def to_job(self) -> dict[str, Any]:
        """The part ``write`` of a job."""
        return part(
            ("bone-axis", self.bone_axis),
            ("bvh/channels", self.channels),
            ("bvh/digits", self.digits),
            ("bvh/order", self.order),
            ("bvh/sidecar", self.sidecar),
            ("embed", self.embed),
            ("fbx/fbx-rest", self.fbx_rest),
            ("fbx/fbx-version", self.fbx_version),
            ("fbx/target", self.fbx_target),
            ("fbx/textures", self.textures),
            ("force", self.overwrite),
            ("keep-constant", self.keep_constant),
            ("mesh", self.mesh),
            ("names", self.names),
            ("skeleton-only", self.skeleton_only),
            ("smaller/compress", self.compress),
            ("smaller/max-error", self.max_error),
            ("smaller/shell-distance", self.shell_distance),
            ("space/out-unit", self.out_unit),
            ("space/out-up", self.out_up),
            ("to", self.to),
        )

    @property
    def json(self) -> str:
        """That part as JSON, as the native half reads it."""
        return as_json(self.to_job())
