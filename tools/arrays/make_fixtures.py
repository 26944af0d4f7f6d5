#!/usr/bin/env python3
"""Writes fixtures/arrays, or the named folder: small files of each layout, and the expected motions (expected.json).

NumPy poses the joints by Rodrigues' definition of a rotation. Tests compare these poses with the program's. All numbers
are random, from a fixed seed. Needs NumPy and SciPy. This script writes PyTorch's archive itself, without PyTorch.
"""
import io, json, pathlib, pickle, sys, types, zipfile
import numpy as np
import scipy.sparse

FIXTURES = pathlib.Path(__file__).resolve().parents[2] / "fixtures" / "arrays"
OUT = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else FIXTURES
PARENTS = [-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19]
HANDS = lambda wrist, first: [x for f in range(5) for x in (wrist, first + 3 * f, first + 3 * f + 1)]
SMPLH = PARENTS + HANDS(20, 22) + HANDS(21, 37)
SMPLX = PARENTS + [15, 15, 15] + HANDS(20, 25) + HANDS(21, 40)
SMPL = PARENTS + [20, 21]
rng = np.random.default_rng(20261123)


def rodrigues(v):
    angle = np.linalg.norm(v, axis=-1, keepdims=True)[..., None]
    axis = v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-12)
    x, y, z = np.moveaxis(axis, -1, 0)
    o = np.zeros_like(x)
    k = np.stack([np.stack([o, -z, y], -1), np.stack([z, o, -x], -1), np.stack([-y, x, o], -1)], -2)
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * (k @ k)


def pose(rest, parents, vectors, root):
    """Positions (frames, joints, 3) and rotations relative to the world, from rotations relative to the parent."""
    local = rodrigues(vectors)
    world, places = [None] * len(parents), [None] * len(parents)
    for joint, parent in enumerate(parents):
        if parent < 0:
            world[joint], places[joint] = local[:, joint], root
        else:
            world[joint] = world[parent] @ local[:, joint]
            offset = rest[joint] - rest[parent]
            places[joint] = places[parent] + world[parent] @ offset
    return np.stack(places, 1), np.stack(world, 1)


def upright(frames, joints, turn):
    """Rotations of joints. The root stands upright if `turn` brings +Y to the file's up axis."""
    vectors = 0.4 * rng.standard_normal((frames, joints, 3))
    vectors[:, 0] = turn
    return vectors


def to_y_up(places):
    return np.stack([places[..., 0], places[..., 2], -places[..., 1]], -1)


def body(parents):
    """Joints of an invented figure: a standing tree with random lengths."""
    rest = np.zeros((len(parents), 3))
    for joint, parent in enumerate(parents):
        if parent >= 0:
            rest[joint] = rest[parent] + 0.1 * rng.standard_normal(3)
    return rest - [0.02, 0.25, -0.01]


expected = {}


def expect(name, places, rate):
    expected[name] = {"frame_rate": rate, "positions": np.round(places, 6).tolist()}


def amass(name, parents, rate_name, rate, save):
    frames, rest = 3, body(parents)
    vectors = upright(frames, len(parents), [np.pi / 2, 0, 0])
    trans = rng.standard_normal((frames, 3))
    places, _ = pose(rest, parents, vectors, trans + rest[0])
    expect(name, to_y_up(places), rate)
    arrays = dict(poses=vectors.reshape(frames, -1), trans=trans, betas=np.zeros(16), gender=np.array("neutral"),
                  rest_joints=rest)
    arrays[rate_name] = np.array(float(rate))
    save(OUT / name, **arrays)


def smplx_dictionary():
    frames, rest = 2, body(SMPLX)
    vectors = upright(frames, 55, [0.1, 0.2, 0])
    transl = rng.standard_normal((frames, 3)).astype(np.float32)
    flat = vectors.reshape(frames, -1).astype(np.float32)
    places, _ = pose(rest, SMPLX, flat.astype(float).reshape(frames, 55, 3), transl.astype(float) + rest[0])
    return rest, transl, flat, places


