"""Judges the inverse dynamics of `mocap robot`. It compares `--to dynamics` with MuJoCo's `mj_inverse`. It compares the
residual force of the report with SciPy's nonnegative least squares over the soles of the URDF. Prints a row per clip;
the exit code is 1 if a bound is not kept.

    MOCAP=target/release/mocap tools/robot/.venv/bin/python tools/robot/dynamics.py [--sample | MOTION...] [-- OPTION...]

For walks in FEASIBLE, it also checks the fraction of feasible frames."""

import json
import os
import pathlib
import sys
import tempfile
import xml.etree.ElementTree as ET

import mujoco
import numpy as np
from scipy.optimize import nnls

from check import ROBOTS, ROOT, run, soles

# The largest difference from MuJoCo, as a fraction of 1 + the largest force of the kind; and the largest difference in
# the fraction of feasible frames.
EQUAL, SHARE = 1e-6, 0.01
# The definition of a feasible frame in docs/robots-report.md.
TOUCHING, SPARE_FORCE, SPARE_LEVER, FRICTION, GRAVITY = 0.02, 0.1, 0.05, 1.0, 9.81
# The least fraction of feasible frames, a little below the measured fraction. The target for all is 0.95.
FEASIBLE = {
    ("g1", "cmu_12_01_walk.bvh"): 0.95,
    ("h1", "cmu_12_01_walk.bvh"): 0.86,
}
WALKS = ["cmu_12_01_walk.bvh", "motionbuilder_vicon_walk.bvh", "makehuman_zombie_walk.bvh"]


def inverse(model, names, arrays):
    """The largest difference between mocap's and MuJoCo's forces, as a fraction, and MuJoCo's forces."""
    data = mujoco.MjData(model)
    joints = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, str(name)) for name in names]
    assert min(joints) > 0
    dof = np.concatenate([np.arange(6), model.jnt_dofadr[joints]])
    qpos = np.concatenate([np.arange(7), model.jnt_qposadr[joints]])
    theirs = np.empty_like(arrays["qfrc_inverse"])
    centres = np.empty((len(theirs), 3))
    for frame in range(len(theirs)):
        data.qpos[qpos], data.qvel[dof], data.qacc[dof] = (arrays[key][frame] for key in ("qpos", "qvel", "qacc"))
        mujoco.mj_inverse(model, data)
        theirs[frame] = data.qfrc_inverse[dof]
        centres[frame] = data.subtree_com[1]
    apart = np.abs(theirs - arrays["qfrc_inverse"])
    return max(float(apart[:, part].max() / (1 + np.abs(theirs[:, part]).max())) for part in (slice(3), slice(3, 6), slice(6, None))), theirs, centres


def of_urdf(path):
    """MuJoCo's model of the masses of a URDF on a base that floats."""
    robot = ET.parse(path).getroot()
    for element in robot.findall("mujoco"):
        robot.remove(element)
    for link in robot.findall("link"):
        for shape in link.findall("visual") + link.findall("collision"):
            link.remove(shape)
    mujoco_of = ET.SubElement(robot, "mujoco")
    ET.SubElement(mujoco_of, "compiler", fusestatic="false", balanceinertia="false")
    spec = mujoco.MjSpec.from_string(ET.tostring(robot, encoding="unicode"))
    spec.worldbody.first_body().add_freejoint()
    return alone(spec.compile())


def alone(model):
    """Only the inertia of the links: without contacts, limits, springs, dampers and the friction of joints."""
    disable = mujoco.mjtDisableBit
    model.opt.disableflags |= disable.mjDSBL_CONSTRAINT | disable.mjDSBL_SPRING | disable.mjDSBL_DAMPER
    return model


def rates(model, arrays):
    """The largest error of mocap's velocities against MuJoCo's difference of positions, as a fraction."""
    qpos, fps, worst = arrays["qpos"], float(arrays["fps"]), 0.0
    for frame in range(1, len(qpos) - 1):
        wanted = np.zeros(model.nv)
        mujoco.mj_differentiatePos(model, wanted, 1 / fps, qpos[frame], qpos[frame + 1])
        # MuJoCo gives the velocity half a step after the frame. mocap's velocity there is the mean of both frames, to
        # second order.
        ours = arrays["qvel"][frame] + 0.5 / fps * arrays["qacc"][frame]
        worst = max(worst, float(np.abs(ours - wanted).max() / (1 + np.abs(wanted).max())))
    return worst


