"""What the command line's exit codes mean."""

from __future__ import annotations

DONE, FAILED, MISUSED = 0, 1, 2
