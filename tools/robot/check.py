"""Judges `mocap robot` with MuJoCo. For each robot and motion, it checks kinematics, soles and floor, sliding feet,
limits, and the directions of limbs. Prints a line per clip; the exit code is 1 if a bound is not kept."""

import argparse
import io
import json
import os
import pathlib
import resource
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET

import mujoco
import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
ROBOTS = {"g1": ("g1_29dof_rev_1_0.urdf", "g1_29dof_rev_1_0_nomesh.xml"), "h1": ("h1.urdf", "h1_nomesh.xml")}
SAMPLE = ["cmu_12_01_walk.bvh", "motionbuilder_vicon_walk.bvh", "mocopi_jump_six_channels.bvh"]
LIMBS = {
    "UpperLeg": "LowerLeg",
    "LowerLeg": "Foot",
    "UpperArm": "LowerArm",
    "LowerArm": "Hand",
}
DOWN = np.array([0.0, 0.0, -1.0])


def rotate(quats, vector):
    """A vector, rotated by the rotation (w x y z) of each frame."""
    w, xyz = quats[:, :1], quats[:, 1:]
    t = 2 * np.cross(xyz, vector)
    return vector + w * t + np.cross(xyz, t)


def soles(urdf):
    """Points of the soles in the frames of the feet, from the collision shapes of the URDF: (link, centre, radius)."""
    found = {}
    for link in ET.parse(urdf).getroot().findall("link"):
        name = link.get("name")
        if not name.endswith(("ankle_roll_link", "ankle_link")):
            continue
        for shape in link.findall("collision"):
            origin = shape.find("origin")
            at = np.array([float(x) for x in origin.get("xyz").split()])
            assert not any(float(x) for x in origin.get("rpy", "0 0 0").split())
            sphere, box = shape.find("geometry/sphere"), shape.find("geometry/box")
            points = found.setdefault(name, [])
            if sphere is not None:
                points.append((at, float(sphere.get("radius"))))
            elif box is not None:
                half = 0.5 * np.array([float(x) for x in box.get("size").split()])
                signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).T.reshape(-1, 3)
                points.extend((at + sign * half, 0.0) for sign in signs)
    assert len(found) == 2 and all(found.values()), found
    return found


def shapes(urdf):
    """MuJoCo's model of the colliding shapes in a URDF; None if some are meshes, whose files are missing."""
    robot = ET.parse(urdf).getroot()
    if robot.find("link/collision/geometry/mesh") is not None:
        return None
    for element in robot.findall("mujoco"):
        robot.remove(element)
    for link in robot.findall("link"):
        for seen in link.findall("visual"):
            link.remove(seen)
    return mujoco.MjModel.from_xml_string(ET.tostring(robot, encoding="unicode"))


class Shapes:
    """The links of a robot that penetrate each other by more than 1 cm, by MuJoCo's contacts. As in the report,
    neighbours in the tree do not count, nor do links that touch with all joints at 0."""

    def __init__(self, model):
        self.model, self.data = model, mujoco.MjData(model)
        self.joints = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, joint) for joint in range(model.njnt)]
        self.at_rest = set(self.depths(np.zeros(model.nq)))

    def depths(self, positions):
        model, data = self.model, self.data
        data.qpos[:] = positions
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_collision(model, data)
        depths = {}
        for index in range(data.ncon):
            contact = data.contact[index]
            pair = tuple(sorted((model.geom_bodyid[contact.geom1], model.geom_bodyid[contact.geom2])))
            if model.body_parentid[pair[1]] != pair[0]:
                depths[pair] = max(depths.get(pair, 0.0), -contact.dist)
        return depths

    def share(self, names, dof_pos):
        order = [list(names).index(joint) for joint in self.joints]
        frames = (self.depths(positions) for positions in dof_pos[:, order])
        return float(
            np.mean([any(depth > 0.01 for pair, depth in frame.items() if pair not in self.at_rest) for frame in frames])
        )


def run(mocap, *arguments):
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run([mocap, *map(str, arguments)], capture_output=True, text=True)
    return done, resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