def residuals(model, forces, centres, qpos, points):
    """The part of the base's force that soles on the floor cannot give, as a fraction of the weight, and of its moment,
    in metres."""
    data = mujoco.MjData(model)
    weight = GRAVITY * model.body_subtreemass[1]
    left = np.empty((len(qpos), 2))
    for frame, pose in enumerate(qpos):
        data.qpos[:] = pose
        mujoco.mj_kinematics(model, data)
        base, turn, centre = data.xpos[1], data.xmat[1].reshape(3, 3), centres[frame]
        force = forces[frame, :3]
        moment = turn @ forces[frame, 3:6] + np.cross(base - centre, force)
        unit = max(centre[2], 0.2)
        edges = []
        for foot, balls in points.items():
            body = model.body(foot).id
            for at, radius in balls:
                point = data.xpos[body] + data.xmat[body].reshape(3, 3) @ at - [0, 0, radius]
                if point[2] >= TOUCHING:
                    continue
                for angle in np.pi * np.array([0.25, 0.75, 1.25, 1.75]):
                    edge = np.array([FRICTION * np.cos(angle), FRICTION * np.sin(angle), 1])
                    edges.append(np.concatenate([edge, np.cross(point - centre, edge) / unit]))
        wanted = np.concatenate([force, moment / unit]) / weight
        if edges:
            matrix = np.array(edges).T
            wanted = wanted - matrix @ nnls(matrix, wanted)[0]
        left[frame] = np.linalg.norm(wanted[:3]), unit * np.linalg.norm(wanted[3:])
    return left


def main():
    mocap, arguments = os.environ["MOCAP"], sys.argv[1:]
    at = arguments.index("--") if "--" in arguments else len(arguments)
    motions, options = arguments[:at], arguments[at + 1 :]
    if motions == ["--sample"]:
        motions = [ROOT / "fixtures/real/cmu_short.bvh"]
    motions = [pathlib.Path(path) for path in motions] or [ROOT / "fixtures/real" / name for name in WALKS if (ROOT / "fixtures/real" / name).exists()]
    failed = False
    for key, (urdf, mjcf) in ROBOTS.items():
        urdf, mjcf = ROOT / "fixtures/robots" / urdf, ROOT / "fixtures/robots" / mjcf
        models = alone(mujoco.MjModel.from_xml_path(str(mjcf))), of_urdf(urdf)
        points = soles(urdf)
        for motion in motions:
            with tempfile.TemporaryDirectory() as folder:
                path = pathlib.Path(folder) / "a.npz"
                worst, speed = [], []
                # The soles come from the URDF, which is the last argument.
                for model, robot in zip(models, (mjcf, urdf)):
                    done, _ = run(mocap, "robot", motion, "--robot", robot, "-o", path, "--to", "dynamics", "--json", "--force", *options)
                    assert done.returncode == 0, done.stderr
                    report, arrays = json.loads(done.stdout)["dynamics"], dict(np.load(path))
                    apart, forces, centres = inverse(model, arrays["dof_names"], arrays)
                    worst.append(apart)
                    speed.append(rates(model, arrays))
                left = residuals(model, forces, centres, arrays["qpos"], points)
            feasible = float(((left[:, 0] <= SPARE_FORCE) & (left[:, 1] <= SPARE_LEVER)).mean())
            ok = max(worst + speed) <= EQUAL and abs(feasible - report["fraction_feasible"]) <= SHARE
            ok = ok and feasible >= FEASIBLE.get((key, motion.name), 0.0)
            failed |= not ok
            print(
                f"{'ok  ' if ok else 'FAIL'} {key} {motion.name}: {worst[0]:.1e} (MJCF) and {worst[1]:.1e} (URDF) from mj_inverse, velocities {max(speed):.1e}; "
                f"feasible {100 * report['fraction_feasible']:.1f} % (SciPy {100 * feasible:.1f} %), 95 % below {report['residual_force']:.3f} of the weight "
                f"({np.percentile(left[:, 0], 95):.3f}) and {100 * report['residual_lever']:.1f} cm ({100 * np.percentile(left[:, 1], 95):.1f}); "
                f"pressure outside {100 * (report['fraction_pressure_outside'] or 0):.1f} %, over effort {100 * (report['fraction_over_effort'] or 0):.2f} %, "
                f"{report['most_loaded_joint']} {report['max_effort']:.2f}", flush=True
            )  # fmt: skip
    sys.exit(failed)


if __name__ == "__main__":
    main()
