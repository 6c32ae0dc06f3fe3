"""Random views for the tests of the theory, and V and P built from their corners: the oracle that knows no formula of the texts."""

from dataclasses import dataclass
from math import cos, exp, log, pi, radians, sin, tan

import numpy as np
from hypothesis import strategies as st

HOSTILE_RATIOS = (1.0001, 1.5, 4.0, 100.0, 1e7)
HOSTILE_ANGLES = (0.0, 1e-300, 1e-12, 1e-3, radians(5), radians(29.9), radians(30.1), radians(45), radians(89.999), pi / 2)


@dataclass(frozen=True)
class View:
    near: float
    far: float
    phi: float
    gamma: float

    @property
    def shape(self):
        return self.near, self.far, self.phi, self.gamma

    @property
    def ratio(self):
        return self.far / self.near


def reals(low, high):
    """Numbers between two others, none of them so near to 0 that products underflow: numpy passes over that, in tests it is an error."""
    return st.floats(low, high).map(lambda x: x if abs(x) > 1e-12 else 0.0)


def views(max_ratio=1e4, min_ratio=1.0001, min_gamma=0.0):
    def make(near, share, phi, g):
        return View(near, near * exp(log(min_ratio) + share * (log(max_ratio) - log(min_ratio))), phi, min_gamma + g * (pi / 2 - min_gamma))

    unit = reals(0.0, 1.0)
    return st.builds(make, st.floats(1e-2, 1e2), unit, st.floats(radians(2), radians(75)), unit)


def depths(view, count=257):
    z = np.geomspace(view.near, view.far, count)
    z[0], z[-1] = view.near, view.far
    return z


def light_z(view, z, y):
    """z_ls of the point (·, y, z) of the view, up to a constant."""
    return z * sin(view.gamma) + y * cos(view.gamma)


def pyramid_w(view, parameter, z, y=0.0):
    """w, the distance from P's apex, when P's near plane touches V's first corner at distance `parameter`."""
    first = min(light_z(view, end, side * end * tan(view.phi)) for end in (view.near, view.far) for side in (-1, 1))
    return light_z(view, z, y) - first + parameter


def pyramid_depth(view):
    corners = [light_z(view, end, side * end * tan(view.phi)) for end in (view.near, view.far) for side in (-1, 1)]
    return max(corners) - min(corners)


def pyramid_width(view, parameter):
    """κ/tan φ_x: P's half width over w, the least that holds V, from V's corners (x = z tan φ_x there)."""
    return max(end / pyramid_w(view, parameter, end, side * end * tan(view.phi)) for end in (view.near, view.far) for side in (-1, 1))
