"""The generalised light-space perspective (T4 §4.2)."""

from .formulas import lispsm_general_parameter
from .row import WarpedView, WarpMethod


def parameter(view: WarpedView) -> float:
    """T4 (42)."""
    return lispsm_general_parameter(view.near, view.far, view.half_fov_rad, view.gamma_rad, view.convergence, view.balanced)


ROW = WarpMethod(
    name="lispsm-general",
    place=30,
    label="LiSPSM (generalised)",
    text="Light-space perspective for every angle between light and view, fading to uniform below γ_lim (T4 (39), (42)–(44))",
    parameter=parameter,
    fades=True,
)
