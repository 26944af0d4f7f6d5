"""`mocap.graph` and `mocap.Graph`: the graph, the matrix and the walks of the program, and of a job."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
from conftest import REAL

import mocap

WALK = str(REAL / "cmu_12_01_walk.bvh")


def test_a_graph_is_that_of_the_program(program: Path, tmp_path: Path) -> None:
    theirs, own, matrix = tmp_path / "theirs.json", tmp_path / "own.json", tmp_path / "matrix.npy"
    subprocess.run([program, "graph", WALK, "--threshold", "5cm", "--matrix", matrix, "-q", "-o", theirs], check=True)
    graph = mocap.graph(WALK, threshold=0.05)
    graph.write(own)
    assert own.read_bytes() == theirs.read_bytes()
    assert np.array_equal(graph.matrix(), np.load(matrix))
    stated = json.loads(own.read_text())
    assert len(graph.transitions) == len(stated["transitions"]) > 10
    first = stated["transitions"][0]
    assert graph.transitions[0].tolist() == [*first["from"], *first["to"]]
    assert graph.distances[0] == np.float32(first["distance"]) and graph.distances.max() <= 0.05
    assert graph.clips[0]["file"] == WALK and graph.options["threshold"] == 0.05
    with pytest.raises(mocap.MocapError):
        graph.write(tmp_path / ".." / Path(WALK))


def test_a_walk_is_that_of_the_program_and_of_a_job(program: Path, tmp_path: Path) -> None:
    graph = mocap.graph(WALK)
    graph.write(tmp_path / "graph.json")
    read = mocap.Graph.read(tmp_path / "graph.json")
    for words, options in (
        (["--seconds", "7", "--seed", "3"], {"seconds": 7, "seed": 3}),
        (["--path", "0/0+0/8"], {"path": [(0, 0), (0, 8)]}),
        (["--through", "cmu_12_01_walk@3", WALK + "@1"], {"through": ["cmu_12_01_walk@3", WALK + "@1"]}),
    ):
        theirs, of_job = (tmp_path / f"{name}.bvh" for name in ("theirs", "job"))
        walk = [program, "graph", "walk", tmp_path / "graph.json", *words, "-o", theirs, "--json", "-q", "--force"]
        done = subprocess.run(walk, check=True, capture_output=True)
        scene, report = read.walk(**options)
        assert report == json.loads(done.stdout)
        made, wanted = scene.to_numpy(out_unit="cm").positions, mocap.read(theirs).to_numpy(out_unit="cm").positions
        assert made.shape == wanted.shape and np.abs(made - wanted).max() < 0.01 * np.abs(wanted).max()
        job = {"source": {"inputs": [WALK]}, "graph": {}, "walk": options, "write": {"output": of_job, "force": True}}
        assert mocap.run(job)["walk"] == report
        assert of_job.read_bytes() == theirs.read_bytes()


def test_what_cannot_be_is_refused(tmp_path: Path) -> None:
    graph = mocap.graph(WALK)
    for options in ({}, {"seconds": 1, "through": ["a", "b"]}, {"seconds": -1}, {"path": [(0, 0)]}, {"through": ["a", "b"]}):
        with pytest.raises(mocap.MocapError):
            graph.walk(**options)
    with pytest.raises(ValueError):
        graph.walk(seed=-1, seconds=1)
    with pytest.raises(mocap.MocapError):
        graph.matrix(0, 1)
    with pytest.raises(mocap.MocapError):
        mocap.graph([WALK, REAL / "z_up_dab.bvh"])
    with pytest.raises(mocap.MocapError):
        mocap.graph(WALK, threshold=1e-9)
    graph.write(tmp_path / "graph.json")
    text = (tmp_path / "graph.json").read_text()
    (tmp_path / "cut.json").write_text(text[: len(text) // 2])
    with pytest.raises(mocap.MocapError, match="graph"):
        mocap.Graph.read(tmp_path / "cut.json")
    with pytest.raises(FileNotFoundError):
        mocap.Graph.read(tmp_path / "none.json")
    clip = tmp_path / "walk.bvh"
    clip.write_bytes(Path(WALK).read_bytes())
    other = mocap.graph(clip)
    clip.write_bytes(Path(WALK).read_bytes() + b"\n")
    with pytest.raises(mocap.MocapError, match="changed"):
        other.walk(3)
