"""Runs the suites and prints mocap's results for their files. See README.md."""

import argparse
import os
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import assimp
import bvh
import gltf
import mjcf
import robots
import usd
from motion import Motion, Nothing, Refused, faults

SUITES = {"assimp": assimp, "bvh": bvh, "robots": robots, "mjcf": mjcf, "usd": usd}
# The number of files of a suite without --all.
SAMPLE = 12
VERDICTS = ["right", "refused rightly", "read alone", "refused wrongly", "wrong"]
BAD = VERDICTS[-2:]


def converted(path, folder, options, times):
    """The motion of mocap's GLB file at these seconds, read by another reader."""
    output = Path(folder) / "out.glb"
    done = subprocess.run([os.environ["MOCAP"], "convert", path, output, "--force", *options], capture_output=True, text=True, timeout=120)
    if done.returncode not in (0, 1):
        raise RuntimeError(f"exit code {done.returncode}: {done.stderr[-200:]}")
    if done.returncode:
        errors = [line for line in done.stderr.splitlines() if "error" in line]
        raise Refused((errors or done.stderr.splitlines() or [""])[0])
    return gltf.motion(output, times)


def outcome(reader, path):
    try:
        return reader(path)
    except (Nothing, Refused) as refusal:
        return refusal


def verdict(path, other, second, folder, options):
    theirs = outcome(other, path)
    try:
        ours = converted(path, folder, options, getattr(theirs, "times", None))
    except Nothing:
        ours = Motion(0.0, {})
    except Refused as refusal:
        rightly = isinstance(theirs, Exception) or isinstance(outcome(second, path), Exception)
        return ("refused rightly" if rightly else "refused wrongly"), str(refusal)
    if isinstance(theirs, Exception):
        return "read alone", str(theirs)
    found = list(faults(ours, theirs))
    return ("wrong" if found else "right"), "; ".join(found)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--all", action="store_true")
    parser.add_argument("suites", nargs="*", choices=[*SUITES, []], default=[])
    args = parser.parse_args()
    total = dict.fromkeys(VERDICTS, 0)
    for name in args.suites or SUITES:
        begin, count = time.monotonic(), dict.fromkeys(VERDICTS, 0)
        listed = list(SUITES[name].files(args.all))
        if not args.all:
            listed = random.Random(f"{os.environ['MOCAP_SEED']} {name}").sample(listed, min(SAMPLE, len(listed)))
        with tempfile.TemporaryDirectory() as folder:
            for path, other, second in listed:
                found, why = verdict(path, other, second, folder, getattr(SUITES[name], "OPTIONS", []))
                count[found] += 1
                total[found] += 1
                if found in BAD:
                    print(f"{found}: {path}: {why}", flush=True)
        print(line(name, count), f"in {time.monotonic() - begin:.0f} s", flush=True)
    print(line("all", total))
    sys.exit(any(total[found] for found in BAD))


def line(name, count):
    return f"suites: {name}: {sum(count.values())} tried, " + ", ".join(f"{count[found]} {found}" for found in VERDICTS)


if __name__ == "__main__":
    main()
