"""`python -m addon COMMAND …`: the command line where only the `bpy` module is installed."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from . import register, unregister
from .cli.main import main


@contextmanager
def attached() -> Iterator[None]:
    """The add-on attached to Blender while this lasts, unless it is already enabled."""
    import bpy  # it talks: not before the command line has taken the standard output

    if hasattr(bpy.types.Scene, "cad_shadow"):
        yield
        return
    register()
    try:
        yield
    finally:
        unregister()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:], attached, is_apart=True))
