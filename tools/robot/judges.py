"""The robots on which `peers.py` compares programs, and MuJoCo's measures of any program's motion on them."""

import functools
import json

import mujoco
import numpy as np

from check import ROOT, Judge, Shapes, rotate
from measure import WINDOW, jumps, source_rotations
from packages import LOCOMOTION, axes_of, corners_of, file_of, model_of, without_meshes
from track import HELPED_STIFFNESS, efforts, helped, with_servos

# A foot in the air scrapes the floor below this height (metres) if it is faster than this (metres a second).
SCRAPES_BELOW, SCRAPES_ABOVE = 0.005, 0.3
# A link farther below the floor than this, in metres, is too deep.
DEEP = 0.02
# The MJCF states its limits with five or six digits.
ROUNDING = 1e-5
# Links by the bone whose full rotation they have. GMR's configurations name these links or a link before them.
SIDES = {"left": ("left", "Left", "AL"), "right": ("right", "Right", "AR")}
LINKS = {
    "g1": {
        "UpperLeg": "{0}_hip_yaw_link", "LowerLeg": "{0}_knee_link", "Foot": "{0}_ankle_roll_link",
        "UpperArm": "{0}_shoulder_yaw_link", "LowerArm": "{0}_elbow_link", "Hand": "{0}_wrist_yaw_link",
    },
    "h1": {
        "UpperLeg": "{0}_hip_pitch_link", "LowerLeg": "{0}_knee_link", "Foot": "{0}_ankle_link",
        "UpperArm": "{0}_shoulder_yaw_link", "LowerArm": "{0}_elbow_link",
    },
    "t1": {
        "UpperLeg": "Hip_Yaw_{1}", "LowerLeg": "Shank_{1}", "Foot": "{0}_foot_link",
        "UpperArm": "{2}3", "LowerArm": "{0}_hand_link",
    },
}  # fmt: skip
TRUNKS = {
    "g1": {"hips": "pelvis", "chest": "torso_link"},
    "h1": {"hips": "pelvis", "chest": "torso_link"},
    "t1": {"hips": "Waist", "chest": "Trunk"},
}
# Joints that are not 0 when the robot stands with straight arms to the sides. T1 has this pose with all joints at 0.
QUARTER_TURN = np.pi / 2
ARMS_SIDEWAYS = {
    "left_shoulder_roll_joint": QUARTER_TURN, "right_shoulder_roll_joint": -QUARTER_TURN,
    "left_elbow_joint": QUARTER_TURN, "right_elbow_joint": QUARTER_TURN,
}  # fmt: skip
T_POSES = {"g1": ARMS_SIDEWAYS, "h1": ARMS_SIDEWAYS, "t1": {}}
KEYS = list(LINKS)
# Robots of MuJoCo Playground. The URDF of G1 needs meshes, which are missing: without shapes, no program can keep links
# apart.
PACKAGED = {"g1", "t1"}
FEET = {"g1": ["left_ankle_roll_link", "right_ankle_roll_link"], "t1": ["left_foot_link", "right_foot_link"]}


def joined(spec):
    """The model of only the links, whose shapes all collide with each other."""
    for joint in list(spec.joints):
        if joint.type == mujoco.mjtJoint.mjJNT_FREE:
            spec.delete(joint)
    for actuator in list(spec.actuators):
        spec.delete(actuator)
    for key in list(spec.keys):
        spec.delete(key)
    for geom in spec.geoms:
        geom.contype, geom.conaffinity = 1, 1
    return spec.compile()


def successive(model):
    """Pairs of links with shapes that are connected in the tree only through links without shapes."""
    for body in range(1, model.nbody):
        above = model.body_parentid[body]
        while above and not model.body_geomnum[above]:
            above = model.body_parentid[above]
        yield tuple(sorted((int(above), body)))


