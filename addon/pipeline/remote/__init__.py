"""The renderer in a process of its own."""
