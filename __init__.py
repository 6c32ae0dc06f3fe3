"""The extension's root, which Blender wants beside the manifest; everything is in `addon`."""


def register():
    """Enable the extension."""
    from . import addon

    addon.register()


def unregister():
    """Disable the extension; nothing stays behind."""
    from . import addon

    addon.unregister()
