"""What a command is to this program: the row that its module in `commands/` registers as its `ROW`. No bpy."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import bpy

    from ..blender.render_wish import RenderWish


def no_mistake(_args: Namespace) -> str | None:
    """Nothing that its arguments together could say wrong."""
    return None


@dataclass(frozen=True, eq=False)
class Command:
    """A row: its words, its `place` in the list of commands, its arguments, and its work.

    That is `work` on the scene of each input, which gives the report and a line that sums it up; or `alone`, which needs no input and
    gives the exit code. `mistake` says what is wrong with arguments together. Nothing of Blender is imported before work begins: the words
    are also read where Blender is not.
    """

    name: str
    place: int
    help: str
    description: str
    add_arguments: Callable[[ArgumentParser], None]
    work: Callable[[bpy.types.Scene, RenderWish, Path, Namespace], tuple[dict[str, object], str]] | None = None
    alone: Callable[[Namespace], int] | None = None
    mistake: Callable[[Namespace], str | None] = no_mistake
