"""One picture asked for: everything that the renderer needs. Data only; `blender/sources.py` makes jobs from Blender's data."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING

from ..errors import SceneError
from ..maths.view import Camera, Light, LightSource
from ..scene.records import Scene
from ..settings.groups import Settings

if TYPE_CHECKING:
    import numpy as np

    from .impostors.records import ImpostorChoice


MAX_PIXELS = 16384


@dataclass(frozen=True, eq=False)
class Job:
    """Everything one picture needs: nothing in it can change while it is rendered.

    `size` (width, height) in pixels; `passes` by their names; `measure` False leaves the error statistics out (a live view that moves);
    `is_live`: of the live view, which shows what is there and does not wait. `keeps_depth`: the frame says how far what is seen lies
    (`Frame.view_depth`). `light` is the main one, which the plan and the data passes are of; `others` light the picture too. `rounds`: so
    many samples of each light with a size for now, None: as many as the settings say. `impostors` stand for some of the objects; None: all
    are geometry. `shown` (I,) bool: the instances that the camera sees, where not all; the others still cast shadows. For the report:
    `name` of the input; `sync_ms`, the time that reading the scene took; `warnings`, what the user should know about how it was read.
    """

    scene: Scene
    camera: Camera
    light: Light | None
    settings: Settings
    size: tuple[int, int]
    passes: tuple[str, ...] = ("combined",)
    _: KW_ONLY
    measure: bool = True
    others: tuple[LightSource, ...] = ()
    rounds: int | None = None
    is_live: bool = False
    impostors: ImpostorChoice | None = None
    shown: np.ndarray | None = None
    name: str = ""
    sync_ms: float | None = None
    keeps_depth: bool = False
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not all(1 <= n <= MAX_PIXELS for n in self.size):
            raise SceneError(f"The picture is {self.size[0]}×{self.size[1]} pixels: each side must lie between 1 and {MAX_PIXELS}.")

    @property
    def key(self) -> tuple:
        """What the picture depends on, comparable and hashable: equal keys give equal pictures."""
        lit = None if self.light is None else self.light.key, *(one.key for one in self.others)
        return self.scene.fingerprint, self.camera.key, lit, self.settings, self.size, self.impostors
