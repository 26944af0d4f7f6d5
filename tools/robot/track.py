"""Plays a motion on a robot in MuJoCo. Proportional-derivative control moves the joints within the effort limits of the
URDF. Reports how long the robot stands, and its error until then. Nothing holds or balances the base, so most motions
fall: the result compares motions, but does not judge a single motion.

    MOCAP=target/release/mocap tools/robot/.venv/bin/python tools/robot/track.py MOTION... [--robot g1|h1] [-- OPTION...]

Options after `--` go to `mocap robot`."""

import argparse
import os
import pathlib
import subprocess
import tempfile
import xml.etree.ElementTree as ET

import mujoco
import numpy as np

from check import ROBOTS, ROOT, soles

# The simulation step in seconds; the gain, with the full effort at a third of a radian; and the damping relative to the
# gain.
STEP, STIFFNESS, DAMPING = 0.002, 3.0, 0.03
# The radius of the corner of a sole, in metres.
CORNER = 0.005
# The servos of `helped` give the full effort at a tenth of a radian. The spring at the base has an
# angular frequency in 1/s, at which the weight moves the base by 2.5 cm. GYRATION is a humanoid's radius of gyration in
# metres.
HELPED_STIFFNESS, SPRING, GYRATION = 10.0, 20.0, 0.3
# The robot has fallen if its base is lower than this fraction of the wanted height, or is tilted by more than this
# angle in radians.
LOWEST, FARTHEST = 0.6, 1.0


def efforts(urdf):
    limits = {joint.get("name"): joint.find("limit") for joint in ET.parse(urdf).getroot().findall("joint")}
    return {name: float(limit.get("effort")) for name, limit in limits.items() if limit is not None and limit.get("effort")}


def world(urdf, mjcf):
    """The robot on a floor, with a servo for each joint, whose force is at most its effort. The feet touch the floor
    with the soles of the URDF; the shapes of this model are meshes, which are omitted."""
    return with_servos(mujoco.MjSpec.from_file(str(mjcf)), efforts(urdf), soles(urdf))


def with_servos(spec, efforts, soles, stiffness=STIFFNESS):
    """A model on a floor with servos of these efforts, and these points of soles as the only shapes that touch the floor."""
    for actuator in list(spec.actuators):
        spec.delete(actuator)
    if not any(geom.type == mujoco.mjtGeom.mjGEOM_PLANE for geom in spec.worldbody.geoms):
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 0.05], friction=[1, 0.005, 0.0001], contype=1, conaffinity=1)
    for joint, most in efforts.items():
        kp = stiffness * most
        spec.add_actuator(
            name=joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT, gaintype=mujoco.mjtGain.mjGAIN_FIXED,
            biastype=mujoco.mjtBias.mjBIAS_AFFINE, gainprm=[kp] + [0] * 9, biasprm=[0, -kp, -DAMPING * kp] + [0] * 7,
            forcelimited=1, forcerange=[-most, most],
        )  # fmt: skip
    for foot, points in soles.items():
        for at, radius in points:
            radius = max(radius, CORNER)
            spec.body(foot).add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[radius, 0, 0], pos=at, mass=0, contype=1, conaffinity=1)
    model = spec.compile()
    model.opt.timestep = STEP
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    return model


