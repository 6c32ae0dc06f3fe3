"""Scenes cut by section planes: `cut.py`. numpy only."""
