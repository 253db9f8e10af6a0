"""The program `vademecum`, as the wheel installs it."""

import sys

from . import _native


def main() -> None:
    sys.exit(_native.program(["vademecum", *sys.argv[1:]]))
