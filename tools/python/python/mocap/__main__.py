"""The command ``mocap``, also as ``python -m mocap``."""

from __future__ import annotations

import signal
import sys
from typing import NoReturn

from . import _mocap

# Starts the command in a new process. The current folder is not in the path: a module there may have the same name.
_STARTER = "import sys; sys.path[:] = filter(None, sys.path); from mocap.__main__ import main; main()"


def main() -> NoReturn:
    """Runs the command line, and ends the process with the exit code of ``mocap``."""
    # By default Python handles Ctrl-C only when the interpreter runs again. Restore the default action, so that Ctrl-C
    # ends the command immediately.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    _mocap.main(["mocap", *sys.argv[1:]], [sys.executable, "-c", _STARTER])


if __name__ == "__main__":
    main()
