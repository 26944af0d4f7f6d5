"""Unitree's G1 in MuJoCo: servos within its efforts, a balance controller, help at the pelvis, disturbances."""

import json
import pathlib
from dataclasses import dataclass, field

import mujoco
import numpy as np
import scipy.optimize

ROOT = pathlib.Path(__file__).resolve().parents[2]
URDF = ROOT / "fixtures/robots/g1_29dof_rev_1_0.urdf"
MJCF = ROOT / "fixtures/robots/g1_29dof_rev_1_0_nomesh.xml"
GAINS = pathlib.Path(__file__).with_name("gains.json")
# Seconds of a step of the simulation, and steps between two commands of the controller.
STEP, STEPS = 0.002, 5
# Torque of a servo by its error, in efforts per radian, and its damping against that, in seconds.
STIFFNESS, DAMPING = 3.0, 0.03
# Inertia of the rotor of each joint, in kg m2, which the file does not state; that of MuJoCo Menagerie's model of
# this robot.
ARMATURE = 0.01
# A floor that gives way by fractions of a millimetre: time in which a contact comes to rest, and MuJoCo's impedances.
FLOOR_SECONDS, FLOOR_STIFF = 0.01, [0.99, 0.995]
# Height of the lowest point of a sole that stands in the motion, in metres.
SOLE = 0.012
# The floor's friction in the torques of a motion, and the weight of the size of its forces beside what is left at the
# pelvis.
EDGE, SMALL_FORCES = 0.7, 0.02
# The robot has fallen where the pelvis is lower than this part of its height in the motion, or tilted by so many
# radians.
LOWEST, FARTHEST = 0.6, 1.0
# Help at the pelvis: its force by the distance and the velocity to the motion, in weights per metre and per metre a
# second; its moment, in weights times metres, per radian and per radian a second; the lever of the largest moment, in
# metres.
HELP_FORCE, HELP_MOMENT, HELP_LEVER = (4.0, 0.6), (0.6, 0.06), 0.3
# Seconds that a push lasts; density of the box in kg/m3, that of cardboard with things in it.
PUSH_SECONDS, BOX_DENSITY = 0.1, 200.0
# From the knee to the ankle, in metres.
SHIN, SHIN_RADIUS = [0, 0, 0, 0, 0, -0.3], 0.045


@dataclass
class Motion:
    """Poses as MuJoCo's `qpos`, frames a second, and what `Body.motion` finds of each frame."""

    qpos: np.ndarray
    fps: float
    frames: list


def load_gains():
    """The gains that tune.py found."""
    return {name: np.array(pair) for name, pair in json.loads(GAINS.read_text()).items()}


@dataclass
class Disturbances:
    """A push (second, N s, degrees from forward to the left), a box (ahead, left, edge in metres), the friction."""

    push: tuple[float, float, float] | None = None
    box: tuple[float, float, float] | None = None
    friction: float = 1.0


@dataclass
class Result:
    """What a simulation did until the robot fell, or to the end of the motion."""

    whole: float
    seconds: float = 0.0
    fell: bool = False
    qpos: list = field(default_factory=list)
    degrees: list = field(default_factory=list)
    efforts: list = field(default_factory=list)
    contact: list = field(default_factory=list)
    help: list = field(default_factory=list)
    work: float = 0.0

    def row(self):
        mean = lambda values: float(np.mean(values)) if len(values) else 0.0
        return {
            "seconds": round(self.seconds, 2),
            "of": round(self.whole, 2),
            "degrees": round(mean(self.degrees), 1),
            "largest_effort": round(float(np.max(self.efforts, initial=0.0)), 3),
            "contact_per_weight": round(mean(self.contact), 3),
            "watts": round(self.work / max(self.seconds, STEP), 0),
            "help_mean": round(mean(self.help), 3),
            "help_largest": round(float(np.max(self.help, initial=0.0)), 3),
        }


def heading(quaternion):
    """The angle about the vertical of the x axis of a frame."""
    w, x, y, z = quaternion
    return np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def upright(quaternion):
    """The cosine of the tilt of a frame."""
    return 1 - 2 * (quaternion[1] ** 2 + quaternion[2] ** 2)


