"""Attacks `mocap mcp` with hostile messages. See README.md."""

import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

FIXTURES = Path(__file__).resolve().parents[2] / "fixtures"
META = {
    "io.modelcontextprotocol/protocolVersion": "2026-07-28",
    "io.modelcontextprotocol/clientCapabilities": {},
}


class Server:
    def __init__(self, mocap, folder):
        pipe = subprocess.PIPE
        self.process = subprocess.Popen([mocap, "mcp", "--root", str(folder)], stdin=pipe, stdout=pipe, stderr=pipe)
        self.id = 0

    def send(self, line):
        self.process.stdin.write(line + b"\n")
        self.process.stdin.flush()

    def receive(self):
        return json.loads(self.process.stdout.readline())

    def request(self, method, **params):
        self.id += 1
        message = {"jsonrpc": "2.0", "id": self.id, "method": method, "params": {"_meta": META} | params}
        self.send(json.dumps(message).encode())
        answer = self.receive()
        assert answer["id"] == self.id, answer
        return answer

    def call(self, tool, **arguments):
        return self.request("tools/call", name=tool, arguments=arguments)["result"]

    def peak_megabytes(self):
        status = Path(f"/proc/{self.process.pid}/status")
        if not status.exists():
            return 0
        line = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM"))
        return int(line.split()[1]) / 1024


def make_root(whole):
    """A folder, and files outside it that the server must neither change nor read."""
    root = whole / "root"
    root.mkdir()
    shutil.copy(FIXTURES / "real/cmu_short.bvh", root / "take.bvh")
    shutil.copy(FIXTURES / "real/cmu_short.bvh", whole / "secret.bvh")
    (whole / "folder").mkdir()
    shutil.copy(FIXTURES / "real/cmu_short.bvh", whole / "folder/secret.bvh")
    (root / "mine.glb").write_bytes(b"somebody's work")
    os.symlink(whole / "secret.bvh", root / "link.bvh")
    os.symlink(whole / "folder", root / "linked")
    os.symlink(whole / "new.glb", root / "dangling.glb")
    # A search that follows these links never ends.
    (root / "loops").mkdir()
    os.symlink(".", root / "loops/self")
    os.symlink("../loops", root / "loops/again")
    os.symlink("/", root / "loops/everything")
    # A reader of this file waits forever.
    os.mkfifo(root / "pipe.bvh")
    # A file that refers to a file outside the folder: its buffer is a link.
    (whole / "secret.bin").write_bytes(bytes(64))
    os.symlink(whole / "secret.bin", root / "buffer.bin")
    buffer = {"uri": "buffer.bin", "byteLength": 64}
    gltf = {"asset": {"version": "2.0"}, "buffers": [buffer], "nodes": [{"name": "a"}], "scenes": [{"nodes": [0]}]}
    gltf["bufferViews"] = [{"buffer": 0, "byteLength": 64}]
    gltf["accessors"] = [{"bufferView": 0, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [0]}]
    gltf["accessors"].append({"bufferView": 0, "componentType": 5126, "count": 2, "type": "VEC3"})
    sampler = {"input": 0, "output": 1}
    channel = {"sampler": 0, "target": {"node": 0, "path": "translation"}}
    gltf["animations"] = [{"samplers": [sampler], "channels": [channel]}]
    (root / "refers.gltf").write_text(json.dumps(gltf))
    return root


def snapshot(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file() and not path.is_symlink()}


