"""The strength ln(f'/n') that a fitted map really gets: the method's own, made true to a rectangular frustum and held steady in time.

The texts choose n' in the plane of light and view, for a frustum of half angle φ there. A light from the side sees the picture's width,
not its height: where near and far plane overlap for that larger angle, the strength is that of a frustum as wide (T4 (40), (42)).

A camera moves. Along the view axis the warp has no direction, so there it must be gone (`light_space.roundness`), and on the way there
the size of a texel, which follows f'/n', must not jump from one frame to the next (25 % at 1° a frame). So the strength is the
largest function of γ below the method's own that nowhere grows faster than `RATE`. T4 (42) itself grows slower than that from γ_lim up
unless the view is narrow and f/n large (φ = 15°, f/n = 100 just meets it); PSM and the log warps at large f/n fade some degrees earlier.

Where the near side of the frustum turns edge-on to the light (γ = its half angle) the far corner on that side comes level with P's near
plane, by its distance from the eye times the change of γ, and with 1/w of that corner the map widens. So n' is never so small that w there
could change by more than `STEP` in a degree.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, cos, degrees, log1p, radians, sin

from ..choices import WarpChoice
from ..warping.formulas import warp_depth
from ..warping.row import RATE
from .warps import warp_parameter

STRONGEST = 1e4  # largest f'/n': beyond it float32 cannot place a texel
STEP = 0.15  # of ln w of the frustum's far corner, per degree of γ


@dataclass(frozen=True, slots=True)
class Range:
    """What one map's warp is made for: view depths near and far, φ, the half angle in the plane of light and view (`side`, ≥ 0), and the
    ratio `stretch` of P's real depth to the text's (36)."""

    near: float
    far: float
    half_fov_rad: float
    side_rad: float
    stretch: float = 1.0


def method_strength(choice: WarpChoice, extent: Range, gamma_rad: float) -> float:
    """ln(f'/n') of the method at γ (T4 (36)), never stronger than for a frustum whose half angle is `side_rad`, nor than the far corner
    allows; 0 for a uniform map."""
    near, far = extent.near, extent.far
    depth = extent.stretch * warp_depth(near, far, extent.half_fov_rad, gamma_rad)
    own = log1p(depth / warp_parameter(choice, near, far, extent.half_fov_rad, gamma_rad))
    wide = log1p(warp_depth(near, far, extent.side_rad, gamma_rad) / warp_parameter(choice, near, far, extent.side_rad, gamma_rad))
    reach = far / cos(extent.side_rad)
    corner = max(0.0, (1.0 - near / far) * reach * sin(gamma_rad - extent.side_rad))  # from P's near plane to the far corner
    allowed = log1p(depth / max(reach * radians(1.0) / STEP - corner, depth / STRONGEST))
    return min(own, wide, allowed)


def steady_strength(choice: WarpChoice, extent: Range, gamma_rad: float, core_rad: float, rate: float = RATE) -> float:
    """min over whole degrees g < γ of `method_strength`(g) + rate (γ − g), of that of γ itself, and of rate (γ − core); 0 inside the core.

    Never negative. The places asked do not move with γ: what bounds one frame bounds the next.
    """
    gamma_deg = degrees(gamma_rad)
    best = min(method_strength(choice, extent, gamma_rad), max(0.0, rate * (gamma_deg - degrees(core_rad))))
    for place in range(ceil(gamma_deg) - 1, 0, -1):
        rise = rate * (gamma_deg - place)
        if rise >= best:
            break
        best = min(best, method_strength(choice, extent, radians(place)) + rise)
    return best
