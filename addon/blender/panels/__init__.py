"""The sidebar tab "CAD Shadow" of the 3D viewport, the same settings in the render properties, and Blender's own panels."""

from ..registering import attach, detach
from . import advice, chosen, compatible, impostors, layer_passes, quality, settings

_parts = (chosen, impostors, settings, quality, advice, compatible, layer_passes)


def register() -> None:
    """Show the panels."""
    attach(_parts)


def unregister() -> None:
    """Remove the panels."""
    detach(_parts)
