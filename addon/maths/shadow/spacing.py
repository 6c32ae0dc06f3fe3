"""How densely the texels of a map lie along the view: dt/dv of a depth v, in LogPSM's normalised form.

`v ∈ [0, 1]` runs from P's near to its far plane, `t ∈ [0, 1]` over the map, `n_bar = n'/(f' − n')` is positive or ∞ (uniform). All
functions take scalars or arrays and broadcast; the domain is not checked. Sources: LogPSM §5.1.2–5.1.4.
"""

from __future__ import annotations

import numpy as np

Values = float | np.ndarray


def perspective_derivative(v: Values, n_bar: float) -> Values:
    """dt/dv = n̄'(n̄'+1)/(v+n̄')² (5.23)."""
    return (1.0 + 1.0 / n_bar) / (1.0 + v / n_bar) ** 2


def log_span(n_bar: float, b: float) -> tuple[float, float]:
    """(1/n̄' − 1/b, ln of (1+n̄')b/((1+b)n̄')): both 0 at b = n̄', where the map is the perspective one."""
    bend = 1.0 / n_bar - 1.0 / b
    return bend, float(np.log1p(bend / (1.0 + 1.0 / b)))


def log_perspective_derivative(v: Values, n_bar: float, b: float = np.inf) -> Values:
    """dt/dv = (b−n̄')/((v+n̄')(v+b)·span), the reciprocal of 5.50."""
    bend, span = log_span(n_bar, b)
    if span == 0.0:
        return perspective_derivative(v, n_bar)
    return bend / ((1.0 + v / n_bar) * (1.0 + v / b) * span)
