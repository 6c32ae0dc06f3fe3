"""`blender --command cad_shadow …`: the command line of `main.py`, inside a full Blender."""

from __future__ import annotations

import bpy

NAME = "cad_shadow"
_handles: list[object] = []


def run(argv: list[str]) -> int:
    """Blender calls this with everything after the command's name; the result is its exit code."""
    from .main import main

    return main(argv, is_apart=True)


def register() -> None:
    """Offer the command."""
    _handles.append(bpy.utils.register_cli_command(NAME, run))


def unregister() -> None:
    """Take the command back."""
    while _handles:
        bpy.utils.unregister_cli_command(_handles.pop())
