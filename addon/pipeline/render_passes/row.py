"""What the program knows of a pass: how it is made, written and shown. No OpenGL: passes are made of what has been read back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...images.passes import id_colors
from ..job import Job


@dataclass(frozen=True, eq=False)
class ShadedImages:
    """What the GPU has drawn for a job, row 0 at the top.

    `combined` (h, w, 4), None unless asked for. At pixel centres, None unless a data pass is asked for: `errors` (h, w, 4) m, m_x, m_z (−1
    where there is no surface or no map) and the light that the shadow lets through; `normals` (h, w, 4) world normal and view depth; `ids`
    (h, w, 4) object, shadow map and instance row, −1 for none. `shadow_maps` reads their depths (k, N, N); None where there is no light.
    `edges` (h, w) how much lines cover of each pixel, `ao` (h, w) how open it is; None unless asked for.
    """

    job: Job
    combined: np.ndarray | None
    errors: np.ndarray | None
    normals: np.ndarray | None
    ids: np.ndarray | None
    shadow_maps: Callable[[], np.ndarray] | None
    edges: np.ndarray | None = None
    ao: np.ndarray | None = None


def untouched(image: np.ndarray) -> np.ndarray:
    """The image itself."""
    return image


@dataclass(frozen=True, slots=True)
class BlenderPass:
    """A pass as Blender's render layers have it: `name`, a letter per channel (`channels`), `kind` 'COLOR', 'VECTOR' or 'VALUE'; `place`
    among them. `shown` makes the float image that Blender gets: it has no infinities and no NaN. `flag`: the view layer's switch; None: it
    always comes. `old_name` before Blender 5."""

    name: str
    channels: str
    kind: str
    place: int
    shown: Callable[[np.ndarray], np.ndarray] = untouched
    flag: str | None = None
    old_name: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class RenderPass:
    """One pass.

    `name` in scripts and on the command line, `place` there; `array` its name among the frame's arrays and in .npz; `shape` and `text`
    what it holds. `make` gives the image, None where there is nothing to make it of; `picture` something to look at (PNG), from all passes
    of the frame; `channels` the exact values (EXR). `blender`: how the render layers have it; None where they do not. `is_data`: made at
    pixel centres, of `errors`, `normals`, `ids`. `is_usual`: written where nobody names passes.
    """

    name: str
    place: int
    array: str
    shape: str
    text: str
    make: Callable[[ShadedImages], np.ndarray | None]
    picture: Callable[[dict[str, np.ndarray]], np.ndarray]
    channels: Callable[[np.ndarray], dict[str, np.ndarray]]
    blender: BlenderPass | None = None
    is_data: bool = True
    is_usual: bool = True


def materials_seen(shaded: ShadedImages) -> np.ndarray:
    """(h, w) indices into `Scene.materials`, −1 where there is no surface."""
    return np.where(shaded.ids[..., 0] < 0, -1, shaded.job.scene.instances.material[shaded.ids[..., 2]])


def floats(channels: str) -> Callable[[np.ndarray], dict[str, np.ndarray]]:
    """Numbers (h, w) or (h, w, c) as one EXR channel a letter."""

    def planes(image: np.ndarray) -> dict[str, np.ndarray]:
        stacked = image.reshape(*image.shape[:2], -1)
        return {channel: np.ascontiguousarray(stacked[..., i], dtype=np.float32) for i, channel in enumerate(channels)}

    return planes


def numbers(image: np.ndarray) -> dict[str, np.ndarray]:
    """Ids from −1 as an EXR channel: unsigned, one higher, so that 0 is nothing."""
    return {"Y": (image + 1).astype(np.uint32)}


def author_index(kind: str, place: int, old_name: str, index_of: Callable[[ShadedImages], np.ndarray]) -> RenderPass:
    """The pass of the index an author gave the `kind`, 'object' or 'material', that is seen: `index_of` what is seen, 0 for nothing."""
    array = f"{kind}_index"
    return RenderPass(
        name=f"{kind}-index",
        place=place,
        array=array,
        shape="(h, w)",
        text=f"Blender's Pass Index of the {kind} seen; 0 where there is none",
        make=lambda shaded: index_of(shaded).astype(np.float32),
        picture=lambda passes: id_colors(passes[array].astype(np.int32) - 1),
        channels=floats("Y"),
        blender=BlenderPass(f"{kind.title()} Index", "X", "VALUE", place, flag=f"use_pass_{array}", old_name=old_name),
        is_usual=False,
    )
