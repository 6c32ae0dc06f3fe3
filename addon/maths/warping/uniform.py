"""No warp."""

from math import inf

from .row import WarpMethod

ROW = WarpMethod(
    name="uniform",
    place=0,
    label="Uniform",
    text="Every texel covers the same area seen from the light: sharp far away, coarse near the eye",
    parameter=lambda view: inf,
    is_warped=False,
)
