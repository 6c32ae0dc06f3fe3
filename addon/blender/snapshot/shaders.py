"""A material's shader as one `Look`: closures followed through mixes, sums and groups, weighted and joined."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from .node_maths import Unfollowable
from .nodes import Ask, Plug, Surroundings, origin

Rgb = tuple[float, float, float]
BLACK: Rgb = (0.0, 0.0, 0.0)
SPECULAR_IOR = 1.5


@dataclass(frozen=True, slots=True)
class Closures:
    """Weighted closures: what reflects (`weight` of it, a `color`, `metallic`, `roughness`, the reflectance `f0` of its coat), what is
    emitted, what passes straight through, and how much is a hole in the picture."""

    weight: float = 0.0
    color: Rgb = BLACK
    metallic: float = 0.0
    roughness: float = 1.0
    f0: float = 0.0
    emission: Rgb = BLACK
    through: Rgb = BLACK
    hole: float = 0.0

    def scaled(self, factor: float) -> Closures:
        """So much of all of it."""
        emission, through = (tuple(factor * c for c in rgb) for rgb in (self.emission, self.through))
        return replace(self, weight=factor * self.weight, emission=emission, through=through, hole=factor * self.hole)

    def plus(self, other: Closures) -> Closures:
        """Both together; what reflects is one surface between the two."""
        total = self.weight + other.weight
        share = other.weight / total if total > 0.0 else 0.0
        between = {
            name: float(getattr(self, name) + share * (getattr(other, name) - getattr(self, name)))
            for name in ("metallic", "roughness", "f0")
        }
        return Closures(
            total,
            tuple(float(a + share * (b - a)) for a, b in zip(self.color, other.color, strict=True)),
            emission=tuple(a + b for a, b in zip(self.emission, other.emission, strict=True)),
            through=tuple(a + b for a, b in zip(self.through, other.through, strict=True)),
            hole=self.hole + other.hole,
            **between,
        )


def closures(place: Plug, around: Surroundings) -> Closures:
    """The closures at a shader socket; nothing where nothing is linked. Raises `Unfollowable`."""
    place = origin(place)
    if not place.socket.is_output:
        return Closures()
    node = place.socket.node
    maker = SHADERS.get(node.type)
    if maker is None:
        raise Unfollowable(node.type)
    return maker(Ask(node, place.socket, place.groups, around))


def _or(ask: Ask, name: str, otherwise: float) -> float:
    """A number of less weight: where it varies, its usual one."""
    try:
        return ask.number(name)
    except Unfollowable:
        return otherwise


def _rgb(array: np.ndarray) -> Rgb:
    return tuple(float(max(c, 0.0)) for c in array)


def _mix(ask: Ask) -> Closures:
    factor = min(max(ask.number(0), 0.0), 1.0)
    first = closures(ask.place(1), ask.around).scaled(1.0 - factor) if factor < 1.0 else Closures()
    return first.plus(closures(ask.place(2), ask.around).scaled(factor)) if factor > 0.0 else first


def _add(ask: Ask) -> Closures:
    return closures(ask.place(0), ask.around).plus(closures(ask.place(1), ask.around))


def _principled(ask: Ask) -> Closures:
    base = _rgb(ask.color("Base Color"))
    alpha = min(max(ask.number("Alpha"), 0.0), 1.0)
    metallic = min(max(_or(ask, "Metallic", 0.0), 0.0), 1.0)
    passing = alpha * (1.0 - metallic) * min(max(_or(ask, "Transmission Weight", 0.0), 0.0), 1.0)
    strength = _or(ask, "Emission Strength", 0.0)
    glow = _rgb(ask.color("Emission Color") * strength * alpha) if strength > 0.0 else BLACK
    through = tuple(1.0 - alpha + passing * c for c in base)
    ior, level = _or(ask, "IOR", SPECULAR_IOR), _or(ask, "Specular IOR Level", 0.5)
    return Closures(alpha - passing, base, metallic, _or(ask, "Roughness", 0.5), coat(ior, level), glow, through)


def coat(ior: float, level: float = 0.5) -> float:
    """Reflectance at normal incidence, scaled by Principled's level (0.5 leaves it)."""
    return min(((ior - 1.0) / (ior + 1.0)) ** 2 * 2.0 * max(level, 0.0), 1.0)


def _diffuse(ask: Ask) -> Closures:
    return Closures(1.0, _rgb(ask.color("Color")))


def _glossy(ask: Ask) -> Closures:
    return Closures(1.0, _rgb(ask.color("Color")), 1.0, _or(ask, "Roughness", 0.5))


def _metallic(ask: Ask) -> Closures:
    return Closures(1.0, _rgb(ask.color("Base Color")), 1.0, _or(ask, "Roughness", 0.5))


def _specular(ask: Ask) -> Closures:
    f0 = float(ask.color("Specular").mean())
    through = min(max(_or(ask, "Transparency", 0.0), 0.0), 1.0)
    glow = _rgb(ask.color("Emissive Color"))
    return Closures(1.0 - through, _rgb(ask.color("Base Color")), 0.0, _or(ask, "Roughness", 0.5), f0, glow, (through,) * 3)


def _glass(ask: Ask) -> Closures:
    """What it reflects is a few percent: its colour passes through."""
    return Closures(through=_rgb(ask.color("Color")))


def _transparent(ask: Ask) -> Closures:
    return Closures(through=_rgb(ask.color("Color")))


def _emission(ask: Ask) -> Closures:
    return Closures(1.0, emission=_rgb(ask.color("Color") * ask.number("Strength")))


def _hole(_ask: Ask) -> Closures:
    return Closures(hole=1.0)


SHADERS: dict[str, Callable[[Ask], Closures]] = {
    "MIX_SHADER": _mix,
    "ADD_SHADER": _add,
    "BSDF_PRINCIPLED": _principled,
    "BSDF_DIFFUSE": _diffuse,
    "BSDF_TRANSLUCENT": _diffuse,
    "SUBSURFACE_SCATTERING": _diffuse,
    "BSDF_TOON": _diffuse,
    "BSDF_SHEEN": _diffuse,
    "BSDF_VELVET": _diffuse,
    "BSDF_GLOSSY": _glossy,
    "BSDF_ANISOTROPIC": _glossy,
    "BSDF_METALLIC": _metallic,
    "EEVEE_SPECULAR": _specular,
    "BSDF_GLASS": _glass,
    "BSDF_REFRACTION": _glass,
    "BSDF_TRANSPARENT": _transparent,
    "EMISSION": _emission,
    "BACKGROUND": _emission,
    "HOLDOUT": _hole,
}
