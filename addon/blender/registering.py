"""Registering several things as one: all or none, and nothing that can be taken back stays because something else failed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol


class Registrable(Protocol):
    """What can be attached to Blender and detached again: a module with these two functions."""

    def register(self) -> None:
        """Attach it."""

    def unregister(self) -> None:
        """Detach it."""


@dataclass(frozen=True, eq=False)
class BlenderClass:
    """An operator, a panel, …: a class that Blender knows while it is attached."""

    cls: type

    def register(self) -> None:
        """Tell Blender."""
        import bpy

        bpy.utils.register_class(self.cls)

    def unregister(self) -> None:
        """Blender forgets it."""
        import bpy

        bpy.utils.unregister_class(self.cls)


@dataclass(frozen=True, eq=False)
class Appended:
    """What a menu or panel also draws, after its own."""

    to: Any
    draw: Callable[[Any, Any], None]

    def register(self) -> None:
        """Draw it from now on."""
        self.to.append(self.draw)

    def unregister(self) -> None:
        """No more."""
        self.to.remove(self.draw)


def attach(parts: Sequence[Registrable]) -> None:
    """Register in order. If one fails, those before it are detached and its error is raised."""
    done: list[Registrable] = []
    try:
        for part in parts:
            part.register()
            done.append(part)
    except BaseException as error:
        for note in _detached(reversed(done)):
            error.add_note(f"and while taking back: {note!r}")
        raise


def detach(parts: Sequence[Registrable]) -> None:
    """Unregister in reverse order. Each is tried; afterwards the first error is raised, the others noted on it."""
    errors = _detached(reversed(parts))
    if errors:
        for other in errors[1:]:
            errors[0].add_note(f"and then: {other!r}")
        raise errors[0]


def _detached(parts: Iterable[Registrable]) -> list[BaseException]:
    """Unregister each; what went wrong."""
    errors = []
    for part in parts:
        try:
            part.unregister()
        except BaseException as error:  # the others must be tried too; raised by the caller
            errors.append(error)
    return errors


def is_python_module(app: object) -> bool:
    """Whether Blender, whose `bpy.app` is given, is a module of this Python and not a program of its own. Blender 4.3 cannot say it."""
    return getattr(app, "module", not app.binary_path)
