"""What the user chooses of the method: warp, partition, fit. Frozen and checked; no default is written anywhere else."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cache
from math import inf
from numbers import Integral, Real

import numpy as np

from ..errors import SettingsError

WARPS = ("uniform", "psm", "lispsm", "lispsm-general", "lloyd", "tsm", "log", "logpsm")
PARTITIONS = ("none", "z-log", "z-linear", "z-pssm", "z-pseudo-near", "z-adaptive", "faces", "faces-z")
USUAL_ALPHA = (3.0,)
CUTS = ("halves", "light", "view")
FITS = ("frustum", "scene", "samples")
CONVERGENCES = ("quadratic", "sine")
LOG_WARPS = ("log", "logpsm")


def require(condition: bool, message: str) -> None:
    """Raise `SettingsError(message)` unless the condition holds; write it so that NaN fails."""
    if not condition:
        raise SettingsError(message)


def require_choice(name: str, value: str, allowed: tuple[str, ...]) -> None:
    """Raise `SettingsError` unless `value` is one of `allowed`."""
    require(value in allowed, f"{name} is '{value}': choose one of {', '.join(allowed)}.")


_KINDS: dict[str, tuple[str, Callable[[object], bool]]] = {
    "str": ("text", lambda value: isinstance(value, str)),
    "bool": ("true or false", lambda value: isinstance(value, bool | np.bool_)),
    "int": ("a whole number", lambda value: isinstance(value, Integral) and not isinstance(value, bool)),
    "float": ("a number", lambda value: isinstance(value, Real) and not isinstance(value, bool)),
}


def require_types(choice: object) -> None:
    """Raise `SettingsError` unless each field of a dataclass holds what its annotation says: a settings file may put anything there."""
    for name, is_optional, kind, count in _annotated(type(choice)):
        value = getattr(choice, name)
        if value is None and is_optional:
            continue
        words, fits = _KINDS[kind]
        if count is None:
            require(fits(value), f"{name} is {value!r}, not {words}.")
        else:
            many = "numbers" if count is ... else f"{count} numbers"
            require(isinstance(value, tuple) and count in (..., len(value)) and all(map(fits, value)), f"{name} is {value!r}, not {many}.")


@cache
def _annotated(kind: type) -> tuple[tuple[str, bool, str, object], ...]:
    """(name, may be None, type, how many of a tuple) of a dataclass's fields: '...' any number, None no tuple."""
    found = []
    for one in fields(kind):
        text = one.type.removesuffix(" | None")
        inside = text.removeprefix("tuple[").removesuffix("]").split(", ")
        count = None if text == inside[0] else ... if inside[-1] == "..." else len(inside)
        found.append((one.name, text != one.type, inside[0], count))
    return tuple(found)


@dataclass(frozen=True, slots=True)
class WarpChoice:
    """How texels are spread along the view: the parameterisation of one shadow map.

    `eta` in (−1, 1] (T4 (32), (33)) or `parameter` (n', metres, > 0) override the value that `kind` computes.
    `pseudo_near` (view depth, metres) is the near distance from which the warp is optimised (LogPSM 5.64, 5.65).
    `convergence` is the way to uniform below γ_lim: 'sine' T4 (43), 'quadratic' T4 (44).
    `log_bend` is 1/b of 'logpsm' (LogPSM 5.47–5.51, spacing ∝ (v+n̄')(v+b)) for light ⟂ view: 0 the logarithm of 5.43 (b = ∞), above it
    more texels near, 1/n̄' the perspective map, below it, > −1, more of them far (b < −1).
    """

    kind: str = "lispsm-general"
    eta: float | None = None
    parameter: float | None = None
    pseudo_near: float | None = None
    convergence: str = "quadratic"
    log_bend: float = 0.0

    def __post_init__(self) -> None:
        require_types(self)
        require_choice("Warp", self.kind, WARPS)
        require_choice("Convergence", self.convergence, CONVERGENCES)
        require(self.eta is None or -1.0 <= self.eta <= 1.0, "The warp's η must lie between −1 (uniform) and 1 (PSM).")
        require(self.parameter is None or 0.0 < self.parameter <= inf, "The warp parameter n' must be a positive distance in metres.")
        require(self.pseudo_near is None or 0.0 < self.pseudo_near < inf, "The pseudo-near distance must be positive.")
        require(-1.0 < self.log_bend < inf, "The log warp's bend 1/b must be greater than −1.")
        require(self.eta is None or self.parameter is None, "Give η or the warp parameter n', not both.")

    @property
    def is_logarithmic(self) -> bool:
        """True for the warps whose t axis is logarithmic (LogPSM §5.1.3, §5.1.4)."""
        return self.kind in LOG_WARPS


