"""What the tests of the command line and the user's files share: a small model's text, small pictures, what a folder holds."""

import sys

import pytest

SMALL = ("--size", "96x64", "--map-size", "64", "--quiet")
BOX = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl red\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
OLD = b"what the user had"
posix = pytest.mark.skipif(sys.platform == "win32", reason="named pipes, devices and signals as POSIX has them")


def below(folder):
    return sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*"))
