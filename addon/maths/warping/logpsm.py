"""Logarithmic perspective shadow maps (LogPSM §5.1.4)."""

from .row import WarpMethod

ROW = WarpMethod(
    name="logpsm",
    place=70,
    label="Log + perspective",
    text="A logarithm along the view and a perspective across it: equal error everywhere along it (LogPSM 5.43)",
    parameter=lambda view: view.by_apex(True),
    fades=True,
    log=True,
    bends=True,
    slice_rate=0.09,
)
