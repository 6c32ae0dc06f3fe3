"""Trapezoidal shadow maps (Martin and Tan 2004; method §3)."""

from .formulas import tsm_eta
from .row import WarpMethod

ROW = WarpMethod(
    name="tsm",
    place=50,
    label="TSM",
    text="Trapezoidal: 80 % of the map for the nearer part of the view",
    parameter=lambda view: view.by_eta(tsm_eta(view.near, view.far)),
    slice_rate=0.09,
)
