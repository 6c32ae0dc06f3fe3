"""Memory that was given free goes back to the system: glibc keeps it for itself, and a picture's peak would count it twice."""

from __future__ import annotations

import ctypes
import sys


def give_back() -> bool:
    """Have the C library give back what it holds and nothing uses; False where it cannot be asked (other systems than glibc's)."""
    if not sys.platform.startswith("linux"):
        return False
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    return trim is not None and bool(trim(0) in (0, 1))
