"""Compares the models of Assimp's tests: FBX with ufbx, glTF with pygltflib."""

import json
import subprocess
import sys

import numpy as np

import gltf
from motion import Motion, Nothing, Refused, unique
from packages import debian
from packages import files as found


def files(_everything):
    place = debian("assimp-testmodels")
    for path in found(place, ".fbx"):
        yield path, fbx, fbx
    for path in found(place, ".gltf", ".glb"):
        yield path, gltf.motion, gltf.motion


def fbx(path):
    done = subprocess.run([sys.executable, "fbx.py", path], capture_output=True, text=True)
    if done.returncode:
        raise Refused((done.stderr.splitlines() or [f"exit code {done.returncode}"])[-1])
    seconds, nodes = json.loads(done.stdout)
    if not nodes:
        raise Nothing
    return Motion(seconds, unique([(name, np.array(path)) for name, path in nodes]))