def helped(model, names, qpos, fps):
    """The mean force (weights) and moment (weight metres) of a spring at the base that keeps the robot at the motion, while servos
    move its joints."""
    joints = [model.joint(str(name)).id for name in names]
    servos = [model.actuator(str(name)).id for name in names]
    mass = model.body_subtreemass[1]
    weight = mass * np.linalg.norm(model.opt.gravity)
    stiffness = mass * SPRING**2 * np.repeat([1.0, GYRATION**2], 3)
    damping = 2 * stiffness / SPRING
    # MuJoCo integrates the damping implicitly, because the base alone is too light for explicit damping.
    model.dof_damping[:6] = damping
    data = mujoco.MjData(model)
    data.qpos[:7], data.qpos[model.jnt_qposadr[joints]] = qpos[0, :7], qpos[0, 7:]
    velocity = np.zeros(6)
    helps, seconds = [], (len(qpos) - 1) / fps
    for step in range(int(seconds / STEP)):
        at = step * STEP * fps
        frame = min(int(at), len(qpos) - 2)
        now, after = qpos[frame], qpos[frame + 1]
        joint_velocity = (after[7:] - now[7:]) * fps
        data.ctrl[servos] = now[7:] + (at - frame) * (after[7:] - now[7:]) + DAMPING * joint_velocity
        velocity[:3] = (after[:3] - now[:3]) * fps
        mujoco.mju_subQuat(velocity[3:], after[3:7], now[3:7])
        velocity[3:] *= fps
        wanted = now[3:7].copy()
        mujoco.mju_quatIntegrate(wanted, velocity[3:], (at - frame) / fps)
        if step == 0:
            data.qvel[:6] = velocity
            data.qvel[model.jnt_dofadr[joints]] = joint_velocity
        turned = np.zeros(3)
        mujoco.mju_subQuat(turned, wanted, data.qpos[3:7])
        away = now[:3] + (at - frame) / fps * velocity[:3] - data.qpos[:3]
        # The angular velocity of a free joint is in the frame of its body.
        data.qfrc_applied[:6] = stiffness * np.concatenate([away, turned]) + damping * velocity
        spring = data.qfrc_applied[:6] - damping * data.qvel[:6]
        mujoco.mj_step(model, data)
        if not np.isfinite(data.qpos).all():
            return None, None
        helps.append((np.linalg.norm(spring[:3]) / weight, np.linalg.norm(spring[3:]) / weight))
    force, moment = np.mean(helps, axis=0)
    return float(force), float(moment)


def track(model, names, qpos, fps):
    """The seconds until the robot falls, whether it fell, and the mean error of joints (degrees) and of the base
    (metres) until then."""
    data = mujoco.MjData(model)
    joints = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, str(name)) for name in names]
    servos = [mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, str(name)) for name in names]
    assert min(joints) >= 0 and min(servos) >= 0, "a joint has no effort in the URDF"
    places = model.jnt_qposadr[joints]
    data.qpos[:] = qpos[0]
    mujoco.mj_differentiatePos(model, data.qvel, 1 / fps, qpos[0], qpos[min(1, len(qpos) - 1)])
    errors, apart, seconds = [], [], (len(qpos) - 1) / fps
    for step in range(int(seconds / STEP)):
        at = step * STEP * fps
        frame = min(int(at), len(qpos) - 2)
        wanted = qpos[frame, 7:] + (at - frame) * (qpos[frame + 1, 7:] - qpos[frame, 7:])
        velocity = (qpos[frame + 1, 7:] - qpos[frame, 7:]) * fps
        data.ctrl[servos] = wanted + DAMPING * velocity
        mujoco.mj_step(model, data)
        turned = 2 * np.arccos(min(1.0, abs(float(data.qpos[3:7] @ qpos[frame, 3:7]))))
        if data.qpos[2] < LOWEST * qpos[frame, 2] or turned > FARTHEST or not np.isfinite(data.qpos).all():
            return step * STEP, True, np.mean(errors or [0]), np.mean(apart or [0])
        errors.append(np.degrees(np.abs(wanted - data.qpos[places]).mean()))
        apart.append(np.linalg.norm(data.qpos[:3] - qpos[frame, :3]))
    return seconds, False, np.mean(errors or [0]), np.mean(apart or [0])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("motions", nargs="+", type=pathlib.Path)
    parser.add_argument("--robot", choices=ROBOTS, default="g1")
    args, options = parser.parse_known_args()
    urdf, mjcf = (ROOT / "fixtures/robots" / name for name in ROBOTS[args.robot])
    model = world(urdf, mjcf)
    for motion in args.motions:
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "a.npz"
            command = [os.environ["MOCAP"], "robot", motion, "--robot", urdf, "-o", path, "--to", "qpos", *options]
            done = subprocess.run([part for part in map(str, command) if part != "--"], capture_output=True, text=True)
            if done.returncode:
                print(f"{motion.name}: {done.stderr.strip().splitlines()[-1]}")
                continue
            with np.load(path) as arrays:
                seconds, fell, degrees, metres = track(model, arrays["dof_names"], arrays["qpos"], float(arrays["fps"]))
                whole = (len(arrays["qpos"]) - 1) / float(arrays["fps"])
            how = "falls after" if fell else "stands for all"
            print(f"{args.robot} {motion.name}: {how} {seconds:.2f} of {whole:.2f} s; until then joints {degrees:.1f} degrees and the base {100 * metres:.1f} cm off")


if __name__ == "__main__":
    main()
