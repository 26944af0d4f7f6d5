"""Lets Unitree's G1 follow a motion in MuJoCo, with servos within its efforts and a balance controller.

python simulate.py walk.bvh -o walk.npz         # then: mocap view walk.npz --body g1.urdf
python simulate.py stand --push 2:30:90 --friction 0.6
python simulate.py --table"""

import argparse

import mocap
import mujoco
import numpy as np
from body import ROOT, URDF, Body, Disturbances, load_gains
from mocap import edit

FPS = 50.0
# Seconds that `stand` takes, and how far its knees are bent, in radians.
STANDING, KNEES = 30.0, 0.4
REAL = ROOT / "fixtures/real"
# The motions of the table: file, first second, curvature of the arc along which it is bent, in 1/m.
CLIPS = {
    "stand": (None, 0.0, None),
    "walk": (REAL / "cmu_12_01_walk.bvh", 0.0, None),
    "turn": (REAL / "cmu_12_01_walk.bvh", 0.0, 0.5),
    "dance": (REAL / "cmu_salsa_poser_names.bvh", 0.5, None),
}
# Help of the table's last columns, as a part of the weight.
HELP = 0.1
# Pushes of the table, in N s.
PUSHES = range(100)


def reference(path, first=0.0, curvature=None, seconds=STANDING):
    """The motion on the robot, at FPS; without a file a pose with bent knees."""
    body = Body()
    if path is None:
        data = mujoco.MjData(body.model)
        for side in ("left", "right"):
            for joint, bends in (("hip_pitch", -0.5), ("knee", 1.0), ("ankle_pitch", -0.5)):
                data.qpos[7 + body.servo[f"{side}_{joint}_joint"]] = bends * KNEES
        mujoco.mj_forward(body.model, data)
        data.qpos[2] += body.model.geom_size[body.soles[0][0]][0] - min(body.state(data)[3])
        return body.motion(np.tile(data.qpos, (round(seconds * FPS) + 1, 1)), FPS)
    scene = edit.trim(edit.prepare(str(path)), first)[0]
    if curvature:
        way = scene.to_numpy(space="world", joints=scene.nodes[0].name).positions[::10, 0]
        along = np.linspace(0, np.linalg.norm(np.diff(way, axis=0), axis=1).sum(), 9)
        points = np.stack([1 - np.cos(curvature * along), np.sin(curvature * along)], 1) / curvature
        scene = edit.warp_path(scene, points.tolist())[0]
    return body.motion(mocap.Robot(str(URDF)).retarget(scene, fps=FPS).qpos, FPS)


def table(gains):
    """Prints a row for each clip, without help and with it, and the pushes from which the standing robot recovers."""
    print(
        "| motion | of | upright, s | with help, s | help, mean | largest effort "
        "| joints, degrees | contact / weight | power, W |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    body = Body()
    for name, clip in CLIPS.items():
        motion = reference(*clip)
        alone, helped = (body.simulate(motion, most, gains) for most in (0.0, HELP))
        one, two = alone.row(), helped.row()
        effort = max(one["largest_effort"], two["largest_effort"])
        print(
            f"| {name} | {one['of']} | {one['seconds']} | {two['seconds']} | {two['help_mean']} | {effort} "
            f"| {one['degrees']} | {one['contact_per_weight']} | {one['watts']:.0f} |"
        )
    still = reference(None, seconds=6.0)
    for degrees in (0, 90, 180):
        falls = lambda impulse: Body(Disturbances(push=(1.0, impulse, degrees))).simulate(still, 0.0, gains).fell
        most = next(impulse for impulse in PUSHES if falls(impulse + 1))
        print(f"{degrees} degrees: recovers from {most} N s, {'falls' if falls(50) else 'stands'} after 50 N s")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "motion", nargs="?", default="stand", help="a file that mocap reads, stand, walk, turn or dance"
    )
    parser.add_argument(
        "--help-weight",
        type=float,
        default=0.0,
        metavar="PART",
        help="help at the pelvis: its largest force, as a part of the weight",
    )
    parser.add_argument(
        "--push",
        metavar="SECOND:NS:DEGREES",
        help="a push of the pelvis: when, N s, direction from forward to the left",
    )
    parser.add_argument("--box", metavar="AHEAD/LEFT/EDGE", help="a box on the floor: where, and its edge, in metres")
    parser.add_argument("--friction", type=float, default=1.0, help="of the floor (default: %(default)s)")
    parser.add_argument("--table", action="store_true", help="print the table of the README")
    parser.add_argument("-o", "--output", help="the simulated motion until the robot falls, as .npz")
    args = parser.parse_args()
    gains = load_gains()
    if args.table:
        return table(gains)
    numbers = lambda text, mark: tuple(float(number) for number in text.split(mark)) if text else None
    disturbances = Disturbances(numbers(args.push, ":"), numbers(args.box, "/"), args.friction)
    clip = CLIPS.get(args.motion, (args.motion,))
    result = Body(disturbances).simulate(reference(*clip), args.help_weight, gains)
    print(
        f"{args.motion}: {'falls after' if result.fell else 'stands for all'} "
        f"{result.seconds:.2f} of {result.whole:.2f} s"
    )
    print(", ".join(f"{name.replace('_', ' ')} {value:g}" for name, value in result.row().items()))
    if args.output:
        # The layout that `mocap robot --to qpos` writes, which every command reads with --body.
        np.savez(args.output, qpos=np.array(result.qpos), fps=FPS, dof_names=np.array(Body().names))


if __name__ == "__main__":
    main()
