"""Builds small robots of the kinds in docs/robots-links.md, retargets a walk to each, and judges it with MuJoCo:
masses, limits, the lowest point of all shapes, floating feet. Prints a row per robot; the exit code is 1 if a bound is
not kept.

    MOCAP=target/release/mocap tools/robot/.venv/bin/python tools/robot/kinds.py [ROBOT.xml...]

Also judges the named MJCF models."""

import json
import os
import pathlib
import sys
import tempfile

import mujoco
import numpy as np

from check import ROOT, run

WALK = ROOT / "fixtures/real/cmu_12_01_walk.bvh"
SECONDS = "0..2"
# The allowed metres below the floor, and above it if no foot of a walk stands; and the fraction of frames that may
# exceed them.
BELOW, ABOVE, SHARE = 0.01, 0.05, 0.01
NEAR = 1e-6


def joint(name, axis, low=-150, high=150):
    return f'<joint name="{name}" axis="{axis}" range="{low} {high}"/>'


def leg(side, y, ankle, tilt):
    """A leg of 0.8 m. A tilted foot is tilted with all joints at 0; hip and knee are then bent by the same angle."""
    foot = f'<geom type="box" size="0.1 0.04 0.01" pos="0.04 0 -0.05"/>'
    joints = joint(f"{side}_ankle_y", "0 1 0", -60, 60) + joint(f"{side}_ankle_x", "1 0 0", -40, 40)
    end = {
        "joint": f'<body name="{side}_foot" pos="0 0 -0.4">{joints}{foot}</body>',
        "fixed": f'<body name="{side}_foot" pos="0 0 -0.4">{foot}</body>',
        "none": "",
    }[ankle]
    hips = "".join(joint(f"{side}_hip_{name}", axis) for name, axis in [("x", "1 0 0"), ("z", "0 0 1"), ("y", "0 1 0")])
    return f"""<body name="{side}_thigh" pos="0 {y} 0" euler="0 {-tilt} 0">{hips}
      <geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.05"/>
      <body name="{side}_shin" pos="0 0 -0.4" euler="0 {2 * tilt} 0">{joint(f"{side}_knee", "0 1 0", -5, 150)}
        <geom type="capsule" fromto="0 0 0 0 0 -0.36" size="0.04"/>{end}</body></body>"""


def arm(side, y, fingers):
    hand = ""
    if fingers:
        finger = lambda name, across: (
            f'<body name="{side}_{name}_0" pos="{across} 0 -0.05">{joint(f"{side}_{name}_0", "1 0 0")}<geom size="0.01"/>'
            f'<body name="{side}_{name}_1" pos="0 0 -0.03">{joint(f"{side}_{name}_1", "1 0 0")}<geom size="0.01"/>'
            f'<body name="{side}_{name}_2" pos="0 0 -0.03">{joint(f"{side}_{name}_2", "1 0 0")}<geom size="0.01"/></body></body></body>'
        )
        hand = f"""<body name="{side}_palm" pos="0 0 -0.24">{joint(f"{side}_wrist", "0 0 1")}<geom size="0.03"/>
          {finger("index", 0.03)}{finger("ring", -0.03)}</body>"""
    shoulder = "".join(joint(f"{side}_shoulder_{name}", axis) for name, axis in [("y", "0 1 0"), ("x", "1 0 0"), ("z", "0 0 1")])
    return f"""<body name="{side}_upper_arm" pos="0 {y} 0.35">{shoulder}<geom type="capsule" fromto="0 0 0 0 0 -0.25" size="0.03"/>
      <body name="{side}_forearm" pos="0 0 -0.25">{joint(f"{side}_elbow", "0 -1 0", -5, 150)}
        <geom type="capsule" fromto="0 0 0 0 0 -0.2" size="0.03"/>{hand}</body></body>"""


def robot(legs=True, ankle="joint", tilt=0, fingers=False):
    lower = leg("left", 0.1, ankle, tilt) + leg("right", -0.1, ankle, tilt) if legs else ""
    base = '<freejoint name="root"/>' if legs else ""
    return f"""<mujoco model="built"><worldbody><body name="pelvis" pos="0 0 1">{base}<geom type="box" size="0.05 0.1 0.05"/>
      <body name="torso" pos="0 0 0.1">{joint("waist", "0 0 1")}<geom type="box" size="0.05 0.1 0.15" pos="0 0 0.2"/>
        {arm("left", 0.15, fingers)}{arm("right", -0.15, fingers)}</body>
      {lower}</body></worldbody></mujoco>"""


KINDS = {
    "plain": robot(),
    "feet without a joint": robot(ankle="fixed"),
    "feet that are the shins": robot(ankle="none"),
    "feet tilted by 20 degrees": robot(tilt=20),
    "fingers": robot(fingers=True),
    "an upper body": robot(legs=False),
}


