"""Impostors as users ask for them: which, written to files, along a path."""
