"""The command `raystep`."""

import sys

from . import _raystep


def main() -> int:
    """Runs the command line, and returns its exit code."""
    return _raystep.main(["raystep", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
