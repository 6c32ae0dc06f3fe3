"""The passes of a picture: a module here for each, with its `ROW` (`row.py`). What the GPU does for them: `pipeline/passes`."""

from __future__ import annotations

import numpy as np

from ...maths.domains import require_choice
from ...maths.tables import rows_of
from .row import RenderPass, ShadedImages

RENDER_PASSES: dict[str, RenderPass] = rows_of(__name__, __path__)
PASSES = tuple(RENDER_PASSES)
USUAL_PASSES = tuple(name for name, row in RENDER_PASSES.items() if row.is_usual)
"""Those that are written where nobody names any."""
DATA_PASSES = tuple(name for name, row in RENDER_PASSES.items() if row.is_data)
LAYER_PASSES = tuple(row.name for row in sorted((row for row in RENDER_PASSES.values() if row.blender), key=lambda row: row.blender.place))
"""Those that Blender's render layers can have, in their order there."""
ENGINE_PASSES = tuple(name for name in LAYER_PASSES if RENDER_PASSES[name].is_usual)
"""Those of them that every picture is made with, shown or not."""


def pass_named(name: str) -> RenderPass:
    """The pass of that name. Raises `SettingsError`."""
    require_choice("Pass", name, PASSES)
    return RENDER_PASSES[name]


def made_passes(shaded: ShadedImages) -> dict[str, np.ndarray]:
    """The images that the job asks for, by the names of their arrays; without those that there is nothing to make of."""
    rows = sorted(map(pass_named, set(shaded.job.passes)), key=lambda row: row.place)
    images = {row.array: row.make(shaded) for row in rows}
    return {name: image for name, image in images.items() if image is not None}


def picture_of(name: str, passes: dict[str, np.ndarray]) -> np.ndarray:
    """A pass as a picture to look at, uint8 or uint16; of all `passes` of the frame, some of which may help to read it."""
    return pass_named(name).picture(passes)


def channels_of(name: str, passes: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """A pass as EXR channels (h, w), values untouched."""
    row = pass_named(name)
    return row.channels(passes[row.array])
