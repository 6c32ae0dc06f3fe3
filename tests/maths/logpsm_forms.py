"""LogPSM's own forms, which the program's formulas are held to: maps and errors of a normalised view, light ⟂ view.

`v = (z−n)/(f−n) ∈ [0, 1]`, `t ∈ [0, 1]` over the map, `n_bar = n'/(f−n)` positive or ∞ (uniform), `n_bar0 = n/(f−n)`. Scalars or arrays.
Each trio: forward increases from 0 to 1, inverse undoes it, derivative is dt/dv = 1/δ.
"""

from math import log1p

import numpy as np

from addon.maths.shadow.spacing import Values, log_perspective_derivative, log_span, perspective_derivative

__all__ = ["log_perspective_derivative", "perspective_derivative"]  # the program's, beside the rest of their trios


# --- perspective (LogPSM 5.20, 5.22; uniform 5.6 at n̄' = ∞) ---


def perspective_forward(v: Values, n_bar: float) -> Values:
    """t = v (n̄'+1)/(v+n̄')."""
    return v * (1.0 + 1.0 / n_bar) / (1.0 + v / n_bar)


def perspective_inverse(t: Values, n_bar: float) -> Values:
    """v = t/(1 + (1−t)/n̄')."""
    return t / (1.0 + (1.0 - t) / n_bar)


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


# --- log+perspective with general b (LogPSM 5.43, 5.47–5.51) ---


def log_perspective_forward(v: Values, n_bar: float, b: float = np.inf) -> Values:
    """t = log[(v+n̄')b/((v+b)n̄')] / log[(1+n̄')b/((1+b)n̄')] for b > 0 or b < −1 (5.43 with the constants 5.48–5.51, 5.49 mended).

    Spacing δ ∝ (v+n̄')(v+b): b = ∞ is the logarithm of LogPSM 5.43, b = n̄' the perspective map, others parabolas (§5.1.4.1).
    """
    bend, span = log_span(n_bar, b)
    if span == 0.0:
        return perspective_forward(v, n_bar)
    return np.log1p(v * bend / (1.0 + v / b)) / span


def log_perspective_inverse(t: Values, n_bar: float, b: float = np.inf) -> Values:
    """v of t: with q = e^{t·span} − 1, `v = q/(1/n̄' − (1+q)/b)`."""
    bend, span = log_span(n_bar, b)
    if span == 0.0:
        return perspective_inverse(t, n_bar)
    q = np.expm1(t * span)
    return q / (bend - q / b)


# --- errors ---


def base_error_s(v: Values, n_bar: float, n_bar0: float) -> Values:
    """M̃_s = (v+n̄')(n̄'₀+1)/((v+n̄'₀)(n̄'+1)) (LogPSM 5.27; 5.9 at n̄' = ∞): m_x."""
    return (1.0 + v / n_bar) / (1.0 + 1.0 / n_bar) * (n_bar0 + 1.0) / (v + n_bar0)


def base_error_t(v: Values, n_bar: float, n_bar0: float) -> Values:
    """M̃_t = (v+n̄')²/(n̄'(n̄'+1)(v+n̄'₀)) (LogPSM 5.28): m_z · 2 tan φ."""
    return (1.0 + v / n_bar) ** 2 / ((1.0 + 1.0 / n_bar) * (v + n_bar0))


def base_error_log_t(v: Values, n_bar: float, n_bar0: float) -> Values:
    """M̃_log,t = ln((n̄'+1)/n̄') (v+n̄')/(v+n̄'₀) (LogPSM 5.41); constant, ln(f/n), at n̄' = n̄'₀. n̄' finite."""
    return log1p(1.0 / n_bar) * (v + n_bar) / (v + n_bar0)
