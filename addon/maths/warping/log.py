"""A logarithm along the view, s undivided (LogPSM §5.1.3)."""

from .row import WarpMethod

ROW = WarpMethod(
    name="log",
    place=60,
    label="Logarithmic",
    text="A logarithm along the view, none across it (LogPSM 5.39)",
    parameter=lambda view: view.by_apex(False),
    fades=True,
    log=False,
)
