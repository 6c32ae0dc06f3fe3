"""Where to capture from, for an eye that moves: not where it is, but where it is about to be. No GPU.

A texture captured from the eye's own place is right there and wears out from then on. Captured from ahead it is first a little wrong, gets
right as the eye comes up, and wears out behind: the same limit holds it for longer. Our own; RI regenerates from the current
camera (§5.1), which `ImpostorSettings.ahead` = 0 does.
"""

from __future__ import annotations

import numpy as np

from ..spaces import angle_between
from ..view import Camera
from .views import towards_eye
from .warp import CaptureFrame

STEADY = 0.5
"""An eye counts as moving on steadily while one frame turns the view by no more than this share of what wears a texture out."""
SHARES = 0.05, 1.0
"""How far ahead, in shares of the turn that wore the last texture out: least and most."""
MOST_GAIN = 1.5
"""The share grows by this factor at most from one capture to the next; when it was too large it halves."""


def ahead_of(current: CaptureFrame, before: Camera, camera: Camera, centre_ws: np.ndarray, share: float) -> Camera | None:
    """`camera` carried on round the object's middle, the way it came since the frame `before`, by `share` of the angle that it has turned
    by since it passed where `current` was captured.

    None where it does not move on steadily round the object: it stands, comes straight nearer, or jumps.
    """
    then, now = (towards_eye(view, centre_ws)[0] for view in (before, camera))
    eye = current.world_from_plane @ current.eye
    captured = eye[:3] - eye[3] * centre_ws
    step_rad, worn_rad = (float(angle_between(earlier, now)) for earlier in (then, captured))
    if not 1e-9 < step_rad <= STEADY * worn_rad:
        return None
    return camera.carried(centre_ws, share * worn_rad, np.cross(then, now))


def next_share(share: float, found: float, wanted: float) -> float:
    """The share to go ahead by next time, after a capture with `share` had the error `found` where `wanted` was aimed at (both > 0)."""
    low, high = SHARES
    return float(np.clip(share * np.clip(wanted / max(found, 1e-9), 0.5, MOST_GAIN), low, high))