@dataclass(frozen=True, slots=True)
class PartitionChoice:
    """How the view is divided among shadow maps.

    `count` is the number of z partitions; `split_weight` λ of PSSM (1 = logarithmic, 0 = linear; LogPSM 5.60);
    `alpha` the seam controls α_i of T4 (55), one for all or one per split, usually 2…4 (None: 3 for the cut 'view'; for cuts along the
    light, which need no adapting to γ, self-similar splits);
    `pseudo_near` the end of the first partition of 'z-pseudo-near' (view depth, metres; None: chosen from n and f).
    `cut`: 'view' parts the view at the scheme's view depths (T4 §4.3.2); 'light' (a sun, no faces) along the light's rays, so that the
    maps do not overlap as the light sees them (`shadow/slices.py`); 'halves' the same with half as many slices, each in two halves side by
    side.
    """

    kind: str = "z-adaptive"
    count: int = 4
    split_weight: float = 0.5
    alpha: tuple[float, ...] | None = None
    pseudo_near: float | None = None
    cut: str = "halves"

    def __post_init__(self) -> None:
        require_types(self)
        require_choice("Partition", self.kind, PARTITIONS)
        require_choice("Cut", self.cut, CUTS)
        require(1 <= self.count <= 8, "The number of z partitions must lie between 1 and 8.")
        require(0.0 <= self.split_weight <= 1.0, "The split weight must lie between 0 (linear) and 1 (logarithmic).")
        usable = self.alpha is None or (len(self.alpha) >= 1 and all(1.0 < a < inf for a in self.alpha))
        require(usable, "Every α must be greater than 1 (usually 2 to 4).")
        require(self.pseudo_near is None or 0.0 < self.pseudo_near < inf, "The pseudo-near distance must be positive.")

    @property
    def z_count(self) -> int:
        """Number of z partitions this choice asks for (1 for 'none' and 'faces')."""
        return 1 if self.kind in ("none", "faces") else self.count

    @property
    def seam_alphas(self) -> tuple[float, ...] | None:
        """α_i in effect; None for self-similar splits. T4's slabs overlap in the light's picture the more the nearer γ is to 0, and (55)
        answers that; planes along the light do not overlap, and (50) measures better there at every γ (docs/findings.md)."""
        return USUAL_ALPHA if self.alpha is None and self.cut == "view" else self.alpha

    @property
    def uses_faces(self) -> bool:
        """True when the side faces of the view frustum get maps of their own (T4 §4.3.1)."""
        return self.kind in ("faces", "faces-z")


@dataclass(frozen=True, slots=True)
class FitChoice:
    """What the light frustum is fitted to, and the texels it gets.

    `kind`: 'frustum' the whole view frustum, 'scene' its intersection with the scene's bounds, 'samples' the receivers really visible.
    `size` texels per side and partition; `margin_texels` border kept free for filters.
    """

    kind: str = "samples"
    size: int = 1024
    margin_texels: float = 1.0

    def __post_init__(self) -> None:
        require_types(self)
        require_choice("Fit", self.kind, FITS)
        require(16 <= self.size <= 16384, "The map size must lie between 16 and 16384 texels per side.")
        require(0.0 <= self.margin_texels < self.size / 4, "The margin must be smaller than a quarter of the map.")


def unsuited(name: str, identifier: str, light_kind: str, is_orthographic: bool = False) -> str | None:
    """Why `identifier` as 'warp' or 'partition' means nothing under a light of kind 'sun', 'spot' or 'point', or for such a camera.

    None where it does mean something, and for every other option.
    """
    kind = light_kind.capitalize()
    if light_kind != "sun" and name == "warp" and identifier in LOG_WARPS:
        return f"{kind} light: drawn as a perspective warp, a logarithm needs a sun"
    if light_kind == "point" and name == "partition" and identifier != "none":
        return "Point light: six maps, one for each side of a cube, not divided further"
    if light_kind != "sun" and name == "partition" and identifier.startswith("faces"):
        return f"{kind} light: divided in depth only, faces need a sun"
    if is_orthographic and name == "warp" and identifier != "uniform":
        return "Orthographic camera: sees every depth alike, there is nothing to warp"
    if is_orthographic and name == "partition" and identifier.startswith("faces"):
        return "Orthographic camera: divided in depth only, faces fan out from an eye"
    return None
