"""Light-space perspective shadow maps as first published (Wimmer et al. 2004)."""

from math import sin

from .row import WarpMethod

ROW = WarpMethod(
    name="lispsm",
    place=20,
    label="LiSPSM (original)",
    text="Light-space perspective, n' = (n + √(f n)) / sin γ (T4 (27)): near and far err alike",
    parameter=lambda view: view.balanced / sin(view.gamma_rad),
)
