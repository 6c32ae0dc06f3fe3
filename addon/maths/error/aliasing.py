"""The aliasing error m: pixels of the image covered by one texel of the map. Its theory along the view axis, its statistics over an image.

Here m is the *perspective* error, without the term of the surface's slope. Resolution terms (res_cx/res_ls, res_cy/res_lt) are
arguments, 1 by default. Sources: T4 §4.1–4.3, LogPSM §5.1, method §1–§5. Where they are silent or contradict: docs/laboratory.md.
"""

from __future__ import annotations

from dataclasses import replace
from math import cos, exp, expm1, inf, log1p, pi, sin, sqrt, tan

import numpy as np

from ..shadow.spacing import log_perspective_derivative
from .warped_map import Values, WarpedMap

QUANTILES = (("m_p99", 0.99), ("m_p95", 0.95), ("m_median", 0.5))


def error_x(m: WarpedMap, z: Values, resolution: float = 1.0) -> Values:
    """m_x(z) on the view axis; T4 (25) for light ⟂ view: `res_cx/res_ls · f (n'+z−n)/(z (n'+f−n))`.

    For general γ (the texts give none): P's half width is κ w with `κ = max over V of x/w`, reached on V's side nearest to P's apex, at the
    far plane, `w = n' + (f−n) sin γ − (b−a) cos γ` (n' when γ < φ), or at the near plane, w = n', when the warp is stronger than the
    view's own fan of rays; so `m_x = κ ψ/(z tan φ_x)`. A log map with s left affine has f/z at every n'.
    """
    if not m.perspective_s:
        return resolution * m.far / z
    s, c, t = sin(m.gamma_rad), cos(m.gamma_rad), tan(m.half_fov_rad)
    corner = max(0.0, (m.far - m.near) * (s - t * c))
    slope = max(m.far / (1.0 + corner / m.parameter), m.near)
    return resolution * slope * (1.0 + m.offset(z) / m.parameter) / z


def beam_error_z(m: WarpedMap, z: Values, resolution: float = 1.0) -> Values:
    """m_z(z) by its definition, beam width over beam width (T4 (15), (19)): `res_cy/res_lt · (dz'/dt)/(2 z tan φ)`; what an image shows.

    It is T4 (37) times sin γ, and finite at every γ; at γ = 0 it is f/n on the near plane, as (53) says.
    """
    offset = m.offset(z)
    if not m.logarithmic:
        spacing = m.depth * (1.0 + offset / m.parameter) ** 2 / (1.0 + m.depth / m.parameter)
    elif m.parameter == inf:
        spacing = m.depth + 0.0 * offset
    else:
        spacing = m.depth / log_perspective_derivative(offset / m.depth, m.parameter / m.depth, 1.0 / m.bend if m.bend else inf)
    return resolution * spacing / (2.0 * tan(m.half_fov_rad) * z)


def error_z(m: WarpedMap, z: Values, resolution: float = 1.0) -> Values:
    """m_z(z) of T4 (37), (26) for light ⟂ view: the spacing of texels *along the view axis*, dz/dt = (dz'/dt)/sin γ; ∞ at γ = 0.

    `res_cy/res_lt · (f'−n')/(2 tan φ n' f') · ψ²/(z sin γ)`; logarithmic `ln(f'/n') ψ/(2 tan φ z sin γ)` (T4 (49), LogPSM 5.41),
    and with general b as the spacing of LogPSM 5.50 has it.
    """
    s = sin(m.gamma_rad)
    return beam_error_z(m, z, resolution) / s if s > 0.0 else z * inf


def max_error_x(m: WarpedMap, resolution: float = 1.0) -> float:
    """M_x, the largest m_x over [n, f] (T4 (28)): monotonic in z, so at an end; at n unless the warp is stronger than PSM."""
    return max(float(error_x(m, m.near, resolution)), float(error_x(m, m.far, resolution)))


def max_error_z(m: WarpedMap, resolution: float = 1.0) -> float:
    """M_z, the largest m_z over [n, f] (T4 (29), generalised): m_z has one minimum in z (38) and no maximum, so it lies at an end
    (with general b: or between)."""
    return max(float(error_z(m, z, resolution)) for z in _extreme_depths(m))


def max_beam_error_z(m: WarpedMap, resolution: float = 1.0) -> float:
    """The largest `beam_error_z` over [n, f], likewise."""
    return max(float(beam_error_z(m, z, resolution)) for z in _extreme_depths(m))


def _extreme_depths(m: WarpedMap) -> list[float]:
    """Where m_z may be largest: the ends; and for general b, where m_z ∝ (n'+o)(1+bend·o/depth)/z with o = offset(z) has no slope."""
    ends = [m.near, m.far]
    if m.bend:
        start, rise, bend = float(m.offset(0.0)), sin(m.gamma_rad), m.bend / m.depth
        square, constant = rise * rise * bend, (m.parameter + start) * (1.0 + bend * start)
        if square * constant > 0.0 and m.near < (z := sqrt(constant / square)) < m.far:
            ends.append(z)
    return ends


def side_face_maxima(m: WarpedMap) -> tuple[float, float]:
    """(R_s, R_t) of a side face of V, the light straight above it: the worst over all lights (LogPSM 5.11–5.13, 5.36–5.38, 5.42).

    M_x/cos θ and M_z/cos² θ of the same map for light ⟂ view, θ = φ; their product is S (5.52 for log+perspective).
    """
    over = replace(m, gamma_rad=pi / 2.0)
    c = cos(m.half_fov_rad)
    return max_error_x(over) / c, max_error_z(over) / c**2


# --- bounds -----------------------------------------------------------------------------------------------------------------------


def storage_factor_z(near: float, far: float, half_fov_rad: float, count: int, warped: bool) -> float:
    """S of `count` self-similar partitions, light ⟂ view: `k (r−1)/(2 tan φ)`, times r = (f/n)^(1/k) if not warped (T4 (51))."""
    log_r = log1p((far - near) / near) / count
    return count * expm1(log_r) / (2.0 * tan(half_fov_rad)) * (1.0 if warped else exp(log_r))


def storage_factor_log(near: float, far: float, half_fov_rad: float) -> float:
    """S of the logarithmic map, light ⟂ view: `ln(f/n)/(2 tan φ)` (T4 (52)), the limit of (51) for many partitions (LogPSM 5.57)."""
    return log1p((far - near) / near) / (2.0 * tan(half_fov_rad))


def storage_factor_parallel(near: float, far: float, count: int) -> float:
    """S of `count` self-similar partitions, light ∥ view: `k (f/n)^(2/k)` (T4 (53), (54)); no warp helps there."""
    return count * (far / near) ** (2.0 / count)


# --- statistics of a measured image -----------------------------------------------------------------------------------------------


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
    """The report's `measured`: statistics of the total m and, under `perspective`, of m_x · m_z (method §1). Equal shapes, NaN left out."""
    with np.errstate(invalid="ignore", over="ignore"):
        perspective = np.asarray(m_x, dtype=np.float64) * np.asarray(m_z, dtype=np.float64)
    return {**error_statistics(m_total), "perspective": error_statistics(perspective)}
