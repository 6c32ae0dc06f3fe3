"""The formulas of the warp parameter n': how strongly one shadow map is warped towards the viewer.

What it is: numbers from (near, far, φ, γ). What it is not: the methods that choose among them (a module each, beside this one), the map
t(v) itself (`shadow/projection.py`), the errors (`error/aliasing.py`). Sources: T4 §4.2, LogPSM §5.1, method §2–§3.

n' is the distance, along z_ls, from the apex of the warping pyramid P to its near plane; ∞ is the uniform map. P just holds the view
frustum V, so its depth f' − n' is `warp_depth`, and n̄' = n'/(f' − n') says how strong the warp is whatever the scale. Every parameter
here is positive or ∞, never NaN, continuous in γ, and ∞ at γ = 0, where the warp has no direction.
"""

from __future__ import annotations

from math import atan2, cos, expm1, inf, log, log1p, pi, sin, sqrt, tan

from ..spaces import smoothstep

LEAST_BEND = 1e-6  # 1/b of a log map: less is none

TSM_SHARE = 0.8
"""The 80 % rule: the share of the map that the trapezoid gives to what lies before the focus (method §3: ξ = −0.6)."""


# --- the shape of P ---------------------------------------------------------------------------------------------------------------


def warp_depth(near: float, far: float, half_fov_rad: float, gamma_rad: float) -> float:
    """Depth f' − n' of P along z_ls, metres: `(a+b) cos γ + (f−n) sin γ` for φ ≤ γ, `2 b cos γ` below (T4 (36)). Continuous, ≥ 0."""
    a, b = near * tan(half_fov_rad), far * tan(half_fov_rad)
    if gamma_rad < half_fov_rad:
        return 2.0 * b * cos(gamma_rad)
    return (a + b) * cos(gamma_rad) + (far - near) * sin(gamma_rad)


def far_parameter(parameter: float, near: float, far: float, half_fov_rad: float, gamma_rad: float) -> float:
    """f', distance from P's apex to its far plane, metres (T4 (22), (36)); ∞ for the uniform map."""
    return parameter + warp_depth(near, far, half_fov_rad, gamma_rad)


def gamma_lim_rad(near: float, far: float, half_fov_rad: float) -> float:
    """γ_lim = arctan((a+b)/(f−n)), the γ below which near and far plane overlap in the light's view (T4 (40)); φ < γ_lim ≤ π/2.

    0 for an orthographic camera (φ = 0): its planes never overlap while the light is inclined.
    """
    return atan2((near + far) * tan(half_fov_rad), far - near) if half_fov_rad > 0.0 else 0.0


# --- strength: n', η, ω -----------------------------------------------------------------------------------------------------------


def lispsm_parameter(near: float, far: float) -> float:
    """n' = n + √(fn), equal m_z at both ends for light ⟂ view (T4 (27), LogPSM 5.29)."""
    return near + sqrt(near * far)


def pseudo_near_parameter(near: float, far: float, sub_near: float, sub_far: float | None = None) -> float:
    """n' that minimises S over view depths [sub_near, sub_far] ⊂ [near, far] alone, light ⟂ view (LogPSM 5.64, 5.65).

    The larger of `n + √(z₁ z₂)` and the floor of `pseudo_near_floor`; (27) when the whole range counts.
    """
    sub_far = far if sub_far is None else sub_far
    return max(near + sqrt(sub_near * sub_far), (far - near) * pseudo_near_floor((sub_near - near) / (far - near)))


def pseudo_near_floor(v: float) -> float:
    """n̄' ≥ v/(2−3v), where dS(v)/dn̄' = 0; ∞ from v = 2/3 on (LogPSM 5.65). `v ≥ 0` is the pseudo-near plane's place in P's depth."""
    return v / (2.0 - 3.0 * v) if v < 2.0 / 3.0 else inf


