"""What the network reads and writes, in NumPy: frames of the root, the trajectory, the pose and the phase."""

import numpy as np

# Frames a second, and the moments of the trajectory that the network reads: frames before and after.
RATE = 30
OFFSETS = (-20, -10, 10, 20, 30)
FUTURE = [row for row, offset in enumerate(OFFSETS) if offset > 0]
# Deviation of the Gaussian filter of the root, in frames: it takes out the sway of the hips.
SMOOTHING = 5
# Weights of the four phases between which the weights of the network are interpolated.
PHASES = 4


def smooth(values, deviation=SMOOTHING):
    """The values after a Gaussian filter over frames; the ends go on along their tangents."""
    reach = 3 * deviation
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / deviation) ** 2)
    padded = np.pad(values, [(reach, reach)] + [(0, 0)] * (values.ndim - 1), "reflect", reflect_type="odd")
    return np.apply_along_axis(lambda column: np.convolve(column, kernel / kernel.sum(), "valid"), 0, padded)


def turned(angle, points):
    """Points (x, z) turned about +Y by an angle: +Z comes to (sin, cos)."""
    sin, cos = np.sin(angle), np.cos(angle)
    x, z = points[..., 0], points[..., 1]
    return np.stack([cos * x + sin * z, -sin * x + cos * z], -1)


def about_y(angle):
    """Rotation matrices about +Y."""
    sin, cos, zero = np.sin(angle), np.cos(angle), np.zeros_like(angle)
    return np.stack([cos, zero, sin, zero, zero + 1, zero, -sin, zero, cos], -1).reshape(*np.shape(angle), 3, 3)


def extended(values, count):
    """Frames before and after a motion, on along the mean change of its first and last frames."""
    slope = lambda part: (part[-1] - part[0]) / (len(part) - 1)
    steps = np.arange(1, count + 1).reshape(-1, *[1] * (values.ndim - 1))
    before = values[0] - steps[::-1] * slope(values[:count])
    return np.concatenate([before, values, values[-1] + steps * slope(values[-count:])])


def phase_of(ahead):
    """The phase, in turns without end, of how far the left foot is ahead of the right: 0 where it is farthest, which is
    where it strikes the ground, and half a turn where the right one is."""
    slow = smooth(ahead, 2)
    inner = slow[1:-1]
    peaks = 1 + np.flatnonzero((inner > slow[:-2]) & (inner >= slow[2:]) & (inner > 0))
    lows = 1 + np.flatnonzero((inner < slow[:-2]) & (inner <= slow[2:]) & (inner < 0))
    events = sorted([(frame, 0) for frame in peaks] + [(frame, 1) for frame in lows])
    kept = [event for event, before in zip(events, [(0, -1)] + events) if event[1] != before[1]]
    frames, turns = [frame for frame, _ in kept], 0.5 * (np.arange(len(kept)) + kept[0][1])
    first, last = frames[1] - frames[0], frames[-1] - frames[-2]
    return np.interp(
        np.arange(len(ahead)),
        [frames[0] - 4 * first, *frames, frames[-1] + 4 * last],
        [turns[0] - 2, *turns, turns[-1] + 2],
    )


def blend(phase):
    """Weights of the four networks at a phase in turns: cubic Catmull-Rom splines (Holden et al. 2017, equation 7)."""
    at = PHASES * (np.asarray(phase) % 1.0)
    first, t = at.astype(int) % PHASES, at - np.floor(at)
    cubic = [
        -0.5 * t + t**2 - 0.5 * t**3,
        1 - 2.5 * t**2 + 1.5 * t**3,
        0.5 * t + 2 * t**2 - 1.5 * t**3,
        -0.5 * t**2 + 0.5 * t**3,
    ]
    weights = np.zeros((*np.shape(phase), PHASES))
    for shift, value in zip((-1, 0, 1, 2), cubic):
        np.put_along_axis(weights, ((first + shift) % PHASES)[..., None], np.asarray(value)[..., None], -1)
    return weights


def clip_features(positions, rotations, sides):
    """Inputs, outputs and phases of the frames of one motion: positions of all joints in the world, and the matrices of
    those that turn, to the parent. `sides` are the rows of the two feet and the two thighs."""
    positions, rotations = positions.astype(float), rotations.astype(float)
    left, right, left_thigh, right_thigh = (positions[:, row] for row in sides)
    across = (left_thigh - right_thigh)[:, [0, 2]]
    facing = smooth(np.unwrap(np.arctan2(-across[:, 1], across[:, 0])))
    root = smooth(positions[:, 0][:, [0, 2]])
    ahead = turned(-facing, (left - right)[:, [0, 2]])[:, 1]
    phase = phase_of(ahead)

    # The pose: the hips beside the root, and the first two columns of each rotation, the hips' in the root's frame.
    rotations[:, 0] = about_y(-facing) @ rotations[:, 0]
    sway = turned(-facing, positions[:, 0][:, [0, 2]] - root)
    columns = rotations[..., :2].swapaxes(-1, -2).reshape(len(root), -1)
    pose = np.concatenate([sway[:, :1], positions[:, 0, 1:2], sway[:, 1:], columns], 1)

    # The trajectory around each frame, in the root's frame.
    reach = max(map(abs, OFFSETS))
    far_root, far_facing = extended(root, reach), extended(facing, reach)
    here = np.arange(len(root))
    trajectory = []
    for offset in OFFSETS:
        there = here + reach + offset
        angle = far_facing[there] - facing
        trajectory += [turned(-facing, far_root[there] - root), np.sin(angle)[:, None], np.cos(angle)[:, None]]
    trajectory = np.concatenate(trajectory, 1)

    # What follows: the step of the root, its turn, the step of the phase, the trajectory ahead, and the next pose.
    step = turned(-facing[:-1], np.diff(root, axis=0))
    change = np.stack([np.diff(facing), np.diff(phase)], 1)
    ahead = trajectory.reshape(len(root), len(OFFSETS), 4)[1:, FUTURE].reshape(len(root) - 1, -1)
    inputs = np.concatenate([trajectory, pose], 1)[:-1]
    return inputs, np.concatenate([step, change, ahead, pose[1:]], 1), phase[:-1]
