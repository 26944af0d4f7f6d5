"""Lets the network of train.py walk along a path over the ground, without PyTorch.

    python play.py --path "0/0 + 0/2 + 1/3" -o out.bvh

The points are X/Z in metres, as `mocap match --path` takes them."""

import argparse
import math
import pathlib
import time

import mocap
import numpy as np
import safetensors
from features import FUTURE, OFFSETS, PHASES, RATE, about_y, blend, turned
from mocap import edit

MODEL = pathlib.Path(__file__).with_name("walk.safetensors")
# Exponent of the time ahead by which the path takes over from what the network expects (Holden et al. 2017, section 5).
TAKES_OVER = 0.5
# What steps hide, as in `mocap match`: parts of a step towards the path, and radians a metre towards its direction.
STEP_TO_PATH, TURN_TO_PATH = 0.06, 0.4
# How the figure is asked to come to the path: towards a point so many metres ahead, in steps of so many seconds, and
# turning by so many radians a metre at most, as much as the walks of the training do.
LOOK_AHEAD, PURSUIT_STEP, MOST_TURN = 0.3, 1 / 6, 1.2
# Seconds for each metre of the path after which the walk gives up.
PATIENCE = 4.0


class Path:
    """A polyline over the ground."""

    def __init__(self, points):
        self.points = np.asarray(points, dtype=float)
        steps = np.diff(self.points, axis=0)
        self.lengths = np.linalg.norm(steps, axis=1)
        if len(self.points) < 2 or not np.isfinite(self.points).all() or self.lengths.min() == 0:
            raise ValueError("expected two or more different points X/Z, as 0/0 + 0/2 + 1/3")
        self.along = np.concatenate([[0], np.cumsum(self.lengths)])
        self.directions = steps / self.lengths[:, None]

    def at(self, along):
        """The point so far along the path, straight on after its end, and the direction there."""
        along = np.asarray(along, dtype=float)
        piece = np.clip(np.searchsorted(self.along, along, "right") - 1, 0, len(self.lengths) - 1)
        direction = self.directions[piece]
        return self.points[piece] + (along - self.along[piece])[..., None] * direction, direction

    def pursue(self, root, facing, along, speed):
        """Points and directions of one who goes on from `root` and comes to the path (pure pursuit)."""
        count = round(OFFSETS[-1] / RATE / PURSUIT_STEP)
        targets = self.at(along + LOOK_AHEAD + speed * PURSUIT_STEP * np.arange(count))[0]
        points, directions, most = [], [], MOST_TURN * speed * PURSUIT_STEP
        for x, z in targets:
            turn = math.remainder(math.atan2(x - root[0], z - root[1]) - facing, math.tau)
            facing += min(max(turn, -most), most)
            root = root + speed * PURSUIT_STEP * np.array([math.sin(facing), math.cos(facing)])
            points.append(root)
            directions.append([math.sin(facing), math.cos(facing)])
        rows = [round(OFFSETS[row] / RATE / PURSUIT_STEP) - 1 for row in FUTURE]
        return np.array(points)[rows], np.array(directions)[rows]

    def nearest(self, point, after, within):
        """How far along the path the nearest point is, of those from `after` on to `within` more."""
        along = np.linspace(after, after + within, 30)
        return along[np.argmin(np.linalg.norm(self.at(along)[0] - point, axis=1))]


