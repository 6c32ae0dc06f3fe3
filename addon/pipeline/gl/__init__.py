"""OpenGL itself: the worker thread and its context, programs, raw calls, reading back."""