class Judge:
    def __init__(self, mocap, key):
        self.mocap, (urdf, mjcf) = mocap, ROBOTS[key]
        self.key = key
        self.urdf, self.mjcf = ROOT / "fixtures/robots" / urdf, ROOT / "fixtures/robots" / mjcf
        self.model = mujoco.MjModel.from_xml_path(str(self.mjcf))
        joints = [mujoco.mj_id2name(self.model, mujoco.mjtObj.mjOBJ_JOINT, joint) for joint in range(1, self.model.njnt)]
        self.joints = joints
        self.data = mujoco.MjData(self.model)
        self.soles = soles(self.urdf)
        model = shapes(self.urdf)
        self.shapes = Shapes(model) if model else None
        self.truth = json.loads((ROOT / "fixtures/robots/truth.json").read_text())["robots"][urdf]

    def body(self, name):
        return mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_BODY, name)

    def poses(self, qpos):
        """Positions and rotations of all bodies in all frames, by MuJoCo."""
        places = np.empty((len(qpos), self.model.nbody, 3))
        rotations = np.empty((len(qpos), self.model.nbody, 4))
        for frame, values in enumerate(qpos):
            self.data.qpos[:] = values
            mujoco.mj_kinematics(self.model, self.data)
            places[frame], rotations[frame] = self.data.xpos, self.data.xquat
        return places, rotations

    def links(self, motion, folder):
        """The names and the positions of the links, with +Z up, from the skeleton that `mocap` writes."""
        done, _ = run(self.mocap, "robot", motion, "--robot", self.urdf, "-o", folder / "links.glb")
        assert done.returncode == 0, done.stderr
        done, _ = run(self.mocap, "fk", folder / "links.glb", "-o", folder / "links.npz")
        assert done.returncode == 0, done.stderr
        arrays = np.load(folder / "links.npz")
        places = arrays["positions"].astype(float)
        return list(arrays["names"]), np.stack([places[..., 0], -places[..., 2], places[..., 1]], axis=-1)

    def limits(self, written):
        """Joint positions beyond the limits of the URDF. The limits of the MJCF have fewer digits."""
        beyond = 0
        limits = {joint.get("name"): joint.find("limit") for joint in ET.parse(self.urdf).getroot().findall("joint")}
        for index, name in enumerate(written["dof_names"]):
            low, high = float(limits[name].get("lower")), float(limits[name].get("upper"))
            values = written["dof_pos"][:, index]
            beyond += int(((values < low) | (values > high)).sum())
        return beyond

    def soles_at(self, places, rotations):
        """For the left and the right foot: positions and heights of the sole's points, frame by point."""
        for side, foot in enumerate(sorted(self.soles)):
            assert foot.startswith(["left", "right"][side])
            body = self.body(foot)
            points = np.stack([places[:, body] + rotate(rotations[:, body], at) for at, _ in self.soles[foot]], axis=1)
            yield points, points[:, :, 2] - np.array([radius for _, radius in self.soles[foot]])

    def feet(self, places, rotations, contacts, fps):
        """The fraction of frames with a sole more than 10 mm below the floor, the largest depth, and the speed of
        standing soles."""
        lowest, speeds = [], []
        for side, (points, heights) in enumerate(self.soles_at(places, rotations)):
            lowest.append(heights.min(axis=1))
            steps = np.linalg.norm(np.diff(points[:, :, :2], axis=0), axis=2) * fps
            # If a foot rolls, the slowest point of the sole stands.
            both = contacts[:-1, side] & contacts[1:, side]
            speeds.append(steps.min(axis=1)[both])
        lowest = np.min(lowest, axis=0)
        speeds = np.concatenate(speeds)
        return float((lowest < -0.01).mean()), float(-lowest.min()), float(speeds.mean()) if len(speeds) else None

    def limbs(self, rotations, source):
        """The mean angle of each limb between the robot in MuJoCo and the source, by the positions of joints."""
        angles = {}
        zero = self.truth["zero_pose_directions"]
        frames = min(len(rotations), len(next(iter(source.values()))))
        for side in ["left", "right"]:
            for bone, end in LIMBS.items():
                start = f"{side}{bone}"
                finish = f"{side}{end}"
                if start not in source or finish not in source or start not in zero:
                    continue
                # With all joints at 0, legs point along -Z; the truth has the directions of arms.
                at_rest = DOWN if "Leg" in bone else np.array(zero[start])
                is_link = rotate(rotations[:frames, self.body(self.truth["bones"][start]["link"])], at_rest)
                way = source[finish][:frames] - source[start][:frames]
                way = way / np.linalg.norm(way, axis=1, keepdims=True)
                cosine = np.clip((is_link * way).sum(axis=1) / np.linalg.norm(is_link, axis=1), -1, 1)
                angles[start] = float(np.degrees(np.arccos(cosine)).mean())
        return angles