def paths(server, whole):
    """The server refuses paths out of the folder, and does not replace files that the session has not written."""
    outside = [
        "../secret.bvh",
        "../none.bvh",
        "./x/../../secret.bvh",
        str(whole / "secret.bvh"),
        "/etc/passwd",
        "/dev/stdin",
        "link.bvh",
        "linked/secret.bvh",
        "linked/*.bvh",
        "-",
        "\0",
        "a" * 5000,
        "../" * 2000,
    ]
    for path in outside:
        answers = [
            server.call("inspect", input=path),
            server.call("check", inputs=[path]),
            server.call("survey", inputs=["take.bvh", path]),
            server.call("verify", source="take.bvh", result=path),
            server.call("sheet", inputs=[path]),
            server.call("convert", inputs=[path], output="out.glb"),
            server.call("retarget", inputs=["take.bvh"], character=path, output="out.glb"),
            server.call("edit", inputs=["take.bvh"], step=["concat:with=2"], **{"with": [path]}, output="out.glb"),
            server.call("run", job={"source": {"inputs": [path]}, "write": {"output": "out.glb"}}),
            server.call("find", database=path, like="take.bvh"),
            server.call("find", database="take.bvh", like=f"{path}@0..1"),
            server.call("index", inputs=[path], output="out.mdb"),
            server.call("list", folder=path),
            server.call("run", job={"read": {"skeleton": path}, "source": {"inputs": ["take.bvh"], "map": path}}),
        ]
        for index, answer in enumerate(answers):
            text = answer["content"][0]["text"]
            # A file among many that cannot be read gives a row.
            is_row = (index, True) in [(1, '"error":1' in text), (2, '"unreadable":1' in text)]
            assert answer["isError"] or is_row, (path, index, text)
            assert "frames\":75" not in text.replace("take.bvh", "") or is_row, (path, text)
    for path in ["../new.glb", str(whole / "new.glb"), "dangling.glb", "linked/new.glb", "mine.glb", "-", ""]:
        for tool, arguments in [
            ("convert", {"inputs": ["take.bvh"], "output": path}),
            ("edit", {"inputs": ["take.bvh"], "step": ["mirror"], "output": path}),
            ("clean", {"inputs": ["take.bvh"], "output": path}),
            ("survey", {"inputs": ["take.bvh"], "output": path}),
            ("sheet", {"inputs": ["take.bvh"], "output": path}),
            ("index", {"inputs": ["take.bvh"], "output": path}),
            ("run", {"job": {"source": {"inputs": ["take.bvh"]}, "write": {"output": path, "force": True}}}),
        ]:
            answer = server.call(tool, **arguments)
            assert answer["isError"], (tool, path, answer)
    for folder in ["../new/", ".", "linked/"]:
        answer = server.call("convert", inputs=["take.bvh"], output=folder, to="bvh")
        assert answer["isError"], (folder, answer)
    # A folder with a link to the outside: the result omits the entries outside.
    for inputs in [".", "*", "**", "**/*", "*/*", "*/*/*/*/*/*", "[!x]*/**"]:
        found = server.call("survey", inputs=[inputs])["structuredContent"]
        assert not any("secret" in clip["file"] or "link" in clip["file"] for clip in found.get("clips", [])), found
        assert "everything" not in json.dumps(found), found
    answer = server.call("inspect", input="refers.gltf")
    assert answer["isError"] and "outside" in answer["content"][0]["text"], answer


def own_outputs(server):
    """The session may replace its own outputs, but never an input."""
    first = server.call("convert", inputs=["take.bvh"], output="out.bvh")
    again = server.call("convert", inputs=["take.bvh"], output="out.bvh")
    assert not first["isError"] and not again["isError"], again
    assert server.call("convert", inputs=["out.bvh"], output="out.bvh")["isError"]
    assert server.call("convert", inputs=["take.bvh"], output="take.bvh")["isError"]


def messages(server):
    """Invalid messages."""
    wrong = {
        b"{": -32700,
        b"\xff\xfe": -32700,
        b"[" * 100_000: -32700,
        b"[]": -32600,
        b"1": -32600,
        b'[{"jsonrpc": "2.0", "id": 1, "method": "ping"}]': -32600,
        b'{"jsonrpc": "2.0", "id": 1.5, "method": "ping"}': -32600,
        b'{"jsonrpc": "2.0", "id": 1' + b"0" * 400 + b', "method": "ping"}': -32700,
        b'{"jsonrpc": "2.0", "id": 99999999999999999999, "method": "ping"}': -32600,
        b'{"jsonrpc": "2.0", "id": 1, "method": "tools/call", "params": {"_meta": {"progressToken": []}}}': -32602,
        b'{"jsonrpc": "1.0", "id": 1, "method": "ping"}': -32600,
        b'{"jsonrpc": "2.0", "id": 1}': -32600,
        b'{"jsonrpc": "2.0", "id": null, "method": "ping"}': -32600,
        b'{"jsonrpc": "2.0", "id": {}, "method": "ping"}': -32600,
        b'{"jsonrpc": "2.0", "id": 1, "method": "ping", "params": []}': -32602,
        b'{"jsonrpc": "2.0", "id": 1, "method": "tools/list"}': -32602,
        b'{"jsonrpc": "2.0", "id": 1, "method": "' + b"a" * 10_000_000 + b'"}': -32600,
    }
    for line, code in wrong.items():
        server.send(line)
        answer = server.receive()
        assert answer["error"]["code"] == code, (line[:80], answer)
    unknown = META | {"io.modelcontextprotocol/protocolVersion": "2030-01-01"}
    answer = server.request("tools/list", _meta=unknown)
    assert answer["error"]["code"] == -32022 and answer["error"]["data"]["supported"] == ["2026-07-28"], answer
    assert server.request("nonsense")["error"]["code"] == -32601
    assert server.request("tools/call", name="rm")["error"]["code"] == -32602
    assert server.request("tools/call", name="check", arguments=[])["error"]["code"] == -32602
    assert server.request("resources/read", uri="file:///etc/passwd")["error"]["code"] == -32602
    # None of these gets an answer: the next answer belongs to the request.
    nobody = [{"requestId": id} for id in (1, "1", None, 10**30, [], {})] + [None, [], "1"]
    cancelled = [{"method": "notifications/cancelled", "params": params} for params in nobody]
    for silent in [{"method": "notifications/cancelled"}, {"method": "nonsense"}, {"id": 1, "result": {}}, *cancelled]:
        server.send(json.dumps({"jsonrpc": "2.0"} | silent).encode())
    server.send(b"")
    answer = server.call("convert", inputs=["take.bvh"], output="x.glb", nonsense=1)
    assert answer["isError"] and "nonsense" in answer["content"][0]["text"]
    for value in [{"a": 1}, [[]], 1e300, "x" * 900_000]:
        assert server.call("convert", inputs=["take.bvh"], output="x.glb", trim=value)["isError"], value


