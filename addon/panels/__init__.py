"""The sidebar tab "CAD Shadow" of the 3D viewport, the same settings in the render properties, and Blender's own panels."""

from . import advice, compatible, quality, settings

_parts = (settings, quality, advice, compatible)


def register() -> None:
    """Show the panels."""
    for part in _parts:
        part.register()


def unregister() -> None:
    """Remove the panels."""
    for part in reversed(_parts):
        part.unregister()
