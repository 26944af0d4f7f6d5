"""Tests the commands of the wheel as a person types them, each in its own process."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import sysconfig
import time
from pathlib import Path
from typing import Any

import pytest

import mocap

COMMANDS = Path(sysconfig.get_path("scripts"))
HOW = {
    "mocap": [str(COMMANDS / "mocap")],
    "mocap-kit": [str(COMMANDS / "mocap-kit")],
    "module": [sys.executable, "-m", "mocap"],
}


def run(*words: str | Path, how: str = "mocap", **options: Any) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run([*HOW[how], *map(str, words)], check=False, capture_output=True, **options)


@pytest.mark.parametrize("how", HOW)
def test_each_command_writes_what_the_program_writes(how: str, program: Path, walk: Path, tmp_path: Path) -> None:
    expected = tmp_path / "expected.glb"
    subprocess.run([program, "convert", walk, expected, "--quiet"], check=True)
    done = run("convert", walk, tmp_path / "walk.glb", how=how)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "walk.glb").read_bytes() == expected.read_bytes()


def test_exit_codes_and_words_are_those_of_the_program(program: Path, tmp_path: Path) -> None:
    broken = tmp_path / "broken.bvh"
    broken.write_text("HIERARCHY\nROOT a\n{\n  OFFSET 0 zero 0\n}\n")
    for words in (
        ["-V"],
        ["--help"],
        ["convert"],
        ["convrt", "a", "b"],
        ["convert", "none.bvh", "a.glb"],
        ["check", "broken.bvh"],
        ["convert", "broken.bvh", "a.glb"],
        # Options are spelled as on a command line, not as in Python.
        ["fk", "broken.bvh", "-o", "a.npz", "--contact-height", "3cm"],
        ["convert", "broken.bvh", "a.glb", "--max-error", "-1mm"],
    ):
        expected = subprocess.run([program, *words], check=False, capture_output=True, cwd=tmp_path)
        done = run(*words, cwd=tmp_path)
        assert (done.returncode, done.stdout, done.stderr) == (expected.returncode, expected.stdout, expected.stderr)


def test_pipes_carry_bytes(program: Path, walk: Path) -> None:
    words = ["convert", "-", "-", "--to", "glb", "--quiet"]
    expected = subprocess.run([program, *words], check=True, capture_output=True, input=walk.read_bytes()).stdout
    assert run(*words, input=walk.read_bytes()).stdout == expected
    assert expected[:4] == b"glTF"


def test_the_end_of_a_long_output_is_there(program: Path, walk: Path) -> None:
    words = ["fk", walk, "-o", "-"]
    expected = subprocess.run([program, *words], check=True, capture_output=True).stdout
    assert run(*words).stdout == expected


def test_a_reader_that_closes_its_pipe_is_no_error(walk: Path) -> None:
    with subprocess.Popen([*HOW["mocap"], "fk", walk, "-o", "-"], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as child:
        assert child.stdout is not None and child.stderr is not None
        child.stdout.read(10)
        child.stdout.close()
        assert child.wait(60) == 0
        assert child.stderr.read() == b""


@pytest.mark.skipif(os.name == "nt", reason="signals of Unix")
def test_an_interrupt_ends_the_command_at_once(tmp_path: Path) -> None:
    # The command waits forever for standard input, in native code.
    with subprocess.Popen([*HOW["mocap"], "convert", "-", tmp_path / "a.glb"], stdin=subprocess.PIPE) as child:
        time.sleep(1.5)
        assert child.poll() is None
        child.send_signal(signal.SIGINT)
        assert child.wait(10) == -signal.SIGINT
    assert not (tmp_path / "a.glb").exists()


def test_the_server_for_agents_starts_its_calls_again(walk: Path, tmp_path: Path) -> None:
    # A module of this name in the current folder does not belong to the package.
    (tmp_path / "mocap.py").write_text("raise SystemExit('the wrong module')")
    (tmp_path / "walk.bvh").write_bytes(walk.read_bytes())
    about = {"protocolVersion": "2025-06-18", "capabilities": {}, "clientInfo": {"name": "test", "version": "1"}}
    call = {"name": "inspect", "arguments": {"input": "walk.bvh"}}
    messages = [
        {"jsonrpc": "2.0", "id": 1, "method": "initialize", "params": about},
        {"jsonrpc": "2.0", "method": "notifications/initialized"},
        {"jsonrpc": "2.0", "id": 2, "method": "tools/list"},
        {"jsonrpc": "2.0", "id": 3, "method": "tools/call", "params": call},
    ]
    with subprocess.Popen(
        [*HOW["mocap"], "mcp", "--root", "."], stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=tmp_path
    ) as child:
        assert child.stdin is not None and child.stdout is not None
        child.stdin.write("".join(json.dumps(message) + "\n" for message in messages).encode())
        child.stdin.flush()
        answers = {}
        while 3 not in answers:
            answer = json.loads(child.stdout.readline())
            answers[answer.get("id")] = answer
        child.stdin.close()
        child.wait(30)
    assert not answers[3]["result"].get("isError"), answers[3]
    assert "524" in json.dumps(answers[3]["result"])


def test_the_unrelated_package_is_noticed(tmp_path: Path) -> None:
    folder = tmp_path / "mocap-0.1.3.dist-info"
    folder.mkdir()
    (folder / "METADATA").write_text("Metadata-Version: 2.1\nName: mocap\nVersion: 0.1.3\n")
    paths = {**os.environ, "PYTHONPATH": str(tmp_path)}
    said = subprocess.run([sys.executable, "-c", "import mocap"], env=paths, check=True, capture_output=True, text=True)
    assert "the package mocap 0.1.3 of PyPI" in said.stderr
    said = subprocess.run([sys.executable, "-c", "import mocap"], check=True, capture_output=True, text=True)
    assert said.stderr == ""
    assert mocap.__version__
