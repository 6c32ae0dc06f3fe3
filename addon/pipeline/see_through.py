"""What is see-through in a picture: which rows, what the camera sees of it layer by layer, what tints the light. Worker thread only."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..maths.shadow.projection import ShadowPlan
from ..maths.view import Camera
from ..scene.looks import NO_SHADOW
from ..scene.records import Scene
from .device import Device
from .geometry.draw_list import DrawList
from .gl.machine import check_layers
from .gl.readback import read_texture
from .impostors.records import ImpostorChoice
from .job import Job
from .passes.gbuffer import GBuffer, surface_points_ws
from .passes.panes import MOST_PANES, MOST_SIDE, PaneMaps, draw_panes
from .passes.peeling import MOST_LAYERS, peeled


@dataclass(frozen=True, eq=False)
class Seen:
    """What a camera sees: what is whole, and layers of what is see-through before it, the nearest first."""

    camera: Camera
    whole: GBuffer
    layers: tuple[GBuffer, ...] = ()

    @cached_property
    def depth(self) -> np.ndarray:
        """(h, w) view depth of what is whole, from the bottom up, 0 where there is nothing. Read once, while the surfaces hold this."""
        return read_texture(self.whole.view_depth, flip=False)

    @cached_property
    def whole_ws(self) -> np.ndarray:
        """(P, 3) the places of the pixels that show what is whole."""
        return surface_points_ws(self.depth, self.camera)

    @cached_property
    def receivers_ws(self) -> np.ndarray:
        """(P, 3) the places of all pixels, those of the layers too."""
        layers = [surface_points_ws(read_texture(layer.view_depth, flip=False), self.camera) for layer in self.layers]
        return np.concatenate([self.whole_ws, *layers]) if layers else self.whole_ws


def shown_through(job: Job) -> np.ndarray | None:
    """(I,) bool: the rows that are layers of the picture; None where there are none, or what is shown is not the picture."""
    return job.scene.see_through if job.settings.shading.display == "shaded" else None


def layers_before(
    device: Device, whole: GBuffer, draw_list: DrawList, camera: Camera, rows: np.ndarray, of: str = "pixels"
) -> tuple[GBuffer, ...]:
    """The layers of the instance rows `rows` (I,) before what `whole` holds."""

    def target(number: int) -> GBuffer:
        check_layers(whole.size, number + 1)
        return device.gbuffer(whole.size, f"{of}, layer {number}")

    return tuple(peeled(device.context, device.programs, whole, target, draw_list, camera, rows))


def warnings_of(seen: Seen) -> tuple[str, ...]:
    """That there are more layers than are told apart."""
    if len(seen.layers) < MOST_LAYERS:
        return ()
    return (f"{MOST_LAYERS} see-through surfaces or more lie behind one another: those behind the first {MOST_LAYERS} are left out.",)


def panes_of(device: Device, job: Job, draw_list: DrawList, plan: ShadowPlan | None) -> PaneMaps | None:
    """What tints the light on its way, for the shadow maps of `plan`; None where nothing does. What did not change is not drawn again."""
    rows = job.scene.shines_through
    if plan is None or rows is None:
        return None
    casting = job.scene.instances.without(NO_SHADOW)
    rows = rows if casting is None else rows & casting
    if not rows.any():
        return None
    side, maps, room = min(job.settings.fit.size, MOST_SIDE), len(plan.projections), device.attached("pane layers", Room)
    of_plan = device.plan[0] if device.plan is not None and device.plan[1] is plan else None
    wanted = None if of_plan is None else (of_plan, device.store.state, device.store.colors, rows.tobytes())
    while True:
        panes = device.pane_maps(side, maps, room.layers)
        if wanted is not None and panes.holds == wanted:
            return panes
        deepest = draw_panes(device.context, device.programs, panes, draw_list, plan, rows)
        panes.holds = wanted
        if deepest <= panes.layers or panes.layers >= MOST_PANES:
            return panes
        room.layers *= 2


class Room:
    """How many layers of panes there is room for: as many as were needed so far."""

    def __init__(self) -> None:
        self.layers = 2

    def release(self) -> None:
        """Nothing: a number."""


def unlike_impostors(scene: Scene, choice: ImpostorChoice | None) -> tuple[str, ...]:
    """Which impostors have see-through parts, that are drawn as geometry."""
    clear = [rows for rows in (scene.see_through, scene.shines_through) if rows is not None]
    if choice is None or not clear:
        return ()
    owners = set(scene.instances.object_id[np.any(clear, axis=0)].tolist())
    names = [f"'{group.name}'" for group in choice.groups if not owners.isdisjoint(group.object_ids)]
    more = f" and {len(names) - 3} more" if len(names) > 3 else ""
    return (f"What is see-through is drawn as geometry, not as an impostor: parts of {', '.join(names[:3])}{more}.",) if names else ()
