"""Blender's side: data read, settings kept, engine, viewport, panels, drawings on the screen."""
