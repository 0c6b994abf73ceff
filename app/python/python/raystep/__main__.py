"""The command `raystep`."""

import json
import os
import sys

from . import _raystep, _sweep


def main() -> int:
    """Runs the command line, and returns its exit code."""
    # The jobs of a sweep are processes of the same program, which is not the executable here.
    os.environ.setdefault(_sweep.COMMAND, json.dumps([sys.executable, "-m", "raystep"]))
    if _sweep.takes(sys.argv[1:]):
        return _sweep.main(sys.argv[1:])
    return _raystep.main(["raystep", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