def main():
    OUT.mkdir(exist_ok=True)
    amass("amass_smplh.npz", SMPLH, "mocap_framerate", 120, np.savez)
    amass("amass_smplx_deflated.npz", SMPLX, "mocap_frame_rate", 60, np.savez_compressed)
    amass("amass_smpl.npz", SMPL, "mocap_framerate", 24, np.savez)

    rest, transl, flat, places = smplx_dictionary()
    parts = dict(global_orient=flat[:, :3], body_pose=flat[:, 3:66], jaw_pose=flat[:, 66:69], leye_pose=flat[:, 69:72],
                 reye_pose=flat[:, 72:75], left_hand_pose=flat[:, 75:120], right_hand_pose=flat[:, 120:165],
                 transl=transl, fps=25, rest_joints=rest)
    for protocol in (2, 4, 5):
        name = f"smplx_protocol_{protocol}.pkl"
        (OUT / name).write_bytes(pickle.dumps(parts, protocol))
        expect(name, places, 25)

    motion_x = np.concatenate([flat[:, :66], flat[:, 75:165], flat[:, 66:69], np.zeros((2, 150), np.float32), transl,
                               np.zeros((2, 10), np.float32)], 1)
    np.save(OUT / "motion_x_322.npy", motion_x)
    np.save(OUT / "phuma_69.npy", np.concatenate([transl, flat[:, :66]], 1))
    np.save(OUT / "points_fortran.npy", np.asfortranarray(rng.standard_normal((4, 5, 3))))
    write_torch(parts)
    write_points()
    write_models()

    class Command:
        def __reduce__(self):
            import os
            return os.system, ("echo never",)

    (OUT / "hostile.pkl").write_bytes(pickle.dumps({"poses": Command()}, 2))
    (OUT / "expected.json").write_text(json.dumps(expected) + "\n")


def write_points():
    """A figure of round lengths that walks on the spot and bends its arms: its positions, and its rotations."""
    rest = np.zeros((22, 3))
    down = {1: (.1, -.05, 0), 4: (0, -.4, 0), 7: (0, -.4, 0), 10: (0, -.05, .13), 3: (0, .1, 0), 6: (0, .15, 0),
            9: (0, .1, 0), 12: (0, .2, 0), 15: (0, .1, 0), 13: (.05, .15, 0), 16: (.12, 0, 0), 18: (.3, 0, 0),
            20: (.25, 0, 0)}
    for left, right in ((1, 2), (4, 5), (7, 8), (10, 11), (13, 14), (16, 17), (18, 19), (20, 21)):
        down[right] = (-down[left][0], down[left][1], down[left][2])
    for joint in range(1, 22):
        rest[joint] = rest[PARENTS[joint]] + down[joint]
    frames = 60
    phase = 2 * np.pi * np.arange(frames) / 30
    vectors = np.zeros((frames, 22, 3))
    vectors[:, 0, 1] = 0.02 * np.arange(frames)
    for hip, knee, shift in ((1, 4, 0), (2, 5, np.pi)):
        vectors[:, hip, 0] = -0.5 * np.sin(phase + shift)
        vectors[:, hip, 1] = 0.3
        vectors[:, knee, 0] = 0.6 + 0.5 * np.sin(phase + shift)
    for shoulder, elbow, side in ((16, 18, 1), (17, 19, -1)):
        vectors[:, shoulder, 2] = -side * (1.0 + 0.2 * np.sin(phase))
        vectors[:, elbow, 1] = -side * (0.8 + 0.4 * np.cos(phase))
    root = np.stack([0 * phase, 0.85 + 0.02 * np.sin(phase), 0 * phase], -1)
    places, world = pose(rest, PARENTS, vectors, root)
    np.save(OUT / "points_smpl22.npy", places.astype(np.float32))
    np.save(OUT / "points_smpl22_rotations.npy", world.astype(np.float32))


