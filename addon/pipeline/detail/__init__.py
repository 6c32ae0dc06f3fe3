"""Coarser casters: meshes collapsed with a measured error, made in a process of their own, drawn into maps where nobody sees it."""