def turned(angle, vector):
    sin, cos = np.sin(angle), np.cos(angle)
    return np.array([cos * vector[0] - sin * vector[1], sin * vector[0] + cos * vector[1]])


class Body:
    """The robot on a floor."""

    def __init__(self, disturbances=Disturbances()):
        spec = mujoco.MjSpec.from_file(str(MJCF))
        limits = {
            joint.name: joint.actfrcrange[1] for joint in spec.joints if joint.type == mujoco.mjtJoint.mjJNT_HINGE
        }
        for actuator in list(spec.actuators):
            spec.delete(actuator)
        self.efforts = np.array(list(limits.values()))
        self.stiffness = STIFFNESS * self.efforts
        for name, effort, stiffness in zip(limits, self.efforts, self.stiffness):
            spec.add_actuator(
                name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, gaintype=mujoco.mjtGain.mjGAIN_FIXED,
                biastype=mujoco.mjtBias.mjBIAS_AFFINE, gainprm=[stiffness] + [0] * 9,
                biasprm=[0, -stiffness, -DAMPING * stiffness] + [0] * 7, forcelimited=1, forcerange=[-effort, effort],
            )  # fmt: skip
        floor = spec.geom("floor")
        # The friction of the geom with the higher priority counts.
        floor.priority, floor.friction = 1, [disturbances.friction, 0.005, 0.0001]
        floor.solref[0], floor.solimp[:2] = FLOOR_SECONDS, FLOOR_STIFF
        for joint in spec.joints:
            if joint.type == mujoco.mjtJoint.mjJNT_HINGE:
                joint.armature = ARMATURE
        if disturbances.box:
            edge = disturbances.box[2]
            box = spec.worldbody.add_body(name="box", pos=[0, 0, edge / 2])
            box.add_freejoint()
            box.add_geom(
                type=mujoco.mjtGeom.mjGEOM_BOX, size=[edge / 2] * 3, density=BOX_DENSITY, contype=3, conaffinity=3
            )
            # The shapes of the legs are meshes that are not here. Shins touch nothing but the box.
            for side in ("left", "right"):
                spec.body(f"{side}_knee_link").add_geom(
                    type=mujoco.mjtGeom.mjGEOM_CAPSULE,
                    fromto=SHIN,
                    size=[SHIN_RADIUS, 0, 0],
                    mass=0,
                    contype=2,
                    conaffinity=2,
                )
        self.model = spec.compile()
        self.model.opt.timestep = STEP
        self.model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        self.model.opt.cone, self.model.opt.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, 10
        self.names = list(limits)
        self.disturbances = disturbances
        self.pelvis = self.model.body("pelvis").id
        self.feet = [self.model.body(f"{side}_ankle_roll_link").id for side in ("left", "right")]
        self.soles = [np.flatnonzero(self.model.geom_bodyid == foot) for foot in self.feet]
        self.dofs = 6 + len(self.names)
        self.weight = float(self.model.body("pelvis").subtreemass[0]) * 9.81
        self.servo = {name: index for index, name in enumerate(self.names)}

    def state(self, data):
        """Centre of mass and its velocity, the middle of each foot, the lowest point of each sole."""
        mujoco.mj_subtreeVel(self.model, data)
        lowest = [min(data.geom_xpos[geom][2] for geom in soles) for soles in self.soles]
        middles = [data.geom_xpos[soles].mean(0)[:2].copy() for soles in self.soles]
        return data.subtree_com[self.pelvis].copy(), data.subtree_linvel[self.pelvis].copy(), middles, lowest

    def motion(self, qpos, fps):
        """A motion to follow: of each frame the velocities, which feet stand, the centre of mass beside these feet and
        its velocity, and the torques of the joints."""
        model, data, frames = self.model, mujoco.MjData(self.model), []
        pose = lambda frame: np.concatenate([qpos[np.clip(frame, 0, len(qpos) - 1)], data.qpos[qpos.shape[1] :]])
        velocities = np.zeros((len(qpos), model.nv))
        for frame in range(len(qpos)):
            first, last = max(frame - 1, 0), min(frame + 1, len(qpos) - 1)
            mujoco.mj_differentiatePos(model, velocities[frame], (last - first) / fps, pose(first), pose(last))
        accelerations = np.gradient(velocities, 1 / fps, axis=0)
        for frame, velocity in enumerate(velocities):
            data.qpos[:], data.qvel[:], data.qacc[:] = pose(frame), velocity, accelerations[frame]
            mujoco.mj_forward(model, data)
            com, speed, middles, lowest = self.state(data)
            stands = np.array([height < min(lowest) + SOLE for height in lowest], dtype=float)
            data.qacc[:] = accelerations[frame]
            torques = self.torques(data, stands)
            frames.append((velocity, stands, *self.beside(com, speed, middles, stands, qpos[frame][3:7]), torques))
        return Motion(qpos, fps, frames)

    def torques(self, data, stands):
        """The torques of the joints in a motion, by inverse dynamics.

        The floor pushes within its friction at the corners of the soles that stand. Its forces leave the least at the
        pelvis and are small (non-negative least squares)."""
        model = self.model
        flags = model.opt.disableflags
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
        mujoco.mj_inverse(model, data)
        model.opt.disableflags = flags
        columns, place = [], np.zeros((3, model.nv))
        for foot, soles, stand in zip(self.feet, self.soles, stands):
            for geom in [
                geom for geom in soles if stand and data.geom_xpos[geom][2] < min(data.geom_xpos[soles, 2]) + SOLE
            ]:
                mujoco.mj_jac(model, data, place, None, data.geom_xpos[geom], foot)
                columns += [place.T @ [x, y, 1.0] for x, y in ((EDGE, 0), (-EDGE, 0), (0, EDGE), (0, -EDGE))]
        columns = np.array(columns).T[: self.dofs]
        needed = data.qfrc_inverse[: self.dofs]
        small = SMALL_FORCES * np.eye(columns.shape[1])
        forces, _ = scipy.optimize.nnls(
            np.concatenate([columns[:6], small]), np.concatenate([needed[:6], np.zeros(len(small))])
        )
        return np.clip((needed - columns @ forces)[6:], -self.efforts, self.efforts)

    @staticmethod
    def beside(com, speed, middles, stands, quaternion):
        """Where the centre of mass is beside the feet that stand, and its velocity, forward and to the left."""
        under = sum(stand * middle for stand, middle in zip(stands, middles)) / stands.sum()
        angle = -heading(quaternion)
        return turned(angle, com[:2] - under), turned(angle, speed[:2])

    def offsets(self, gains, stands, off, faster, lean, leaning):
        """What the balance controller adds to the angles of the servos.

        The feedback of SIMBICON (Yin, Loken, van de Panne 2007): a swing hip moves with the place and the velocity of
        the centre of mass beside the stance foot, a stance hip brings the trunk upright. Here both are measured against the
        motion, and a swing hip keeps its direction in the world. Stance ankles press where the centre of mass goes.
        """
        add = np.zeros(len(self.names))
        for side, stand in zip(("left", "right"), stands):
            ankle, hip = f"{side}_ankle_", f"{side}_hip_"
            if stand:
                add[self.servo[ankle + "pitch_joint"]] += gains["ankle_pitch"] @ [off[0], faster[0]]
                add[self.servo[ankle + "roll_joint"]] -= gains["ankle_roll"] @ [off[1], faster[1]]
                add[self.servo[hip + "pitch_joint"]] += gains["trunk_pitch"] @ [lean[1], leaning[1]]
                add[self.servo[hip + "roll_joint"]] += gains["trunk_roll"] @ [lean[0], leaning[0]]
                add[self.servo[hip + "yaw_joint"]] += gains["trunk_yaw"] @ [lean[2], leaning[2]]
            else:
                add[self.servo[hip + "pitch_joint"]] -= lean[1] + gains["swing_pitch"] @ [off[0], faster[0]]
                add[self.servo[hip + "roll_joint"]] += gains["swing_roll"] @ [off[1], faster[1]] - lean[0]
        return add

    def simulate(self, motion, help_at_pelvis, gains, measure=True):
        """Lets the robot follow a motion, from its first pose and velocity, until it falls.

        `help_at_pelvis` is the largest force of the help, as a part of the weight."""
        model, data = self.model, mujoco.MjData(self.model)
        qpos, fps, frames, size = motion.qpos, motion.fps, motion.frames, motion.qpos.shape[1]
        result = Result(whole=(len(qpos) - 1) / fps)
        data.qpos[:size], data.qvel[: self.dofs] = qpos[0], frames[0][0]
        if self.disturbances.box:
            ahead = turned(heading(qpos[0][3:7]), np.array(self.disturbances.box[:2]))
            data.qpos[size : size + 2] = qpos[0][:2] + ahead
        mujoco.mj_forward(model, data)
        control, written, error, force = STEP * STEPS, 0, np.zeros(3), np.zeros(6)
        for tick in range(int(result.whole / control)):
            at = tick * control * fps
            frame = min(int(at), len(qpos) - 2)
            part = at - frame
            wanted = (1 - part) * qpos[frame] + part * qpos[frame + 1]
            velocity, _, beside, faster, torques = (
                (1 - part) * a + part * b for a, b in zip(frames[frame], frames[frame + 1])
            )
            stands = frames[frame][1]
            com, speed, middles, _ = self.state(data)
            place, pace = self.beside(com, speed, middles, stands, data.qpos[3:7])
            # The rotation that is missing to the motion, in the axes of the pelvis.
            mujoco.mju_subQuat(error, qpos[frame][3:7], data.qpos[3:7])
            add = self.offsets(gains, stands, place - beside, pace - faster, -error, data.qvel[3:6] - velocity[3:6])
            data.ctrl[:] = wanted[7:] + add + DAMPING * velocity[6 : self.dofs] + torques / self.stiffness
            data.xfrc_applied[self.pelvis] = 0
            helped = self.help(data, wanted, velocity, error, help_at_pelvis)
            data.xfrc_applied[self.pelvis] = helped
            if self.disturbances.push:
                second, impulse, degrees = self.disturbances.push
                if second <= tick * control < second + PUSH_SECONDS:
                    towards = heading(data.qpos[3:7]) + np.radians(degrees)
                    data.xfrc_applied[self.pelvis, :2] += (
                        impulse / PUSH_SECONDS * np.array([np.cos(towards), np.sin(towards)])
                    )
            mujoco.mj_step(model, data, STEPS)
            if (
                data.qpos[2] < LOWEST * wanted[2]
                or upright(data.qpos[3:7]) < np.cos(FARTHEST)
                or not np.isfinite(data.qpos).all()
            ):
                result.fell = True
                break
            result.seconds = (tick + 1) * control
            if measure:
                upward = 0.0
                for contact in range(data.ncon):
                    geoms = data.contact[contact].geom
                    if (
                        model.geom_bodyid[geoms].min() == 0
                        and (model.body_rootid[model.geom_bodyid[geoms]] == self.pelvis).any()
                    ):
                        mujoco.mj_contactForce(model, data, contact, force)
                        upward += force[0]
                result.contact.append(upward / self.weight)
                result.help.append(np.linalg.norm(helped[:3]) / self.weight)
                result.efforts.append(np.abs(data.actuator_force) / self.efforts)
                result.degrees.append(np.degrees(np.abs(data.qpos[7:size] - wanted[7:]).mean()))
                result.work += float(np.abs(data.actuator_force * data.qvel[6 : self.dofs]).sum()) * control
                while written <= result.seconds * fps:
                    result.qpos.append(data.qpos[:size].copy())
                    written += 1
        return result

    def help(self, data, wanted, velocity, error, most):
        """The force and the moment that draw the pelvis to the motion."""
        if not most:
            return np.zeros(6)
        limited = lambda vector, limit: vector * min(1.0, limit / max(np.linalg.norm(vector), 1e-9))
        pull = HELP_FORCE[0] * (wanted[:3] - data.qpos[:3]) + HELP_FORCE[1] * (velocity[:3] - data.qvel[:3])
        turn = data.xmat[self.pelvis].reshape(3, 3) @ (
            HELP_MOMENT[0] * error + HELP_MOMENT[1] * (velocity[3:6] - data.qvel[3:6])
        )
        return self.weight * np.concatenate([limited(pull, most), limited(turn, most * HELP_LEVER)])