class Robot(Judge):
    """A robot with links named by bones, and the shapes of its links."""

    def __init__(self, mocap, key):
        if key in PACKAGED:
            self.of_package(mocap, key)
        else:
            super().__init__(mocap, key)
        self.links = dict(TRUNKS[key])
        for side, names in SIDES.items():
            self.links |= {f"{side}{bone}": link.format(*names) for bone, link in LINKS[key].items()}
        if key in PACKAGED:
            self.shapes = Shapes(joined(without_meshes(self.mjcf)))
        self.shapes.at_rest |= set(successive(self.shapes.model))
        self.surface = list(self.surfaces(self.shapes.model))

    def of_package(self, mocap, key):
        self.mocap, self.key, self.mjcf = mocap, key, file_of(LOCOMOTION, f"{key}/xmls/{key}_mjx_feetonly.xml")
        self.urdf = self.mjcf
        self.model = model_of(self.mjcf)
        self.data = mujoco.MjData(self.model)
        self.joints = [self.model.joint(index).name for index in range(1, self.model.njnt)]
        self.soles = {foot: list(self.points(foot)) for foot in FEET[key]}
        if key == "g1":
            self.truth = json.loads((ROOT / "fixtures/robots/truth.json").read_text())["robots"]["g1_29dof_rev_1_0.urdf"]
            return
        arms = {f"{side}{bone}": [0.0, sign, 0.0] for side, sign in [("left", 1.0), ("right", -1.0)] for bone in ["UpperArm", "LowerArm"]}
        legs = {f"{side}{bone}": [0.0, 0.0, -1.0] for side in ["left", "right"] for bone in ["UpperLeg", "LowerLeg"]}
        bones = {}
        for side, names in SIDES.items():
            bones |= {f"{side}{bone}": {"link": link.format(*names)} for bone, link in LINKS[key].items()}
        self.truth = {"zero_pose_directions": arms | legs, "bones": bones}

    def points(self, foot):
        """Points of the shapes of a foot, in the form of `check.soles`."""
        for geom in np.flatnonzero(self.model.geom_bodyid == self.body(foot)):
            kind = self.model.geom_type[geom]
            if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
                yield self.model.geom_pos[geom], self.model.geom_size[geom, 0]
            elif kind == mujoco.mjtGeom.mjGEOM_BOX:
                yield from ((corner, 0.0) for corner in corners_of(self.model, geom))

    def surfaces(self, model):
        """Shapes of all links except the feet, whose soles are known: link, kind, size, position, axes."""
        base = self.model.body(1).name
        for geom in range(model.ngeom):
            link = model.body(model.geom_bodyid[geom]).name if model.geom_bodyid[geom] else base
            kind = mujoco.mjtGeom(model.geom_type[geom])
            if link in self.soles or kind in (mujoco.mjtGeom.mjGEOM_PLANE, mujoco.mjtGeom.mjGEOM_MESH):
                continue
            yield self.body(link), kind, model.geom_size[geom], model.geom_pos[geom], axes_of(model, geom)

    def heights(self, places, rotations):
        """The height of the lowest point of each shape in each frame, and the names of their links."""
        found, names = [], []
        for _, heights in self.soles_at(places, rotations):
            found.append(heights.min(axis=1))
        names.extend(sorted(self.soles))
        kinds = mujoco.mjtGeom
        for body, kind, size, at, turn in self.surface:
            centre = places[:, body, 2] + rotate(rotations[:, body], at)[:, 2]
            back = rotations[:, body] * [1, -1, -1, -1]
            up = rotate(back, np.array([0.0, 0.0, 1.0])) @ turn
            down = {
                kinds.mjGEOM_SPHERE: lambda: size[0],
                kinds.mjGEOM_CAPSULE: lambda: size[0] + np.abs(up[:, 2]) * size[1],
                kinds.mjGEOM_BOX: lambda: np.abs(up) @ size,
                kinds.mjGEOM_CYLINDER: lambda: np.abs(up[:, 2]) * size[1] + size[0] * np.sqrt(np.maximum(0, 1 - up[:, 2] ** 2)),
            }[kind]()
            found.append(centre - down)
            names.append(self.model.body(body).name)
        return np.array(found).T, names

    def scraping(self, places, rotations, contacts, fps):
        """Frames in which each foot is in the air, and the frames among them in which it scrapes the floor."""
        swings, scrapes = [], []
        for side, (points, heights) in enumerate(self.soles_at(places, rotations)):
            lowest = heights.argmin(axis=1)[:-1]
            rows = np.arange(len(lowest))
            speed = np.linalg.norm((points[1:] - points[:-1])[rows, lowest, :2], axis=1) * fps
            swing = ~contacts[:-1, side] & ~contacts[1:, side]
            swings.append(swing)
            scrapes.append(swing & (heights[rows, lowest] < SCRAPES_BELOW) & (speed > SCRAPES_ABOVE))
        return np.array(swings), np.array(scrapes)

    def beyond(self, positions):
        """Positions beyond the limits, frame by joint."""
        low, high = self.model.jnt_range[1:].T
        return (positions < low - ROUNDING) | (positions > high + ROUNDING)

    @functools.cached_property
    def servos(self):
        """The robot on a floor, moved by servos within its effort limits."""
        of_file = dict(zip(self.joints, map(float, self.model.jnt_actfrcrange[1:, 1])))
        most = of_file if self.key in PACKAGED else efforts(self.urdf)
        spec = without_meshes(self.mjcf)
        for geom in spec.geoms:
            if geom.type != mujoco.mjtGeom.mjGEOM_PLANE:
                geom.contype, geom.conaffinity = 0, 0
        for key in list(spec.keys):
            spec.delete(key)
        return with_servos(spec, {name: most[name] for name in self.joints}, self.soles, HELPED_STIFFNESS)

    def row(self, qpos, contacts, fps, source, folder):
        """The measures of a motion. `folder` has the files of `source_joints`."""
        places, rotations = self.poses(qpos)
        _, _, slide = self.feet(places, rotations, contacts, fps)
        heights, links = self.heights(places, rotations)
        swings, scrapes = self.scraping(places, rotations, contacts, fps)
        angles = self.limbs(rotations, source)
        beyond = self.beyond(qpos[:, 7:])
        window = max(1, round(fps * WINDOW))
        names = [name.lower() for name in self.joints]
        share, jumped = jumps({"dof_pos": qpos[:, 7:], "dof_names": names}, source_rotations(folder, self.mocap, window), window)
        force, moment = helped(self.servos, self.joints, qpos, fps)
        deepest = int(heights.min(axis=1).argmin())
        return {
            "robot": self.key, "frames": len(qpos), "fps": fps, "limbs": float(np.mean(list(angles.values()))), "slide": slide,
            "swing": int(swings.sum()), "scraping": int(scrapes.sum()),
            "scraping_frames": np.flatnonzero(scrapes.any(axis=0)).tolist(),
            "deep": float((heights.min(axis=1) < -DEEP).mean()), "deepest": float(-heights.min()), "deepest_frame": deepest,
            "deepest_link": links[int(heights[deepest].argmin())],
            "beyond": int(beyond.sum()), "beyond_frames": np.flatnonzero(beyond.any(axis=1)).tolist()[:5],
            "jumps": share, "jumped": jumped,
            "collide": self.shapes.share(self.joints, qpos[:, 7:]), "force": force, "moment": moment,
        }  # fmt: skip