def parameter_from_eta(eta: float, near: float, far: float, depth: float | None = None, balanced: float | None = None) -> float:
    """n' of η ∈ [−1, 1]; −1, 0, 1 are uniform, LiSPSM, PSM (T4 (33), its missing n mended; LogPSM 5.32–5.34).

    `depth` is P's depth f' − n' (default f − n, that is light ⟂ view): n̄' = n'/depth depends on η and f/n alone.
    `balanced` replaces n + √(fn) as the parameter of η = 0, for light ⟂ view.
    """
    balanced = lispsm_parameter(near, far) if balanced is None else balanced
    scale = 1.0 if depth is None else depth / (far - near)
    if eta <= -1.0 or balanced == inf:
        return inf
    if eta < 0.0:
        return scale * (balanced - eta * (far - near)) / (eta + 1.0)
    return scale * near * balanced / (near + eta * (balanced - near))


def eta_from_parameter(parameter: float, near: float, far: float, depth: float | None = None) -> float:
    """η of n', the inverse of `parameter_from_eta` (T4 (32)); −1 for ∞, above 1 for a warp stronger than PSM."""
    if parameter == inf or not 0.0 < near < far:
        return -1.0
    parameter = parameter if depth is None else parameter * (far - near) / depth
    balanced = lispsm_parameter(near, far)
    if parameter > balanced:
        return (balanced - parameter) / (parameter + far - near)
    return near * (balanced - parameter) / (parameter * (balanced - near))


def parameter_from_omega(omega: float, near: float, far: float, depth: float | None = None) -> float:
    """n' of ω ∈ [0, 1]: `n̄' = (n̄'₀+1)/ω − 1` (LogPSM 5.31 mended); ω = 0 uniform, ω = 1 PSM. M_x is linear in ω."""
    depth = far - near if depth is None else depth
    return inf if omega <= 0.0 else depth * (far / (far - near) / omega - 1.0)


def omega_from_parameter(parameter: float, near: float, far: float, depth: float | None = None) -> float:
    """ω = (n̄'₀+1)/(n̄'+1), the inverse of `parameter_from_omega` (LogPSM 5.30 mended); 0 for ∞."""
    depth = far - near if depth is None else depth
    return 0.0 if parameter == inf else far / (far - near) / (parameter / depth + 1.0)


# --- fading -----------------------------------------------------------------------------------------------------------------------


def convergence(gamma_rad: float, limit_rad: float, kind: str) -> float:
    """r(γ): 1 from `limit_rad` up, smooth down to 0 at γ = 0; 'sine' T4 (43), 'quadratic' T4 (44)."""
    if gamma_rad >= limit_rad:
        return 1.0
    x = gamma_rad / limit_rad
    return sin(x * pi / 2.0) if kind == "sine" else (1.0 - cos(x * pi / 2.0)) ** 2


# --- the methods ------------------------------------------------------------------------------------------------------------------


def lloyd_eta(half_fov_rad: float, gamma_rad: float, top: float = 0.0) -> float:
    """Lloyd's ramp η(γ) from −1 (uniform) below φ/3 over −0.2 at γ = φ to `top` well above φ (method §3; thesis §5.2, corrected).

    `top` is 0 (LiSPSM) for Lloyd's method; PSM and TSM, stronger warps, take the same way down from their own η.
    """
    low, mid, eta_mid = half_fov_rad / 3.0, half_fov_rad, -0.2
    high = mid + 0.3 * (pi / 2.0 - mid)
    if gamma_rad <= low:
        return -1.0
    if gamma_rad < mid:
        return -1.0 + (eta_mid + 1.0) * (1.0 - cos(pi / 2.0 * (gamma_rad - low) / (mid - low)))
    return eta_mid + (top - eta_mid) * sin(pi / 2.0 * min((gamma_rad - mid) / (high - mid), 1.0))


