"""The aliasing error m: its statistics over an image, and its theory along the view axis."""

from __future__ import annotations

import numpy as np

QUANTILES = (("m_p99", 0.99), ("m_p95", 0.95), ("m_median", 0.5))


def error_statistics(m: np.ndarray) -> dict[str, float | None]:
    """m_max, m_p99, m_p95, m_median and share_above_1 of an image of m; NaN marks pixels without a surface and is left out.

    Quantiles are values that occur (the next higher rank). An infinite m (a surface edge-on to the light) counts in the quantiles and in
    the share; the maximum is that of the finite values. None where there is no value.
    """
    values = np.asarray(m, dtype=np.float64).ravel()
    values = np.sort(values[~np.isnan(values)])
    if not len(values):
        return {"m_max": None, **{name: None for name, _ in QUANTILES}, "share_above_1": None}
    finite = values[np.isfinite(values)]
    ranked = {name: values[int(np.ceil(q * (len(values) - 1)))] for name, q in QUANTILES}
    return {
        "m_max": float(finite[-1]) if len(finite) else None,
        **{name: float(value) if np.isfinite(value) else None for name, value in ranked.items()},
        "share_above_1": float(np.count_nonzero(values > 1.0) / len(values)),
    }


def aliasing_statistics(m_total: np.ndarray, m_x: np.ndarray, m_z: np.ndarray) -> dict[str, object]:
    """The report's `measured`: statistics of the total m, and under `perspective` those of m_x · m_z (method §1). Equal shapes, NaN ignored."""
    with np.errstate(invalid="ignore", over="ignore"):
        perspective = np.asarray(m_x, dtype=np.float64) * np.asarray(m_z, dtype=np.float64)
    return {**error_statistics(m_total), "perspective": error_statistics(perspective)}
