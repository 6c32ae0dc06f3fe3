"""Light-space perspective with Lloyd's way to uniform (Lloyd 2007; method §3)."""

from .row import WarpMethod

ROW = WarpMethod(
    name="lloyd",
    place=40,
    label="LiSPSM (Lloyd)",
    text="Light-space perspective with Lloyd's ramp η(γ) (method §3)",
    parameter=lambda view: view.by_eta(0.0),
)
