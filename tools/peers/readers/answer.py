"""The answer of a reader in this folder: the skeleton of a file in world space at one frame.

    python3 READER FILE last|FRAME replace|add OUT

OUT becomes `{"frames", "rate", "nodes": [{"name", "parent", "position", "end", "optional"}], "said"}`, where `parent`
is an index into `nodes`, and `said` has the peer's warnings. A file without frames gives its rest pose. The answer is
not on standard output, because a peer may print there. A peer that refuses a file ends the program by its exception, or
with status 1; a peer that panics or dies ends it with status 101.
"""

import json
import subprocess
import sys

CRASHED = 101
said = []


def node(name, parent, position, end=False, optional=False):
    """`end` marks an End Site, and is `None` if the peer does not distinguish End Sites from joints.

    `optional` marks a point that the peer always gives, even if it is not in the file.
    """
    return {
        "name": str(name),
        "parent": parent,
        "position": [float(value) for value in position],
        "end": end,
        "optional": optional,
    }


def index_of_frame(frame, frames):
    """The requested index: of the last frame, or a given index if the peer has as many frames."""
    return frames - 1 if frame == "last" else min(int(frame), frames - 1)


def hand_back(read):
    """Runs `read(file, frame, root)`, which returns the number of frames, the frame rate, and the nodes."""
    file, frame, root, out = sys.argv[1:]
    frames, rate, nodes = read(file, frame, root)
    with open(out, "w", encoding="utf-8") as answer:
        json.dump({"frames": frames, "rate": rate, "nodes": nodes, "said": said}, answer)


def output_of(*command):
    """Returns the output of a peer's program. If the program fails, this program ends in the same way."""
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.stderr.write(done.stderr)
        sys.exit(CRASHED if done.returncode < 0 or done.returncode == CRASHED else 1)
    return done.stdout