class Walker:
    """The network, and where its figure is."""

    def __init__(self, model=MODEL):
        with safetensors.safe_open(model, "numpy") as file:
            self.names = file.metadata()["joints"].split(" ")
            tensors = {name: file.get_tensor(name) for name in file.keys()}
        self.parents, self.offsets, self.first = (tensors[name] for name in ("parents", "offsets", "first"))
        self.scales = [tensors[name] for name in ("read_mean", "read_spread", "least", "most", "mean", "spread")]
        # The matrices of the four phases in one, so that a layer is one product.
        self.layers = [
            (
                tensors[f"weight{layer}"].astype(np.float32).reshape(-1, tensors[f"weight{layer}"].shape[2]),
                tensors[f"bias{layer}"].astype(np.float32),
            )
            for layer in range(3)
        ]

    def predict(self, values, phase):
        read_mean, read_spread, least, most, mean, spread = self.scales
        # Outside of what the training has seen a network may say anything.
        values = np.clip((values - read_mean) / read_spread, least, most).astype(np.float32)
        weights = blend(phase).astype(np.float32)
        for layer, (matrix, bias) in enumerate(self.layers):
            if layer:
                values = np.where(values > 0, values, np.expm1(np.minimum(values, 0)))
            values = weights @ ((matrix @ values).reshape(PHASES, -1) + bias)
        return values * spread + mean

    def walk(self, path, speed):
        """Roots (x, z, facing) and poses of the frames until the path ends, and seconds of a frame's computation."""
        seconds_ahead = np.array([offset for offset in OFFSETS if offset > 0]) / RATE
        share = (seconds_ahead / seconds_ahead[-1])[:, None] ** TAKES_OVER
        root, (direction,) = path.points[0].copy(), path.directions[:1]
        facing, phase, along = np.arctan2(*direction), 0.0, 0.0
        count = 4 * len(OFFSETS)
        expected = self.first[:count].reshape(-1, 4)[FUTURE]
        pose, roots, poses = self.first[count:], [[*root, facing]], [self.first[count:]]
        begin = time.process_time()
        while along < path.along[-1] and len(roots) < PATIENCE * RATE * path.along[-1] / speed:
            along = path.nearest(root, along, 0.3)
            points, directions = path.pursue(root, facing, along, speed)
            wanted = np.concatenate([turned(-facing, points - root), turned(-facing, directions)], 1)
            expected = expected + share * (wanted - expected)
            past = []
            for offset in OFFSETS:
                if offset < 0:
                    *there, angle = (
                        roots[offset - 1] if len(roots) >= 1 - offset else self.before(roots[0], offset, speed)
                    )
                    turn = angle - facing
                    past.append([*turned(-facing, np.array(there) - root), np.sin(turn), np.cos(turn)])
            given = self.predict(np.concatenate([np.ravel(past), expected.ravel(), pose]), phase)
            step, turn, phase = turned(facing, given[:2]), given[2], phase + max(given[3], 0.0)
            here, ahead = path.at(along)[0], path.at(along + speed / 3)[1]
            length = np.linalg.norm(step)
            off, angle = here - root - step, np.arctan2(*turned(-facing - turn, ahead))
            root = root + step + off * min(1.0, STEP_TO_PATH * length / max(np.linalg.norm(off), 1e-9))
            facing = facing + turn + np.clip(angle, -TURN_TO_PATH * length, TURN_TO_PATH * length)
            expected, pose = given[4 : 4 + 4 * len(FUTURE)].reshape(-1, 4), given[4 + 4 * len(FUTURE) :]
            roots.append([*root, facing])
            poses.append(pose)
        return np.array(roots), np.array(poses), (time.process_time() - begin) / (len(roots) - 1)

    @staticmethod
    def before(first, offset, speed):
        """Where a figure was that walked straight to its first frame."""
        x, z, facing = first
        return (*(np.array([x, z]) + offset / RATE * speed * np.array([np.sin(facing), np.cos(facing)])), facing)

    def scene(self, roots, poses):
        """The motion as a scene of mocap."""
        frames, facing = len(roots), roots[:, 2]
        first, second = np.moveaxis(poses[:, 3:].reshape(frames, -1, 2, 3), 2, 0)
        first = first / np.linalg.norm(first, axis=-1, keepdims=True)
        second = second - (first * second).sum(-1, keepdims=True) * first
        second /= np.linalg.norm(second, axis=-1, keepdims=True)
        turns = np.stack([first, second, np.cross(first, second)], -1)
        turns[:, 0] = about_y(facing) @ turns[:, 0]
        matrices = np.tile(np.eye(3), (frames, len(self.names), 1, 1))
        matrices[:, [row for row, name in enumerate(self.names) if not name.startswith("EndSite")]] = turns
        sway = turned(facing, poses[:, [0, 2]])
        positions = np.zeros((frames, len(self.names), 3))
        positions[:, 0] = np.stack([roots[:, 0] + sway[:, 0], poses[:, 1], roots[:, 1] + sway[:, 1]], 1)
        world = matrices.copy()
        for joint, parent in enumerate(self.parents[1:], 1):
            positions[:, joint] = positions[:, parent] + world[:, parent] @ self.offsets[joint]
            world[:, joint] = world[:, parent] @ matrices[:, joint]
        return mocap.from_arrays(
            positions=positions, rotations=matrices, names=self.names, parents=self.parents.tolist(), frame_rate=RATE
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--path", required=True, help="points X/Z in metres: 0/0 + 0/2 + 1/3")
    parser.add_argument("--speed", type=float, default=1.1, help="metres a second (default: %(default)s)")
    parser.add_argument("--lock", action="store_true", help="hold feet on the ground, by the step foot-lock of mocap")
    parser.add_argument("--model", default=MODEL, help="the network (default: %(default)s)")
    parser.add_argument("-o", "--output", required=True)
    args = parser.parse_args()
    try:
        path = Path([[float(number) for number in point.split("/")] for point in args.path.split("+")])
    except ValueError as error:
        parser.error(f"--path: {error}")
    walker = Walker(args.model)
    roots, poses, seconds = walker.walk(path, args.speed)
    scene = walker.scene(roots, poses)
    if args.lock:
        scene = edit.foot_lock(scene)[0]
    mocap.convert(scene, args.output, overwrite=True)
    print(f"{len(roots)} frames at {RATE} a second, {1e6 * seconds:.0f} microseconds each: {args.output}")


if __name__ == "__main__":
    main()
