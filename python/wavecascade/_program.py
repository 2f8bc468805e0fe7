"""The console command ``cascade``."""

import sys

from wavecascade import _native


def main() -> int:
    """Run the program with the words of the command line; return its exit code."""
    return _native.program(["cascade", *sys.argv[1:]])
