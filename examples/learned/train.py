"""Trains a phase-functioned network (Holden, Komura, Saito: SIGGRAPH 2017) on the walks of motions.py.

python train.py -o walk.safetensors [--steps 5000] [--seed 1]"""

import argparse
import time

import numpy as np
import safetensors.numpy
import torch
from features import FUTURE, OFFSETS, PHASES, RATE, blend, clip_features
from motions import scenes

# Units of each of the two hidden layers; motions of a batch; frames that a prediction is fed back.
HIDDEN, BATCH, ROLLOUT = 128, 64, 6
LEARNING_RATE, DECAY = 1e-3, 1e-2
# Deviation of the noise on poses that are read, in deviations of their columns: the network learns to come back.
NOISE = 0.4
# The same of the trajectory; part of the hidden units that are left out in a step of the training.
TRAJECTORY_NOISE, DROPOUT = 0.05, 0.2
# Weight of the positions of feet, in metres, beside columns in deviations.
FEET_WEIGHT = 30.0
LEGS = (("LeftUpLeg", "LeftLeg", "LeftFoot", "LeftToeBase"), ("RightUpLeg", "RightLeg", "RightFoot", "RightToeBase"))


class Network(torch.nn.Module):
    """Three layers whose weights are a cyclic spline through those of four phases."""

    def __init__(self, sizes):
        super().__init__()
        shapes = list(zip(sizes[:-1], sizes[1:]))
        scale = lambda inputs, outputs: (6 / (inputs + outputs)) ** 0.5
        uniform = lambda i, o: (2 * torch.rand(PHASES, o, i) - 1) * scale(i, o)
        self.weights = torch.nn.ParameterList([uniform(i, o) for i, o in shapes])
        self.biases = torch.nn.ParameterList([torch.zeros(PHASES, o) for _, o in shapes])

    def forward(self, values, phases):
        for layer, (weight, bias) in enumerate(zip(self.weights, self.biases)):
            if layer:
                values = torch.nn.functional.dropout(torch.nn.functional.elu(values), DROPOUT, self.training)
            each = (values @ weight.flatten(0, 1).T).unflatten(-1, (PHASES, -1)) + bias
            values = (phases[..., None] * each).sum(-2)
        return values


def matrices(columns):
    """Rotations of the first two columns that a network gives (Zhou et al. 2019)."""
    first, second = columns.unflatten(-1, (-1, 2, 3)).unbind(-2)
    first = torch.nn.functional.normalize(first, dim=-1)
    second = torch.nn.functional.normalize(second - (first * second).sum(-1, keepdim=True) * first, dim=-1)
    return torch.stack([first, second, torch.linalg.cross(first, second)], -1)


def feet(pose, joints, parents, offsets):
    """Where ankles and toes are, in the frame of the root."""
    turns, found = matrices(pose[..., 3:]), []
    for leg in LEGS:
        chain = [joints.index(leg[0])]
        while parents[chain[0]] >= 0:
            chain.insert(0, parents[chain[0]])
        chain += [joints.index(name) for name in leg[1:]]
        at, turn = pose[..., :3], turns[..., 0, :, :]
        for joint in chain[1:]:
            at = at + turn @ offsets[joint]
            turn = turn @ turns[..., joint, :, :]
            found += [at] if joints[joint] in leg[2:] else []
    return torch.cat(found, -1)


