"""How far ahead of a moving eye each impostor is captured: learnt from its captures before. Worker thread only."""

from __future__ import annotations

from collections.abc import Hashable

from ...errors import SceneError
from ...maths.relief.ahead import ahead_of, next_share
from ...maths.relief.life import ViewedImpostor
from ...maths.relief.warp import CaptureFrame
from ...maths.view import Camera
from .capture import ImpostorTextures
from .records import ImpostorChoice, ImpostorView, Part


class Ahead:
    """The eye of the frame before, and by which share of the turn that wore out its last texture each impostor is captured ahead."""

    def __init__(self) -> None:
        self._before: Camera | None = None
        self._shares: dict[Hashable, float] = {}

    def moved_to(self, camera: Camera) -> None:
        """The frame is done: where its eye was."""
        self._before = camera

    def drop(self, key: Hashable) -> None:
        """The object is not an impostor any more."""
        self._shares.pop(key, None)

    def frame(self, part: Part, current: ImpostorTextures, view: ImpostorView) -> CaptureFrame | None:
        """What to capture in the place of `current`; None: what is seen from the eye itself."""
        if self._before is None or view.choice.settings.ahead == 0.0:
            return None
        share = self._shares.get(part.group.key, view.choice.settings.ahead)
        try:
            ahead = ahead_of(current.frame, self._before, view.camera, part.bounds_ws.mean(axis=0), share)
            return view.frame_of(part.hull_ws, ahead) if ahead is not None else None
        except SceneError:
            return None

    def holds(self, key: Hashable, impostor: ViewedImpostor, choice: ImpostorChoice) -> bool:
        """Whether a texture captured ahead is good enough here and now (as `impostor` predicts); what was found is learnt from."""
        if impostor.betas is None:
            return False
        settings, limit = choice.settings, choice.settings.effective_limit
        coarse = impostor.betas.texel > choice.model.texel_px * impostor.betas.screen
        found = float("inf") if coarse or impostor.tilt_rad > settings.max_tilt_rad else impostor.predicted
        self._shares[key] = next_share(self._shares.get(key, settings.ahead), found, settings.ahead * limit)
        return found <= limit
