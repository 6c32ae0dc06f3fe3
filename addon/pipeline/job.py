"""One picture asked for: everything it needs. Data only; `blender/sources.py` makes jobs from Blender's data."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ..errors import SceneError
from ..maths.view import Camera, Light
from ..scene.records import Scene
from ..settings.groups import Settings

if TYPE_CHECKING:
    from .impostors.records import ImpostorChoice


ENGINE_PASSES = ("combined", "depth", "normal", "shadow", "aliasing")
MAX_PIXELS = 16384


@dataclass(frozen=True, eq=False)
class Job:
    """Everything one picture needs, read out of Blender: nothing in it can change while it is rendered.

    `name` is the input as the report shows it; `size` (width, height) in pixels; `passes` by the contract's names; `sync_ms` the time
    that reading the scene took; `warnings` what the user should know about how the scene was read; `measure` False leaves the error
    statistics out (the live view, where nobody reads them). `impostors` stand for some of the objects; None: all are geometry.
    """

    name: str
    scene: Scene
    camera: Camera
    light: Light | None
    settings: Settings
    size: tuple[int, int]
    passes: tuple[str, ...] = ENGINE_PASSES
    sync_ms: float | None = None
    warnings: tuple[str, ...] = field(default=())
    measure: bool = True
    impostors: ImpostorChoice | None = None

    def __post_init__(self) -> None:
        if not all(1 <= n <= MAX_PIXELS for n in self.size):
            raise SceneError(f"The picture is {self.size[0]}×{self.size[1]} pixels: each side must lie between 1 and {MAX_PIXELS}.")

    @property
    def key(self) -> tuple:
        """What the picture depends on, comparable and hashable: equal keys give equal pictures."""
        lit = None if self.light is None else self.light.key
        return self.scene.fingerprint, self.camera.key, lit, self.settings, self.size, self.impostors