def source_joints(mocap, motion, folder):
    """The positions of the source's bones in metres with +Y up, from the arrays of `mocap fk`."""
    done, _ = run(mocap, "convert", motion, folder / "source.glb", "--drop-first-frame", "auto", "--force")
    assert done.returncode == 0, done.stderr
    done, _ = run(mocap, "fk", folder / "source.glb", "-o", folder / "source.npz")
    assert done.returncode == 0, done.stderr
    done, _ = run(mocap, "skeleton", folder / "source.glb", "--json")
    found = json.loads(done.stdout)
    arrays = np.load(folder / "source.npz")
    names = list(arrays["names"])
    # The axes forward, left and up become +X, +Y and +Z.
    facing = found["facing"]["value"]
    if facing == "unknown":
        # The rest pose of the output may differ from the file's.
        done, _ = run(mocap, "skeleton", motion, "--json")
        original = json.loads(done.stdout)
        facing = original["facing"]["value"] if original["up"]["value"] == "y" else facing
    facing = facing if facing in ("x", "-x", "z", "-z") else "z"
    forward = (-1.0 if facing.startswith("-") else 1.0) * np.eye(3)["xyz".index(facing[-1])]
    up = np.array([0.0, 1.0, 0.0])
    axes = np.stack([forward, np.cross(up, forward), up])
    places = {}
    # Some devices name the sides as a mirror shows them; the robot moves as the body does.
    is_mirrored = found["sides"]["value"] == "opposite"
    other = {"left": "right", "right": "left"}
    for bone, joint in found["humanoid"]["bones"].items():
        side = next((side for side in other if is_mirrored and bone.startswith(side)), None)
        bone = other[side] + bone.removeprefix(side) if side else bone
        if names.count(joint["joint"]) == 1:
            places[bone] = arrays["positions"][:, names.index(joint["joint"])].astype(float) @ axes.T
    return places


# The extra sliding speed of standing soles that a stream may have over the source, in metres a second: a stream only
# sees 0.6 s at a time.
LIVE_SLIDE = 0.02


def live(judge, mocap, motion, folder, failures):
    """Streams a motion to the robot, and judges limits, floor, slide and limbs in the rows that `mocap play` prints."""
    done, _ = run(mocap, "robot", motion, "--robot", judge.urdf, "-o", folder / "a.npz", "--json")
    assert done.returncode == 0, done.stderr
    report, written = json.loads(done.stdout), np.load(folder / "a.npz")
    done, seconds = run(mocap, "play", motion, "--robot", judge.urdf)
    assert done.returncode == 0, done.stderr
    rows = np.loadtxt(io.StringIO(done.stdout), delimiter=",")
    # `mocap play` also plays a rest pose before the motion; the whole motion omits it.
    rows = rows[len(rows) - len(written["dof_pos"]) :]
    places, rotations = judge.poses(np.concatenate([rows[:, :3], rows[:, [6, 3, 4, 5]], rows[:, 7:]], axis=1))
    fps = float(written["fps"])
    share, deepest, skate = judge.feet(places, rotations, written["contacts"], fps)
    beyond = judge.limits({"dof_names": written["dof_names"], "dof_pos": rows[:, 7:]})
    mean = float(np.mean(list(judge.limbs(rotations, source_joints(mocap, motion, folder)).values())))
    apart = float(np.abs(rows[:, 7:] - written["dof_pos"]).mean())
    what, source = f"{judge.key} {motion.name} as it comes", report["source_skate"]
    for is_wrong, why in [
        (beyond > 0, f"{beyond} positions beyond a limit"),
        (share > 0.01, f"soles below the floor in {100 * share:.1f} % of frames"),
        (skate > source + LIVE_SLIDE, f"feet slide {100 * skate:.1f} cm/s, in the source {100 * source:.1f}"),
        (mean > 5, f"the mean limb error is {mean:.1f} degrees"),
    ]:
        if is_wrong:
            failures.append(f"{what}: {why}")
    print(
        f"{what}: limbs {mean:.2f} deg, joints {apart:.3f} rad from the whole motion, below {100 * share:.1f} % (deepest {1000 * deepest:.1f} mm), "
        f"slide {100 * skate:.2f} of {100 * source:.2f} cm/s, limits {beyond}, {1000 * seconds / len(rows):.2f} ms a frame"
    )


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--all", action="store_true", help="every motion of the folders")
    args = parser.parse_args()
    mocap = os.environ["MOCAP"]
    folders = os.environ.get("MOCAP_MOTIONS", str(ROOT / "fixtures/real")).split(":")
    motions = [path for folder in folders for path in sorted(pathlib.Path(folder).iterdir())]
    kinds = {".bvh", ".amc", ".fbx"}
    motions = [path for path in motions if path.suffix in kinds and (args.all or path.name in SAMPLE)]
    assert motions, folders
    failures = []
    for key in ROBOTS:
        judge = Judge(mocap, key)
        for motion in motions:
            with tempfile.TemporaryDirectory() as folder:
                line = check(judge, mocap, motion, pathlib.Path(folder), failures)
            if line:
                print(f"{key} {motion.name:36} {line}", flush=True)
        walk = next((motion for motion in motions if motion.name == SAMPLE[0]), None)
        if walk:
            with tempfile.TemporaryDirectory() as folder:
                live(judge, mocap, walk, pathlib.Path(folder), failures)
    for failure in failures:
        print("FAIL", failure)
    sys.exit(bool(failures))


