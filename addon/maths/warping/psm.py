"""Perspective shadow maps (Stamminger and Drettakis 2002; method §2)."""

from .row import WarpMethod

ROW = WarpMethod(
    name="psm",
    place=10,
    label="PSM",
    text="Perspective shadow map, n' = n: the most detail at the eye, the least far away",
    parameter=lambda view: view.by_eta(1.0),
    slice_rate=0.09,
)
