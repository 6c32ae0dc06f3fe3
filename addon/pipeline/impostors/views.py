"""The captures of one impostor, where it keeps several: the last ones, or a set of directions round it. Worker thread only.

The nearest to the eye is the one that the life cycle judges. It is drawn together with the next nearest: dithered by how near each is, and
what neither shows in its own pixels the others fill from one texel farther back.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ...errors import SceneError
from ...maths.relief.frame import tilt_rad
from ...maths.relief.views import nearest_views, view_camera, view_directions
from ...maths.view import Camera
from ..device import Device
from ..passes.gbuffer import GBuffer
from .capture import ImpostorTextures, capture_bytes
from .draw import draw_impostor
from .records import ImpostorView, Part, Predicted

MISSING = 1.2
"""A view of the set that is missing counts as an error of this share of the limit: it is captured, and the others are shown meanwhile."""


@dataclass(frozen=True, eq=False)
class DrawnImpostor:
    """How to draw one impostor in this frame: its texture, the old one while the new fades in, and further views, nearest first."""

    textures: ImpostorTextures
    hull_ws: np.ndarray
    sprite: bool
    method: str
    fade: float
    old: ImpostorTextures | None
    others: tuple[ImpostorTextures, ...] = ()
    fill: bool = True

    def draw(self, device: Device, target: GBuffer, camera: Camera) -> None:
        """Draw over what `target` holds. In a crossfade the new one fills what the old one does not show, from a texel farther back."""
        method = "sprite" if self.sprite else self.method
        if self.others:
            self._draw_views(device, target, camera)
            return
        fade = self.fade if self.old is not None else 1.0
        self._draw_one(device, target, camera, self.textures, method=method, fade=fade)
        if self.old is not None and fade < 1.0:
            self._draw_one(device, target, camera, self.old, fade=fade, fade_rest=True)
            self._draw_one(device, target, camera, self.textures, behind_texels=1.0)

    def _draw_views(self, device: Device, target: GBuffer, camera: Camera) -> None:
        """The nearest two dithered, the nearer the denser; then all of them a texel farther back, where that left holes."""
        tilts = [tilt_rad(textures.frame, camera) for textures in (self.textures, self.others[0])]
        fade = min(0.999, tilts[1] / max(sum(tilts), 1e-9))
        self._draw_one(device, target, camera, self.textures, fade=fade)
        self._draw_one(device, target, camera, self.others[0], fade=fade, fade_rest=True)
        for textures in (self.textures, *self.others):
            self._draw_one(device, target, camera, textures, behind_texels=1.0)

    def _draw_one(self, device: Device, target: GBuffer, camera: Camera, textures: ImpostorTextures, **how: object) -> None:
        draw_impostor(device, target, textures, self.hull_ws, camera, **{"method": self.method, "fill": self.fill} | how)


@dataclass(eq=False)
class Views:
    """Captures of one impostor by direction (in a set) or by age (rising numbers). Owns their textures."""

    held: dict[int, ImpostorTextures] = field(default_factory=dict)

    @property
    def bytes(self) -> int:
        """Texture memory."""
        return sum(textures.bytes for textures in self.held.values())

    def by_nearness(self, camera: Camera) -> list[ImpostorTextures]:
        """All, those first of which the view has turned least since their capture."""
        if len(self.held) < 2:
            return list(self.held.values())
        return sorted(self.held.values(), key=lambda textures: tilt_rad(textures.frame, camera))

    def put(self, number: int | None, textures: ImpostorTextures, keep: int) -> None:
        """Add a capture; of those without a direction (`number` None) only the last `keep` stay."""
        place = max(self.held, default=-1) + 1 if number is None else number
        if place in self.held:
            self.held[place].release()
        self.held[place] = textures
        while number is None and len(self.held) > keep:
            self.held.pop(min(self.held)).release()

    def make_room(self, needed: int, limit: int, camera: Camera) -> None:
        """Free the captures farthest from the eye, but the nearest, until `needed` more bytes fit."""
        for textures in self.by_nearness(camera)[:0:-1]:
            if self.bytes + needed <= limit:
                return
            number = next(n for n, held in self.held.items() if held is textures)
            self.held.pop(number).release()

    def release(self) -> None:
        """Free all."""
        for textures in self.held.values():
            textures.release()
        self.held.clear()


def towards_set(
    part: Part, seen: Predicted, views: Views | None, view: ImpostorView, per_side: int, drawn: int
) -> tuple[Predicted, int | None]:
    """What the life cycle is to decide on for an impostor with `per_side`² directions, and the direction to capture next.

    Nothing is predicted: a direction among the `drawn` nearest that is missing must be captured, and none else.
    """
    if not seen.impostor.capture_bytes:
        return seen, None
    directions, centre = view_directions(per_side), part.bounds_ws.mean(axis=0)
    wanted = nearest_views(directions, view.camera, centre, drawn)
    held = views.held if views is not None else {}
    missing = [int(n) for n in wanted if int(n) not in held]
    number = missing[0] if missing else int(wanted[0])
    try:
        frame = view.frame_of(part.hull_ws, view_camera(view.camera, centre, directions[number]))
    except SceneError:
        return seen, None
    error = view.choice.settings.effective_limit * MISSING if missing else 0.0
    predicted = error if seen.impostor.predicted < np.inf else np.inf
    room = min(capture_bytes(frame) + (views.bytes if views is not None else 0), view.choice.settings.memory_bytes)
    return replace(seen, impostor=replace(seen.impostor, predicted=predicted, capture_bytes=room), frame=frame), number