def check(judge, mocap, motion, folder, failures):
    done, seconds = run(mocap, "robot", motion, "--robot", judge.urdf, "-o", folder / "a.npz", "--json")
    if done.returncode:
        return None if "not a humanoid" in done.stderr or "no motion" in done.stderr else f"refused: {done.stderr[:120]}"
    report = json.loads(done.stdout)
    written = np.load(folder / "a.npz")
    assert list(written["dof_names"]) == judge.joints, "the joints stand in another order than MuJoCo's"
    root = np.concatenate([written["root_pos"], written["root_rot"][:, [3, 0, 1, 2]]], axis=1)
    places, rotations = judge.poses(np.concatenate([root, written["dof_pos"]], axis=1))
    names, ours = judge.links(motion, folder)
    apart = 0.0
    for index in range(1, judge.model.nbody):
        link = ours[:, names.index(mujoco.mj_id2name(judge.model, mujoco.mjtObj.mjOBJ_BODY, index))]
        apart = max(apart, float(np.linalg.norm(places[:, index] - link, axis=1).max()))
    beyond = judge.limits(written)
    share, deepest, skate = judge.feet(places, rotations, written["contacts"], float(written["fps"]))
    angles = judge.limbs(rotations, source_joints(mocap, motion, folder))
    mean = float(np.mean(list(angles.values()))) if angles else float("nan")
    source = report["source_skate"]
    what = f"{judge.key} {motion.name}"
    if apart > 1e-4:
        failures.append(f"{what}: a link is {1000 * apart:.3f} mm from MuJoCo's")
    if beyond:
        failures.append(f"{what}: {beyond} positions beyond a limit")
    if share > 0.01:
        failures.append(f"{what}: soles below the floor in {100 * share:.1f} % of frames")
    if skate is not None and source is not None and skate > source + 0.005:
        failures.append(f"{what}: feet slide {100 * skate:.1f} cm/s, in the source {100 * source:.1f}")
    if "walk" in motion.name and mean > 5:
        failures.append(f"{what}: the mean limb error is {mean:.1f} degrees")
    collide = f"{100 * report['fraction_in_self_collision']:.1f}"
    if judge.shapes:
        by_contacts = judge.shapes.share(written["dof_names"], written["dof_pos"])
        collide += f" of {100 * by_contacts:.1f}"
        if abs(by_contacts - report["fraction_in_self_collision"]) > 0.05:
            failures.append(f"{what}: links collide in {collide} % of frames")
    slide = "-" if skate is None or source is None else f"{100 * skate:5.2f} of {100 * source:5.2f} cm/s"
    return (
        f"links {1000 * apart:.4f} mm, limbs {mean:5.2f} deg, below {100 * share:4.1f} % (deepest {1000 * deepest:6.1f} mm), "
        f"slide {slide}, collide {collide} %, limits {beyond}, {report['verdict']}, {report['frames'] / max(seconds, 1e-9):.0f} poses/s"
    )


if __name__ == "__main__":
    main()
