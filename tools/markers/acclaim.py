"""Computes joint centres of an ASF and AMC pair in millimetres, by the description of the format, without mocap."""

import numpy as np
from scipy.spatial.transform import Rotation

MILLIMETRES = 25.4  # CMU's lengths are inches, times the length of its :units


def skeleton(path):
    """Bones by name: direction, length, axis and degrees of freedom; and the parent of each."""
    bones, parents, scale, mode, bone = {}, {}, 1.0, "", None
    root = {"axis": Rotation.identity(), "dof": [], "vector": np.zeros(3)}
    for line in open(path):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        if words[0].startswith(":"):
            mode = words[0]
        elif mode == ":units" and words[0] == "length":
            scale = float(words[1])
        elif mode == ":root" and words[0] == "order":
            root["dof"] = [word.lower() for word in words[1:]]
        elif mode == ":bonedata":
            if words[0] == "begin":
                bone = {"dof": []}
            elif words[0] == "end":
                bone["vector"] = np.array(bone["direction"]) * bone["length"]
                bones[bone["name"]] = bone
            elif words[0] == "name":
                bone["name"] = words[1]
            elif words[0] == "direction":
                bone["direction"] = [float(word) for word in words[1:4]]
            elif words[0] == "length":
                bone["length"] = float(words[1])
            elif words[0] == "axis":
                bone["axis"] = Rotation.from_euler("xyz", [float(word) for word in words[1:4]], degrees=True)
            elif words[0] == "dof":
                bone["dof"] = words[1:]
        elif mode == ":hierarchy" and words[0] not in ("begin", "end"):
            for child in words[1:]:
                parents[child] = words[0]
    bones["root"] = root
    return bones, parents, MILLIMETRES / scale


def ends(asf, amc):
    """The end of each bone, frame by frame: name -> (frames, 3). The end of `root` is its position."""
    bones, parents, scale = skeleton(asf)
    frames, names = [], list(parents)
    for line in open(amc):
        words = line.split()
        if len(words) == 1 and words[0].isdigit():
            frames.append({})
        elif frames and len(words) > 1:
            frames[-1][words[0]] = [float(word) for word in words[1:]]

    def rotations(name):
        bone, order = bones[name], "xyz"
        angles = np.zeros((len(frames), 3))
        for column, dof in enumerate(bone["dof"]):
            if dof.startswith("r"):
                angles[:, order.index(dof[1])] = [frame[name][column] if name in frame else 0.0 for frame in frames]
        return Rotation.from_euler("xyz", angles, degrees=True)

    world, found = {}, {}
    root = np.array([frame["root"][:3] for frame in frames])
    world["root"], found["root"] = rotations("root"), root * scale
    for name in names:
        bone, parent = bones[name], parents[name]
        own = world[parent]
        if bone["dof"]:
            own = own * (bone["axis"] * rotations(name) * bone["axis"].inv())
        world[name] = own
        found[name] = found[parent] + own.apply(bone["vector"]) * scale
    return found
