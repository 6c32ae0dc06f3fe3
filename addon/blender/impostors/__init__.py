"""Impostors in Blender's data: marks, what is chosen, planes."""
