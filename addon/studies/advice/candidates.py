"""The combinations that can be advised, what the theory says of each, and their neighbours. Sources: T4 §4.2–4.3 through
`maths.error.theory`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from math import inf, log, pi

from ...maths.choices import FITS, WARPS, PartitionChoice, unsuited
from ...maths.error.aliasing import max_beam_error_z, max_error_x, side_face_maxima
from ...maths.error.warped_map import WarpedMap, partition_maps
from ...maths.partitioning import PARTITION_SCHEMES
from ...maths.warping import WARP_METHODS
from ...settings.groups import Settings

FIRST_TRIED = ("none", "z-log", "z-adaptive", "z-pssm", "z-linear", "z-pseudo-near", "faces-z")  # of equals the first wins
ALPHAS, WEIGHTS, BENDS = (2.0, 3.0, 4.0), (0.25, 0.5, 0.75, 0.9), (-0.5, 0.0, 0.5, 2.0)


@dataclass(frozen=True, slots=True)
class Candidate:
    """One combination. `alpha` matters to 'z-adaptive' only, `split_weight` to 'z-pssm', `log_bend` to 'logpsm'."""

    warp: str
    partition: str
    count: int
    fit: str
    alpha: tuple[float, ...] | None = None
    split_weight: float = 0.5
    log_bend: float = 0.0

    def settings(self, base: Settings, size: int) -> Settings:
        """`base` with this combination and maps of `size` texels per side; a warp set by hand is given up."""
        return base.replaced(
            warp={"kind": self.warp, "eta": None, "parameter": None, "log_bend": self.log_bend},
            partition={"kind": self.partition, "count": self.count, "alpha": self.alpha, "split_weight": self.split_weight},
            fit={"kind": self.fit, "size": size, "margin_texels": min(base.fit.margin_texels, size / 8)},
        )

    @property
    def options(self) -> dict[str, object]:
        """By the names of `options.OPTIONS`, only what has an effect."""
        named = {"warp": self.warp, "partition": self.partition, "fit": self.fit}
        scheme = PARTITION_SCHEMES[self.partition]
        if scheme.divides_depth:
            named["partitions"] = self.count
        if "alpha" in scheme.options and self.count > 1 and self.alpha is not None:
            named["alpha"] = self.alpha
        if "split_weight" in scheme.options:
            named["split_weight"] = self.split_weight
        if WARP_METHODS[self.warp].bends:
            named["log_bend"] = self.log_bend
        return named


def candidate_of(settings: Settings) -> Candidate:
    """The combination that `settings` hold (a warp set by hand counts as its kind)."""
    p = settings.partition
    return Candidate(settings.warp.kind, p.kind, p.z_count, settings.fit.kind, p.alpha, p.split_weight, settings.warp.log_bend)


def all_candidates(base: Settings, orthographic: bool, light_kind: str) -> list[Candidate]:
    """Every sensible combination with `base`'s α, λ and 1/b: those that mean something under this camera and light.

    An orthographic camera sees every depth alike: all its slices are of equal depth. Without α 'z-adaptive' is 'z-log' under another name,
    and stands for both.
    """
    own = base.partition.alpha, base.partition.split_weight, base.warp.log_bend
    warps = [name for name in WARPS if unsuited("warp", name, light_kind, orthographic) is None]
    twins = {"z-log"} if base.partition.seam_alphas is None else set()
    if orthographic:
        twins = {name for name, scheme in PARTITION_SCHEMES.items() if scheme.divides_depth} - {"z-linear"}
    order = dict.fromkeys((*FIRST_TRIED, *PARTITION_SCHEMES))
    kinds = [name for name in order if name not in twins and unsuited("partition", name, light_kind, orthographic) is None]
    return [Candidate(w, kind, k, fit, *own) for fit in FITS for kind in kinds for k in PARTITION_SCHEMES[kind].advised for w in warps]


def predicted(candidate: Candidate, base: Settings, view: tuple[float, float, float, float], maps: int) -> float:
    """The theory's largest m_x m_z for one texel of the whole budget, log: ln(maps · max S_i) at (near, far, φ, γ); ∞ where it knows none.

    m_z is that of the beam, as an image shows it. The budget is shared evenly, so a map has 1/`maps` of it.
    """
    near, far, phi, gamma = view
    s = candidate.settings(base, 1024)
    rows = partition_maps(near, far, phi, min(max(gamma, 1e-3), pi / 2.0), s.warp, s.partition)
    largest = max(_storage_factor(m, s.partition) for m in rows)
    return log(maps * largest) if largest < inf else inf


def _storage_factor(m: WarpedMap, partition: PartitionChoice) -> float:
    m_x, m_z = side_face_maxima(m) if partition.uses_faces else (max_error_x(m), max_beam_error_z(m))
    return m_x * m_z


def pruned(ranked: Iterable[Candidate], keep: int) -> list[Candidate]:
    """Of candidates ranked by the theory: the first `keep`, and the best of every warp and of every partition, in that order."""
    ranked = list(ranked)
    chosen = dict.fromkeys(ranked[:keep])
    for key in ("warp", "partition"):
        best: dict[str, Candidate] = {}
        for candidate in ranked:
            best.setdefault(getattr(candidate, key), candidate)
        chosen |= dict.fromkeys(best.values())
    return list(chosen)


def neighbours(candidate: Candidate) -> list[Candidate]:
    """What differs in one thing: a partition more or less, another α, λ or 1/b."""
    found = []
    scheme = PARTITION_SCHEMES[candidate.partition]
    if scheme.divides_depth:
        found += [replace(candidate, count=k) for k in (candidate.count - 1, candidate.count + 1) if 1 < k <= 8]
    if "alpha" in scheme.options:
        found += [replace(candidate, alpha=(a,)) for a in ALPHAS]
    if "split_weight" in scheme.options:
        found += [replace(candidate, split_weight=w) for w in WEIGHTS]
    if WARP_METHODS[candidate.warp].bends:
        found += [replace(candidate, log_bend=b) for b in BENDS]
    return [c for c in found if c != candidate]
