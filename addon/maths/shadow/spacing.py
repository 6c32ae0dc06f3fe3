"""The maps themselves, along the view: texel coordinate t of a depth v, its inverse and its derivative, in LogPSM's normalised form.

`v ∈ [0, 1]` runs from P's near to its far plane, `t ∈ [0, 1]` over the map, `n_bar = n'/(f' − n')` is positive or ∞ (uniform). All
functions take scalars or arrays and broadcast; the domain is not checked. s divides by w in a perspective map: `perspective_s_scale`.
Sources: LogPSM §5.1.2–5.1.4. Each trio: forward increases from 0 to 1, inverse undoes it, derivative is dt/dv = 1/δ.
"""

from __future__ import annotations

import numpy as np

Values = float | np.ndarray


# --- perspective (LogPSM 5.20, 5.23; uniform 5.6 at n̄' = ∞) -------------------------------------------------------------------------


def perspective_forward(v: Values, n_bar: float) -> Values:
    """t = v (n̄'+1)/(v+n̄')."""
    return v * (1.0 + 1.0 / n_bar) / (1.0 + v / n_bar)


def perspective_inverse(t: Values, n_bar: float) -> Values:
    """v = t/(1 + (1−t)/n̄')."""
    return t / (1.0 + (1.0 - t) / n_bar)


def perspective_derivative(v: Values, n_bar: float) -> Values:
    """dt/dv = n̄'(n̄'+1)/(v+n̄')² (5.23)."""
    return (1.0 + 1.0 / n_bar) / (1.0 + v / n_bar) ** 2


def perspective_s_scale(v: Values, n_bar: float) -> Values:
    """ds/du = (n̄'+1)/(v+n̄') at depth v, 1 on the far plane (5.22): how much the map widens what lies nearer."""
    return (1.0 + 1.0 / n_bar) / (1.0 + v / n_bar)


# --- logarithmic (LogPSM 5.39, 5.40) ----------------------------------------------------------------------------------------------


def logarithmic_forward(v: Values, n_bar: float) -> Values:
    """t = log2(w/n')/log2(f'/n') = ln(1 + v/n̄')/ln(1 + 1/n̄') (5.39), exact for weak warps too."""
    return np.log1p(v / n_bar) / np.log1p(1.0 / n_bar) if n_bar != np.inf else v


def logarithmic_inverse(t: Values, n_bar: float) -> Values:
    """v = n̄' ((1 + 1/n̄')^t − 1)."""
    return np.expm1(t * np.log1p(1.0 / n_bar)) * n_bar if n_bar != np.inf else t


def logarithmic_derivative(v: Values, n_bar: float) -> Values:
    """dt/dv = 1/((v+n̄') ln(1 + 1/n̄')) (5.40)."""
    return 1.0 / ((v + n_bar) * np.log1p(1.0 / n_bar)) if n_bar != np.inf else np.ones_like(v) * 1.0


# --- log+perspective with general b (LogPSM 5.43, 5.47–5.51) ----------------------------------------------------------------------


def _log_span(n_bar: float, b: float) -> tuple[float, float]:
    """(1/n̄' − 1/b, ln of (1+n̄')b/((1+b)n̄')): both 0 at b = n̄', where the map is the perspective one."""
    bend = 1.0 / n_bar - 1.0 / b
    return bend, float(np.log1p(bend / (1.0 + 1.0 / b)))


def log_perspective_forward(v: Values, n_bar: float, b: float = np.inf) -> Values:
    """t = log[(v+n̄')b/((v+b)n̄')] / log[(1+n̄')b/((1+b)n̄')] for b > 0 or b < −1 (5.43 with the constants 5.48–5.51, 5.49 mended).

    Spacing δ ∝ (v+n̄')(v+b): b = ∞ is the logarithm of LogPSM 5.43, b = n̄' the perspective map, others parabolas (§5.1.4.1).
    """
    bend, span = _log_span(n_bar, b)
    if span == 0.0:
        return perspective_forward(v, n_bar)
    return np.log1p(v * bend / (1.0 + v / b)) / span


def log_perspective_inverse(t: Values, n_bar: float, b: float = np.inf) -> Values:
    """v of t: with q = e^{t·span} − 1, `v = q/(1/n̄' − (1+q)/b)`."""
    bend, span = _log_span(n_bar, b)
    if span == 0.0:
        return perspective_inverse(t, n_bar)
    q = np.expm1(t * span)
    return q / (bend - q / b)


def log_perspective_derivative(v: Values, n_bar: float, b: float = np.inf) -> Values:
    """dt/dv = (b−n̄')/((v+n̄')(v+b)·span), the reciprocal of 5.50."""
    bend, span = _log_span(n_bar, b)
    if span == 0.0:
        return perspective_derivative(v, n_bar)
    return bend / ((1.0 + v / n_bar) * (1.0 + v / b) * span)
