"""Scripting: pictures and numbers as typed dataclasses and numpy arrays.

    from bl_ext.user_default.cad_shadow_preview.addon import api   # `from addon import api` from a checkout
    result = api.preview(size=(1280, 720), map_size=2048)
    result.show()

Keyword arguments named like the command line's options (`warp="psm"`, `partitions=4`, `map_size=2048`) override the scene's settings for
this call only. Errors are `addon.errors.UserError`s with a line that says what to do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import radians
from pathlib import Path
from typing import TYPE_CHECKING

import bpy
import numpy as np

from ..blender import image_editor, session
from ..blender.rendering import render
from ..errors import OutputError
from ..images.whole import check_picture
from ..maths.error.theory import theory as predict
from ..maths.view import Camera, Light
from ..pipeline.render_passes import ENGINE_PASSES, USUAL_PASSES, picture_of
from ..scene.asked_view import Point
from ..settings.groups import Settings
from ..settings.options import with_options
from ..studies import outputs
from ..studies.run import Outcome
from .impostors import Impostor, ImpostorPath, impostor_path, impostors
from .sun_hours import SunHoursResult, sun_hours
from .view import wish_for

if TYPE_CHECKING:
    from ..pipeline.frame import ImpostorReport

__all__ = [
    "Impostor",
    "ImpostorPath",
    "Preview",
    "SunHoursResult",
    "analyse",
    "impostor_path",
    "impostors",
    "preview",
    "sun_hours",
    "theory",
]
ALL_PASSES = USUAL_PASSES


@dataclass(frozen=True, eq=False)
class Preview:
    """A rendered view. Images are (height, width[, channels]) arrays, row 0 at the top; the keys of `report`: docs/scripting.md."""

    outcome: Outcome

    @property
    def combined(self) -> np.ndarray:
        """(h, w, 4) float32, scene linear."""
        return self.outcome.frame.passes["combined"]

    @property
    def passes(self) -> dict[str, np.ndarray]:
        """Every image made, by its name."""
        return self.outcome.frame.passes

    @property
    def report(self) -> dict[str, object]:
        """The report JSON as a dictionary."""
        return self.outcome.report

    @property
    def impostors(self) -> tuple[ImpostorReport, ...]:
        """What became of each impostor in this picture: stage, predicted errors, texture size, triangles it stands for."""
        return self.outcome.frame.impostors

    @property
    def camera(self) -> Camera:
        """The camera used; its world is relative to `outcome.job.scene.origin_ws`."""
        return self.outcome.job.camera

    @property
    def light(self) -> Light | None:
        """The light that casts the shadows."""
        return self.outcome.job.light

    def show(self, name: str = "combined") -> bpy.types.Image:
        """Put a pass into an Image Editor and return it as a Blender image (only that, when Blender runs without a window)."""
        title = image_editor.NAME if name == "combined" else f"{image_editor.NAME}: {name}"
        picture = self.combined if name == "combined" else image_editor.displayed(picture_of(name, self.passes))
        image = image_editor.to_image(picture, title, is_data=name != "combined")
        image_editor.show(bpy.context, image)
        return image

    def save(self, path: str | Path, passes: tuple[str, ...] = ALL_PASSES) -> None:
        """Write the arrays (.npz), the report (.json), or one pass (.png, .exr, exactly one in `passes`). Raises `OutputError`."""
        path = Path(path)
        if path.suffix == ".npz":
            outputs.write_npz(path, self.outcome, passes)
        elif path.suffix == ".json":
            outputs.write_json(path, self.report)
        elif path.suffix == ".png" and passes == ("combined",):
            with outputs.written(path, check_picture) as temporary:
                image_editor.save_as_render(image_editor.to_image(self.combined), temporary, bpy.context.scene)
        elif path.suffix in (".png", ".exr") and len(passes) == 1:
            outputs.write_pass(path, passes[0], self.outcome)
        else:
            raise OutputError(f"{path.name}: save as .npz or .json, or name one pass to save as .png or .exr.")


def preview(
    scene: bpy.types.Scene | None = None,
    *,
    camera: str | None = None,
    view: str | None = None,
    eye: Point | None = None,
    target: Point | None = None,
    up: Point = (0.0, 0.0, 1.0),
    fov_y_deg: float | None = None,
    near: float | None = None,
    far: float | None = None,
    light: str | Sequence[str] | None = None,
    light_direction: Point | None = None,
    size: tuple[int, int] | None = None,
    passes: tuple[str, ...] = ALL_PASSES,
    ortho: bool = False,
    frame: int | None = None,
    view_layer: str | None = None,
    **options: object,
) -> Preview:
    """Render a scene (default: the one in the window) exactly as F12 would, and keep the result in memory.

    The view is `camera` (a name), `view` ('iso', 'front', …) or `eye` with `target`, in world metres; else the scene's camera. The light
    is `light` (names) or `light_direction` (towards the light); else the scene's. `ortho` makes `view` or `eye` a parallel projection,
    `frame` is that of the animation, `view_layer` (a name) the only one rendered. `options` override the scene's settings.
    """
    scene = scene or bpy.context.scene
    wish = wish_for(
        scene,
        passes,
        camera=camera,
        view=view,
        eye=eye,
        target=target,
        up=up,
        fov_y_deg=fov_y_deg,
        near=near,
        far=far,
        light=light,
        light_direction=light_direction,
        size=size,
        ortho=ortho,
        frame=frame,
        view_layer=view_layer,
        **options,
    )
    outcome = render(scene, wish)
    session.remember(outcome, scene)
    return Preview(outcome)


def analyse(scene: bpy.types.Scene | None = None, **arguments: object) -> dict[str, object]:
    """The report of a view, without its images. Arguments as for `preview`."""
    return preview(scene, passes=ENGINE_PASSES, **arguments).report


def theory(
    near: float,
    far: float,
    fov_y_deg: float = 60.0,
    gamma_deg: float = 90.0,
    size: tuple[int, int] | None = None,
    curve: int | None = None,
    **options: object,
) -> dict[str, object]:
    """What the texts predict for a view and a method, without a scene: the `theory --json` object.

    `options` as for `preview` (warp, partition, partitions, …); the resolution terms are included when `map_size` and `size` are given.
    """
    settings = with_options(Settings(), options)
    return predict(
        near,
        far,
        radians(fov_y_deg) / 2.0,
        radians(gamma_deg),
        settings.warp,
        settings.partition,
        settings.fit.size if "map_size" in options else None,
        size,
        curve,
    )
