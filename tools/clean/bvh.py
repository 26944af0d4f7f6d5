"""A reader and a writer of BVH with their own kinematics, without code of mocap."""

import numpy as np
from scipy.spatial.transform import Rotation


class Motion:
    """Joints with constant offsets below a root that moves. Lengths are in the unit of the file."""

    def __init__(self, names, parents, offsets, tips, rate, root, turns):
        self.names, self.parents, self.offsets, self.tips = names, parents, offsets, tips
        self.rate = rate
        self.root = root  # frames x 3
        self.turns = turns  # frames x joints x 4, relative to the parent: x, y, z, w

    def copy(self):
        return Motion(self.names, self.parents, self.offsets, self.tips, self.rate, self.root.copy(), self.turns.copy())

    def take(self, frames):
        return Motion(
            self.names, self.parents, self.offsets, self.tips, self.rate, self.root[frames], self.turns[frames]
        )

    def positions(self):
        """The position of every joint in every frame."""
        frames, joints = self.turns.shape[:2]
        places = np.zeros((frames, joints, 3))
        world = [None] * joints
        for joint in range(joints):
            local = Rotation.from_quat(self.turns[:, joint])
            parent = self.parents[joint]
            if parent < 0:
                world[joint], places[:, joint] = local, self.root
            else:
                world[joint] = world[parent] * local
                places[:, joint] = places[:, parent] + world[parent].apply(self.offsets[joint])
        return places


def read(path):
    names, parents, offsets, channels, tips = [], [], [], [], []
    stack, is_tip = [], False
    lines = open(path, encoding="latin1").read().replace("\r", "\n").split("\n")
    lines = iter(line for line in (line.strip() for line in lines) if line)
    for line in lines:
        words = line.split()
        key = words[0].lower()
        if key in ("root", "joint"):
            names.append(" ".join(words[1:]))
            parents.append(stack[-1] if stack else -1)
            offsets.append([0.0] * 3)
            channels.append([])
        elif key == "end":
            is_tip = True
        elif key == "{":
            stack.append(None if is_tip else len(names) - 1)
        elif key == "}":
            stack.pop()
            is_tip = False
        elif key == "offset":
            value = [float(word) for word in words[1:4]]
            if stack[-1] is None:
                tips.append((stack[-2], value))
            else:
                offsets[stack[-1]] = value
        elif key == "channels":
            channels[stack[-1]] = [word.lower() for word in words[2:]]
        elif key == "motion":
            break
    count = int(next(lines).split()[-1])
    time = float(next(lines).split()[-1])
    rows = np.array([[float(word) for word in line.split()] for line in lines], dtype=float)[:count]
    turns = np.zeros((len(rows), len(names), 4))
    root, column = np.zeros((len(rows), 3)), 0
    for joint, its in enumerate(channels):
        order, angles = "", []
        for channel in its:
            if channel.endswith("position"):
                if joint == 0:
                    root[:, "xyz".index(channel[0])] = rows[:, column]
            else:
                order += channel[0].upper()
                angles.append(rows[:, column])
            column += 1
        turns[:, joint, 3] = 1.0
        if order:
            turns[:, joint] = Rotation.from_euler(order, np.stack(angles, 1), degrees=True).as_quat()
    return Motion(names, parents, np.array(offsets), tips, 1.0 / time, root, turns)


def write(path, motion):
    children = [[] for _ in motion.names]
    for joint, parent in enumerate(motion.parents):
        if parent >= 0:
            children[parent].append(joint)
    tips, text, order = dict(motion.tips), [], []

    def add(joint, depth):
        order.append(joint)
        pad = "  " * depth
        offset = [0.0] * 3 if joint == 0 else motion.offsets[joint]
        text.append(f"{pad}{'ROOT' if joint == 0 else 'JOINT'} {motion.names[joint]}\n{pad}{{")
        text.append(f"{pad}  OFFSET " + " ".join(f"{value:.6f}" for value in offset))
        moves = "6 Xposition Yposition Zposition" if joint == 0 else "3"
        text.append(f"{pad}  CHANNELS {moves} Zrotation Xrotation Yrotation")
        for child in children[joint]:
            add(child, depth + 1)
        if not children[joint]:
            tip = " ".join(f"{value:.6f}" for value in tips.get(joint, [0.0] * 3))
            text.append(f"{pad}  End Site\n{pad}  {{\n{pad}    OFFSET {tip}\n{pad}  }}")
        text.append(f"{pad}}}")

    add(0, 0)
    angles = [Rotation.from_quat(motion.turns[:, joint]).as_euler("ZXY", degrees=True) for joint in order]
    rows = np.concatenate([motion.root, *angles], axis=1)
    with open(path, "w") as file:
        file.write("HIERARCHY\n" + "\n".join(text))
        file.write(f"\nMOTION\nFrames: {len(rows)}\nFrame Time: {1 / motion.rate:.9f}\n")
        np.savetxt(file, rows, fmt="%.6f")