def lispsm_general_parameter(
    near: float, far: float, half_fov_rad: float, gamma_rad: float, kind: str = "quadratic", balanced: float | None = None
) -> float:
    """n' of the generalised LiSPSM (T4 (42)): `n'₁ = (n+√(fn)) sin γ − a cos γ` (39) from γ_lim up, `n'₁(γ_lim)/r(γ)` below."""
    limit = gamma_lim_rad(near, far, half_fov_rad)
    g = max(gamma_rad, limit)
    balanced = lispsm_parameter(near, far) if balanced is None else balanced
    first = balanced * sin(g) - near * tan(half_fov_rad) * cos(g)
    r = convergence(gamma_rad, limit, kind)
    return first / r if r > 0.0 else inf


def log_apex_parameter(
    near: float, far: float, half_fov_rad: float, gamma_rad: float, kind: str = "quadratic", apex: float | None = None
) -> float:
    """n' of the log warps: `N sin γ − a cos γ` with N = n, the apex in the eye, so that m_z is the same at every depth (LogPSM 5.41, 5.42).

    From γ_lim up. Between γ_lim and φ the near side of V turns edge-on to the light and m_x of so near an apex would pass the uniform map's
    f/n, so ln(f'/n') falls to that of the generalised LiSPSM (42), which it is below φ. `apex` replaces N (LogPSM §5.1.9).
    """
    limit = gamma_lim_rad(near, far, half_fov_rad)
    apex = near if apex is None else apex
    g = max(gamma_rad, limit)
    flat = apex * sin(g) - near * tan(half_fov_rad) * cos(g)
    if gamma_rad >= limit:
        return flat
    soft = lispsm_general_parameter(near, far, half_fov_rad, gamma_rad, kind, max(apex, lispsm_parameter(near, far)))
    if gamma_rad <= half_fov_rad:
        return soft
    depth = warp_depth(near, far, half_fov_rad, gamma_rad)
    share = smoothstep(gamma_rad, half_fov_rad, limit)
    strength = share * log1p(warp_depth(near, far, half_fov_rad, limit) / flat) + (1.0 - share) * log1p(depth / soft)
    return depth / expm1(strength)


def log_apex(near: float, far: float, sub_near: float, perspective_s: bool) -> float:
    """N = n' for light ⟂ view that minimises S of a log warp over [sub_near, far] (LogPSM §5.1.9, end). N = n when sub_near = n.

    The text leaves the search open; golden-section search over η ∈ [−1, 1], as it suggests.
    """
    v, nn = (sub_near - near) / (far - near), near / (far - near)
    if not v > 0.0:
        return near

    def storage(eta: float) -> float:
        n_bar = parameter_from_eta(eta, near, far) / (far - near)
        t = log1p(1.0 / n_bar) * (v + n_bar)
        return t * (v + n_bar) / (n_bar + 1.0) if perspective_s else t

    lo, hi, golden = -1.0 + 1e-9, 1.0, (sqrt(5.0) - 1.0) / 2.0
    for _ in range(64):
        left, right = hi - golden * (hi - lo), lo + golden * (hi - lo)
        lo, hi = (lo, right) if storage(left) < storage(right) else (left, hi)
    return max(nn * (far - near), parameter_from_eta((lo + hi) / 2.0, near, far))


def faded_bend(bend: float, near: float, far: float, strength: float) -> float:
    """1/b of a log+perspective map of strength ln(f'/n') ≥ 0 over view depths [near, far]: `bend` where it is ln(f/n), the apex in the eye.

    A weaker warp bends less, `(1+bend)^(strength/ln(f/n))`, so that the map turns uniform with the light as every other does.
    """
    if not 0.0 < near < far:
        return 0.0
    faded = expm1(log1p(bend) * min(max(strength, 0.0) / log(far / near), 1.0))
    return faded if abs(faded) > LEAST_BEND else 0.0


def tsm_eta(near: float, far: float) -> float:
    """η of the trapezoid that gives `TSM_SHARE` p of the map to what lies before the focus √(nf): `n̄' = d (1−p)/(p−d)`, at most PSM's 1."""
    focus = (sqrt(near * far) - near) / (far - near)
    return min(eta_from_parameter((far - near) * focus * (1.0 - TSM_SHARE) / (TSM_SHARE - focus), near, far), 1.0)