def calls_at_once(server):
    """A call that hangs blocks no other call, and ends when it is cancelled. Only one call at a time may use an
    identifier."""

    def send(id, method="tools/call", **params):
        message = {"jsonrpc": "2.0", "id": id, "method": method, "params": {"_meta": META} | params}
        server.send(json.dumps(message).encode())

    def cancel(id):
        message = {"jsonrpc": "2.0", "method": "notifications/cancelled", "params": {"requestId": id}}
        server.send(json.dumps(message).encode())

    long = "x" * 100_000
    hang = {"name": "inspect", "arguments": {"input": "pipe.bvh"}}
    for id in ["hang", 2**63, long]:
        send(id, **hang)
        send("ping", "ping")
        assert server.receive()["id"] == "ping"
        send(id, **hang)
        answer = server.receive()
        assert answer["id"] == id and answer["error"]["code"] == -32600, answer
    assert server.call("inspect", input="take.bvh")["structuredContent"]["frames"] == 75
    for id in ["hang", 2**63, long]:
        cancel(id)
    # Sends more calls than may wait: each gets one answer, or is cancelled.
    for id in range(1000, 1300):
        send(id, **hang)
    for id in range(1000, 1300):
        cancel(id)
    send("after", name="inspect", arguments={"input": "take.bvh"})
    refused = set()
    while (answer := server.receive())["id"] != "after":
        assert answer["error"]["code"] == -32000 and answer["id"] not in refused, answer
        refused.add(answer["id"])
    assert answer["result"]["structuredContent"]["frames"] == 75, answer


def random_calls(server, whole, count):
    """Calls of every tool with invalid arguments, some at the same time: each gets an answer, and none runs."""
    dice = random.Random(int(os.environ.get("MOCAP_SEED", 7)))
    tools = server.request("tools/list")["result"]["tools"]
    paths = ["../secret.bvh", "/etc/passwd", str(whole / "secret.bvh"), "linked/secret.bvh", "pipe", "loops/self/x", "", "."]
    odd = [None, True, -1, 1e308, [], {}, [[]], {"a": 1}, "\0", "-", "--force", "x" * 10_000, "[" * 100, "**/" * 500 + "*"]

    def value(depth=0):
        if depth < 3 and dice.random() < 0.2:
            return [value(depth + 1) for _ in range(dice.randrange(4))]
        if depth < 3 and dice.random() < 0.1:
            return {dice.choice(paths): value(depth + 1)}
        return dice.choice(paths + odd)

    waiting = set()
    for number in range(count):
        tool = dice.choice(tools)
        names = [*tool["inputSchema"]["properties"], "nonsense", "../x"]
        arguments = {name: value() for name in dice.sample(names, dice.randrange(len(names)))}
        # A tool whose output path leads out of the folder does nothing, whatever its other arguments.
        for name in {"output", "html", "sarif", "matrix"} & {*names}:
            arguments[name] = dice.choice(["../out.glb", str(whole / "out.glb"), "dangling.glb", "mine.glb", "linked/x.glb"])
        id = dice.choice([f"call {number}", number + 10_000])
        params = {"_meta": META | {"progressToken": number}, "name": tool["name"], "arguments": arguments}
        server.send(json.dumps({"jsonrpc": "2.0", "id": id, "method": "tools/call", "params": params}).encode())
        waiting.add(id)
        while len(waiting) > 8 or waiting and number == count - 1:
            answer = server.receive()
            if "method" in answer:
                continue
            waiting.remove(answer["id"])
            assert "error" in answer or "result" in answer, answer


def main(mocap):
    with tempfile.TemporaryDirectory() as name:
        whole = Path(name).resolve()
        root = make_root(whole)
        before = snapshot(whole)
        server = Server(mocap, root)
        paths(server, whole)
        assert snapshot(whole) == before, set(snapshot(whole)) ^ set(before)
        messages(server)
        calls_at_once(server)
        random_calls(server, whole, 950)
        assert snapshot(whole) == before, set(snapshot(whole)) ^ set(before)
        own_outputs(server)
        assert snapshot(whole) == before | {root / "out.bvh": (root / "out.bvh").read_bytes()}
        peak = server.peak_megabytes()
        assert peak < 150, peak
        server.process.stdin.close()
        assert server.process.wait(timeout=10) == 0
        said = server.process.stderr.read()
        assert b"panicked" not in said, said
    print(f"mcp: hostile calls refused, nothing outside of the folder read or written; {peak:.0f} MB at most")


main(sys.argv[1])
