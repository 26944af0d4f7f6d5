"""Lists and calls every tool of `mocap mcp` with the client of PyPI `mcp`, and imitates an agent. See README.md."""

import asyncio
import base64
import json
import shutil
import struct
import sys
import tempfile
from pathlib import Path

import jsonschema
from mcp import Client, StdioServerParameters

FIXTURES = Path(__file__).resolve().parents[2] / "fixtures"
TOOLS = (
    "list inspect skeleton check survey index find match graph walk "
    "convert retarget robot edit clean sheet verify score run read"
).split()

# Calls of every tool: its name, its arguments, and required parts of the answer.
CALLS = json.loads((Path(__file__).parent / "calls.json").read_text())


def make_root(folder):
    (folder / "takes").mkdir()
    for name, source in [("walk", "cmu_12_01_walk"), ("short", "cmu_short"), ("dance", "rokoko_dance")]:
        shutil.copy(FIXTURES / "real" / f"{source}.bvh", folder / "takes" / f"{name}.bvh")
    shutil.copy(FIXTURES / "characters/human_default.glb", folder / "hero.glb")
    shutil.copy(FIXTURES / "robots/h1.urdf", folder)


def client(mocap, folder, mode):
    server = StdioServerParameters(command=mocap, args=["mcp", "--root", str(folder)])
    return Client(server, mode=mode)


def files(folder):
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


async def calls(mocap, mode, revision):
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        make_root(folder)
        async with client(mocap, folder, mode) as session:
            assert session.protocol_version == revision, session.protocol_version
            assert session.server_info.name == "mocap"
            tools = (await session.list_tools()).tools
            assert [tool.name for tool in tools] == TOOLS, [tool.name for tool in tools]
            schemas = {tool.name: tool.input_schema for tool in tools}
            answers = {tool.name: tool.output_schema for tool in tools}
            for schema in [*schemas.values(), *answers.values()]:
                jsonschema.Draft202012Validator.check_schema(schema)
            count = 0
            for tool, arguments, wanted in CALLS:
                jsonschema.validate(arguments, schemas[tool])
                if "dry-run" in schemas[tool]["properties"]:
                    before = files(folder)
                    dry = await session.call_tool(tool, arguments | {"dry-run": True})
                    assert not dry.is_error, (tool, dry.content)
                    jsonschema.validate(dry.structured_content, answers[tool])
                    assert files(folder) == before, f"{tool} has written in a dry run"
                    count += 1
                count += tool != "read"
                answer = await session.call_tool(tool, arguments)
                found = answer.structured_content
                assert not answer.is_error, (tool, found)
                jsonschema.validate(found, answers[tool])
                assert all(key in found for key in wanted), (tool, sorted(found))
                assert json.loads(answer.content[0].text) == found
                output = arguments.get("output") or arguments.get("job", {}).get("write", {}).get("output")
                assert output is None or (folder / output).exists(), (tool, output)
                if tool == "sheet":
                    picture = answer.content[1]
                    assert picture.mime_type == "image/png"
                    assert base64.b64decode(picture.data).startswith(b"\x89PNG\r\n\x1a\n")
            wrong = await session.call_tool("convert", {"inputs": ["takes/none.bvh"], "output": "none.glb"})
            assert wrong.is_error and "none.bvh" in wrong.content[0].text
            assert wrong.structured_content is None, wrong
            wrong = await session.call_tool("edit", {"inputs": ["takes/short.bvh"], "step": ["smoth"], "output": "n.glb"})
            assert wrong.is_error and "smooth" in wrong.content[0].text, wrong.content
            resources = (await session.list_resources()).resources
            reports = [resource for resource in resources if "reports/" in str(resource.uri)]
            assert len(reports) == count + 2, len(reports)
            for resource in resources:
                (contents,) = (await session.read_resource(resource.uri)).contents
                json.loads(contents.text)
    print(f"mcp: revision {revision}: {len(tools)} tools listed and called, {len(resources)} resources read")


def glb(path):
    bytes = path.read_bytes()
    magic, version, length, chunk, kind = struct.unpack_from("<4sIIII", bytes)
    assert (magic, version, length, kind) == (b"glTF", 2, len(bytes), 0x4E4F534A)
    return json.loads(bytes[20 : 20 + chunk])


async def agent(mocap):
    """Makes a clip on a character from a folder of takes, with decisions by the answers alone."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        make_root(folder)
        async with client(mocap, folder, "auto") as session:
            count = 0

            async def call(tool, **arguments):
                nonlocal count
                count += 1
                answer = await session.call_tool(tool, arguments)
                assert not answer.is_error, (tool, answer.structured_content)
                return answer

            listed = (await call("list")).structured_content["files"]
            assert {"hero.glb", "takes/walk.bvh"} < {file["file"] for file in listed}, listed
            clips = (await call("survey", inputs=["."], where="walking > 1")).structured_content["clips"]
            take = clips[0]
            assert take["verdict"] == "good", clips
            await call("edit", inputs=[take["file"]], step=["foot-lock", "loop"], output="cycle.bvh")
            put = await call(
                "retarget", inputs=["cycle.bvh"], character="hero.glb", output="game.glb", **{"max-error": "1mm"}
            )
            (clip,) = put.structured_content["clips"]
            assert clip["verdict"] != "poor" and clip["worst_limb"]["mean_degrees"] < 10, clip
            found = (await call("inspect", input="game.glb")).structured_content
            seen = await call("sheet", inputs=["game.glb"], poses=5)
            assert any(block.type == "image" for block in seen.content)
        made, hero = glb(folder / "game.glb"), glb(folder / "hero.glb")
        for part in ("meshes", "skins", "materials", "nodes"):
            assert len(made.get(part, [])) == len(hero.get(part, [])), part
        assert len(made["animations"]) == len(hero.get("animations", [])) + 1
        assert count <= 7
        size = (folder / "game.glb").stat().st_size
    print(f"mcp: {take['file']} to game.glb in {count} calls: {found['frames']} frames, {size} bytes")


async def main(mocap):
    await calls(mocap, "auto", "2026-07-28")
    await calls(mocap, "legacy", "2025-11-25")
    await agent(mocap)


asyncio.run(main(sys.argv[1]))
