"""The sidebar tab "CAD Shadow" of the 3D viewport, the same settings in the render properties, and Blender's own panels."""

from . import compatible, quality, settings

_parts = (settings, quality, compatible)


def register() -> None:
    """Show the panels."""
    for part in _parts:
        part.register()


def unregister() -> None:
    """Remove the panels."""
    for part in reversed(_parts):
        part.unregister()
