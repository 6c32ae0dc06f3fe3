"""The sidebar tab "CAD Shadow" of the 3D viewport, the same settings in the render properties, and Blender's own panels."""

from ..parts import attach, detach
from . import advice, compatible, quality, settings

_parts = (settings, quality, advice, compatible)


def register() -> None:
    """Show the panels."""
    attach(_parts)


def unregister() -> None:
    """Remove the panels."""
    detach(_parts)