def write_models():
    """A dense and a sparse invented body model, a motion with shape coefficients, and its joints on both models."""
    frames, vertices = 2, 60
    vectors = upright(frames, 52, [np.pi / 2, 0, 0])
    trans, betas = rng.standard_normal((frames, 3)), rng.standard_normal(16)
    np.savez(OUT / "shaped_smplh.npz", poses=vectors.reshape(frames, -1), trans=trans, betas=betas,
             gender=np.array("neutral"), mocap_framerate=np.array(30.0))
    places = {}
    for name, joints, count in (("body_smplh.npz", 52, 16), ("body_smpl.pkl", 24, 10)):
        template = rng.standard_normal((vertices, 3)) * 0.3
        shapes = 0.02 * rng.standard_normal((vertices, 3, count))
        regressor = np.zeros((joints, vertices))
        for joint in range(joints):
            near = rng.choice(vertices, 4, replace=False)
            weights = rng.random(4)
            regressor[joint, near] = weights / weights.sum()
        rest = regressor @ (template + shapes @ betas[:count])
        model = dict(v_template=template, shapedirs=shapes, J_regressor=regressor)
        if name.endswith(".pkl"):
            model["J_regressor"] = scipy.sparse.csc_matrix(regressor)
            (OUT / name).write_bytes(pickle.dumps(model, 2))
        else:
            np.savez_compressed(OUT / name, **model)
        known = min(joints, 22) if joints == 24 else joints
        posed, _ = pose(rest[:known], SMPLH[:known], vectors[:, :known], trans + rest[0])
        places[name] = np.round(to_y_up(posed), 6).tolist()
    (OUT / "expected_bodies.json").write_text(json.dumps(places) + "\n")


def write_torch(parts):
    """GVHMR's dictionary as torch.save writes it, made with a stand-in for PyTorch's module."""
    torch, utils = types.ModuleType("torch"), types.ModuleType("torch._utils")

    class FloatStorage: pass
    FloatStorage.__module__, FloatStorage.__qualname__ = "torch", "FloatStorage"
    def _rebuild_tensor_v2(*_): pass
    _rebuild_tensor_v2.__module__, _rebuild_tensor_v2.__qualname__ = "torch._utils", "_rebuild_tensor_v2"
    torch.FloatStorage, utils._rebuild_tensor_v2 = FloatStorage, _rebuild_tensor_v2
    sys.modules["torch"], sys.modules["torch._utils"] = torch, utils
    from collections import OrderedDict
    storages = []

    class Stored:
        def __init__(self, key): self.key = key

    class Tensor:
        def __init__(self, array):
            self.array = np.ascontiguousarray(array, np.float32)
            self.key = len(storages)
            storages.append(self.array.tobytes())

        def __reduce__(self):
            shape = self.array.shape
            strides = tuple(s // 4 for s in self.array.strides)
            return _rebuild_tensor_v2, (Stored(self), 0, shape, strides, False, OrderedDict())

    class Pickler(pickle.Pickler):
        def persistent_id(self, value):
            if isinstance(value, Stored):
                tensor = value.key
                return ("storage", FloatStorage, str(tensor.key), "cpu", tensor.array.size)

    names = ("global_orient", "body_pose", "transl")
    tensors = {name: Tensor(parts[name]) for name in names}
    far = {name: Tensor(np.zeros_like(parts[name])) for name in names}
    buffer = io.BytesIO()
    Pickler(buffer, 2).dump({"smpl_params_incam": far, "smpl_params_global": tensors})
    info = lambda name: zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
    with zipfile.ZipFile(OUT / "gvhmr.pt", "w") as archive:
        archive.writestr(info("hmr4d_results/data.pkl"), buffer.getvalue())
        archive.writestr(info("hmr4d_results/version"), "3\n")
        for key, data in enumerate(storages):
            archive.writestr(info(f"hmr4d_results/data/{key}"), data)


main()
