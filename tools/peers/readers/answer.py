"""What a reader of this folder hands back: the skeleton of a file, in world space, at one frame.

    python3 READER FILE last|FRAME replace|add OUT

OUT becomes `{"frames", "rate", "nodes": [{"name", "parent", "position", "end", "optional"}], "said"}`, where `parent`
is an index into `nodes`, and `said` what the peer complained of and went on. A file of no frames gives its rest pose. A
peer may print what it likes, so the answer is not on the standard output. A peer that refuses a file ends the program by
its exception, or with status 1; one that panics or dies ends it with status 101.
"""

import json
import subprocess
import sys

CRASHED = 101
said = []


def node(name, parent, position, end=False, optional=False):
    """`end` marks an End Site, and is `None` where the peer does not tell it from a joint.

    `optional` marks a point that the peer gives whether the file has it or not.
    """
    return {
        "name": str(name),
        "parent": parent,
        "position": [float(value) for value in position],
        "end": end,
        "optional": optional,
    }


def index_of_frame(frame, frames):
    """The index that the driver asks for: of the last frame, or a given one where the peer has as many."""
    return frames - 1 if frame == "last" else min(int(frame), frames - 1)


def hand_back(read):
    """Runs `read(file, frame, root)`, which returns the count of frames, the frames in a second, and the nodes."""
    file, frame, root, out = sys.argv[1:]
    frames, rate, nodes = read(file, frame, root)
    with open(out, "w", encoding="utf-8") as answer:
        json.dump({"frames": frames, "rate": rate, "nodes": nodes, "said": said}, answer)


def output_of(*command):
    """What a peer's program prints, or the end of this one in the same way as of the other."""
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.stderr.write(done.stderr)
        sys.exit(CRASHED if done.returncode < 0 or done.returncode == CRASHED else 1)
    return done.stdout