def data():
    """The skeleton, and the inputs, outputs and phases of each motion at 30 frames a second, from two first frames."""
    clips = []
    for scene in scenes():
        motion = scene.to_numpy(fps=2 * RATE, rot="matrix")
        moving = [row for row, name in enumerate(motion.names) if not name.startswith("EndSite")]
        sides = [motion.names.index(name) for name in ("LeftFoot", "RightFoot", "LeftUpLeg", "RightUpLeg")]
        for first in (0, 1):
            clips.append(clip_features(motion.positions[first::2], motion.rotations[first::2, moving], sides))
    return motion, moving, clips


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--steps", type=int, default=5000)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    # One thread adds numbers in one order: the same seed gives the same file.
    torch.set_num_threads(1)
    torch.use_deterministic_algorithms(True)
    torch.manual_seed(args.seed)
    begin = time.monotonic()

    motion, moving, clips = data()
    joints = [motion.names[row] for row in moving]
    parents = [moving.index(motion.parents[row]) if motion.parents[row] >= 0 else -1 for row in moving]
    offsets = torch.tensor(motion.offsets[moving], dtype=torch.float32)
    inputs, outputs = (np.concatenate([clip[part] for clip in clips]) for part in (0, 1))
    # Columns of one kind are divided by one deviation, so that those that hardly move do not count as much as others.
    ends = (0, 2, 3, 4, 4 + 4 * len(FUTURE), 7 + 4 * len(FUTURE), outputs.shape[1])
    mean, spread = outputs.mean(0), np.empty(outputs.shape[1])
    for first, last in zip(ends, ends[1:]):
        spread[first:last] = outputs[:, first:last].std(0).mean()
    path = 4 * len(OFFSETS)
    pose = outputs.shape[1] - ends[-3]
    read_mean = np.concatenate([inputs[:, :path].mean(0), mean[-pose:]])
    read_spread = np.concatenate([np.full(path, inputs[:, :path].std(0).mean()), spread[-pose:]])
    tensor = lambda values: torch.tensor(values, dtype=torch.float32)
    all_read = [tensor((clip[0] - read_mean) / read_spread) for clip in clips]
    all_wanted = [tensor((clip[1] - mean) / spread) for clip in clips]
    all_phases = [tensor(blend(clip[2])) for clip in clips]
    windows = [(clip, at) for clip, read in enumerate(all_read) for at in range(len(read) - ROLLOUT + 1)]
    print(f"{len(clips)} clips, {len(inputs)} frames, {inputs.shape[1]} numbers in, {outputs.shape[1]} out")

    network = Network((inputs.shape[1], HIDDEN, HIDDEN, outputs.shape[1]))
    optimizer = torch.optim.AdamW(network.parameters(), lr=LEARNING_RATE, weight_decay=DECAY)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, args.steps)
    pose_mean, pose_spread = tensor(mean[-pose:]), tensor(spread[-pose:])
    where = lambda values: feet(values[..., -pose:] * pose_spread + pose_mean, joints, parents, offsets)
    total = 0.0
    for step in range(1, args.steps + 1):
        chosen = [windows[index] for index in torch.randint(len(windows), (BATCH,)).tolist()]
        gather = lambda lists: torch.stack([lists[clip][at : at + ROLLOUT] for clip, at in chosen])
        read, wanted, phases = gather(all_read), gather(all_wanted), gather(all_phases)
        way = read[..., :path] + TRAJECTORY_NOISE * torch.randn(BATCH, 1, path)
        state, given = read[:, 0, path:] + NOISE * torch.randn(BATCH, pose), []
        for frame in range(ROLLOUT):
            given.append(network(torch.cat([way[:, frame], state], -1), phases[:, frame]))
            state = given[-1][:, -pose:]
        given = torch.stack(given, 1)
        there, here = where(given), where(wanted)
        loss = (given - wanted).abs().mean() + FEET_WEIGHT * (there - here).abs().mean()
        loss = loss + FEET_WEIGHT * RATE / 10 * ((there - here)[:, 1:] - (there - here)[:, :-1]).abs().mean()
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        schedule.step()
        total += loss.item()
        if step % 1000 == 0 or step == args.steps:
            print(
                f"step {step}: loss {total / ((step - 1) % 1000 + 1):.4f}, {time.monotonic() - begin:.0f} s",
                flush=True,
            )
            total = 0.0

    half = lambda values: np.asarray(values, dtype=np.float16)
    tensors = {f"weight{layer}": half(value.detach()) for layer, value in enumerate(network.weights)}
    tensors |= {f"bias{layer}": half(value.detach()) for layer, value in enumerate(network.biases)}
    single = {"mean": mean, "spread": spread, "read_mean": read_mean, "read_spread": read_spread}
    # A walk begins in the mean of all frames at phase 0.
    single["first"] = np.concatenate([clip[0][(clip[2] % 1.0) < 0.1] for clip in clips]).mean(0)
    # What the network has read: a player keeps to it.
    normal = (inputs - read_mean) / read_spread
    single |= {"least": normal.min(0), "most": normal.max(0)}
    single["offsets"] = motion.offsets
    tensors |= {name: np.asarray(values, dtype=np.float32) for name, values in single.items()}
    tensors["parents"] = np.asarray(motion.parents, dtype=np.int32)
    safetensors.numpy.save_file(tensors, args.output, {"joints": " ".join(motion.names)})


if __name__ == "__main__":
    main()