def lowest(model, data):
    """The lowest point of the shapes of a robot: distances to a plane at the height of the floor."""
    heights = []
    for geom in range(model.ngeom):
        if model.geom_bodyid[geom] == 0:
            continue
        place, up = data.geom_xpos[geom], data.geom_xmat[geom].reshape(3, 3)[2]
        size, kind = model.geom_size[geom], mujoco.mjtGeom(model.geom_type[geom])
        down = {
            mujoco.mjtGeom.mjGEOM_SPHERE: size[0],
            mujoco.mjtGeom.mjGEOM_CAPSULE: size[0] + abs(up[2]) * size[1],
            mujoco.mjtGeom.mjGEOM_BOX: np.abs(up) @ size,
            mujoco.mjtGeom.mjGEOM_ELLIPSOID: np.linalg.norm(up * size),
            mujoco.mjtGeom.mjGEOM_CYLINDER: abs(up[2]) * size[1] + size[0] * np.sqrt(max(0, 1 - up[2] ** 2)),
        }.get(kind)
        if kind == mujoco.mjtGeom.mjGEOM_MESH:
            mesh = model.geom_dataid[geom]
            first = model.mesh_vertadr[mesh]
            down = -(model.mesh_vert[first : first + model.mesh_vertnum[mesh]] @ up).min()
        if down is not None:
            heights.append(place[2] - down)
    return min(heights)


class Judge:
    def __init__(self, path):
        self.model = mujoco.MjModel.from_xml_path(str(path))
        self.data = mujoco.MjData(self.model)
        joints = range(self.model.njnt)
        self.free = next((j for j in joints if self.model.jnt_type[j] == mujoco.mjtJoint.mjJNT_FREE), None)
        names = [mujoco.mj_id2name(self.model, mujoco.mjtObj.mjOBJ_JOINT, j) for j in joints]
        self.joints = {name: j for j, name in enumerate(names) if j != self.free}

    def judge(self, arrays, report):
        """The faults of a motion, and the lowest point of the robot in each frame."""
        wrong, heights = [], []
        qpos, names = arrays["qpos"], [str(name) for name in arrays["dof_names"]]
        if set(names) != set(self.joints):
            wrong.append(f"other joints than MuJoCo's: {sorted(set(names) ^ set(self.joints))[:4]}")
            return wrong, np.zeros(1)
        for values in qpos:
            if self.free is not None:
                self.data.qpos[:7] = values[:7]
            for name, value in zip(names, values[7:]):
                index = self.joints[name]
                self.data.qpos[self.model.jnt_qposadr[index]] = value
                low, high = self.model.jnt_range[index]
                if self.model.jnt_limited[index] and not low - NEAR <= value <= high + NEAR:
                    wrong.append(f"{name} is at {value}, beyond {low} to {high}")
            mujoco.mj_kinematics(self.model, self.data)
            heights.append(lowest(self.model, self.data))
        heights = np.array(heights)
        if self.free is not None:
            for what, share in [("below", (heights < -BELOW).mean()), ("above", (heights > ABOVE).mean())]:
                if share > SHARE:
                    wrong.append(f"{100 * share:.1f} % of frames {what} the floor")
            mass, found = self.model.body_subtreemass[0], (report["dynamics"] or {}).get("mass")
            if found is None or abs(found - mass) > NEAR * mass:
                wrong.append(f"a mass of {found} kg, and {mass} by MuJoCo")
        return wrong, heights


def main():
    failures = 0
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        files = {}
        for name, text in KINDS.items():
            files[name] = folder / f"{name.replace(' ', '_')}.xml"
            files[name].write_text(text)
        files |= {pathlib.Path(path).name: pathlib.Path(path) for path in sys.argv[1:]}
        for name, path in files.items():
            out = folder / "a.npz"
            done, _ = run(
                os.environ["MOCAP"], "robot", WALK, "--robot", path, "-o", out, "--to", "qpos", "--force", "--json",
                "--trim", SECONDS, "--fps", 30,
            )  # fmt: skip
            if done.returncode:
                failures += 1
                print(f"FAIL {name}: {done.stderr.strip().splitlines()[0]}")
                continue
            report = json.loads(done.stdout)
            with np.load(out) as arrays:
                wrong, heights = Judge(path).judge(arrays, report)
            if report["mean_degrees"] > 10:
                wrong.append(f"mean limb error {report['mean_degrees']:.1f} degrees")
            failures += bool(wrong)
            print(f"{name:28} limbs {report['mean_degrees']:4.1f} deg, lowest {1000 * heights.min():6.1f} to {1000 * heights.max():5.1f} mm, {report['verdict']}")
            for line in wrong[:4]:
                print(f"FAIL {name}: {line}")
    sys.exit(bool(failures))


if __name__ == "__main__":
    main()
