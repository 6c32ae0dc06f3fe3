"""Many inputs in one run: folders and patterns, what was done before, worker processes, progress, the contact sheet.

Only `sheet` needs Blender, so a run with `--jobs` costs its first process next to nothing.
"""
