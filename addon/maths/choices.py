"""What the user chooses of the method: warp, partition, fit. Frozen and checked; no default is written anywhere else."""

from __future__ import annotations

from dataclasses import dataclass

from .domains import one_of, require, require_fields, same_as, within
from .partitioning import PARTITION_SCHEMES
from .partitioning.row import PartitionScheme
from .warping import WARP_METHODS
from .warping.row import WarpMethod

WARPS = tuple(WARP_METHODS)
PARTITIONS = tuple(PARTITION_SCHEMES)
USUAL_ALPHA = (3.0,)
CUTS = ("auto", "halves", "light", "view")
FITS = ("frustum", "scene", "samples")
CONVERGENCES = ("quadratic", "sine")
SHORTEST_M = 1e-6


@dataclass(frozen=True, slots=True)
class WarpChoice:
    """How texels are spread along the view: the parameterisation of one shadow map.

    `eta` in (−1, 1] (T4 (32), (33)) or `parameter` (n', metres, > 0) override the value that `kind` computes.
    `pseudo_near` (view depth, metres) is the near distance from which the warp is optimised (LogPSM 5.64, 5.65).
    `convergence` is the way to uniform below γ_lim: 'sine' T4 (43), 'quadratic' T4 (44).
    `log_bend` is 1/b of 'logpsm' (LogPSM 5.47–5.51, spacing ∝ (v+n̄')(v+b)) for light ⟂ view: 0 the logarithm of 5.43 (b = ∞), above it
    more texels near, 1/n̄' the perspective map, below it, > −1, more of them far (b < −1).
    """

    kind: str = one_of("lispsm-general", "Warp", WARPS)
    eta: float | None = within(None, "The warp's η", -1.0, 1.0)
    parameter: float | None = within(None, "The warp parameter n' (metres)", SHORTEST_M, has_infinity=True)
    pseudo_near: float | None = within(None, "The pseudo-near distance (metres)", SHORTEST_M)
    convergence: str = one_of("quadratic", "Convergence", CONVERGENCES)
    log_bend: float = within(0.0, "The log warp's bend 1/b", -0.99, 1e6)

    def __post_init__(self) -> None:
        require_fields(self)
        require(self.eta is None or self.parameter is None, "Give η or the warp parameter n', not both.")

    @property
    def method(self) -> WarpMethod:
        """The row of its kind."""
        return WARP_METHODS[self.kind]


@dataclass(frozen=True, slots=True)
class PartitionChoice:
    """How the view is divided among shadow maps.

    `count` is the number of z partitions; `split_weight` λ of PSSM (1 = logarithmic, 0 = linear; LogPSM 5.60);
    `alpha` the seam controls α_i of T4 (55), one for all or one per split, usually 2…4 (None: 3 for the cut 'view'; for cuts along the
    light, which need no adapting to γ, self-similar splits);
    `pseudo_near` the end of the first partition of 'z-pseudo-near' (view depth, metres; None: chosen from n and f).
    `cut`: 'view' parts the view at the scheme's view depths (T4 §4.3.2); 'light' (a sun, no faces) along the light's rays, so that the
    maps do not overlap as the light sees them (`shadow/slices.py`); 'halves' the same with half as many slices, each in two halves side by
    side; 'auto' the one of these two that suits the view (`shadow/suited_cut.py`). A spot's maps part its picture instead with 'z-adaptive'
    and any of these but 'view' (`shadow/lamps.py`).
    """

    kind: str = one_of("z-adaptive", "Partition", PARTITIONS)
    count: int = within(4, "The number of z partitions", 1, 8)
    split_weight: float = within(0.5, "The split weight (0 linear, 1 logarithmic)", 0.0, 1.0)
    alpha: tuple[float, ...] | None = within(None, "Every α (usually 2 to 4)", 1.001)
    pseudo_near: float | None = same_as(WarpChoice, "pseudo_near")
    cut: str = one_of("auto", "Cut", CUTS)

    def __post_init__(self) -> None:
        require_fields(self)
        require(self.alpha is None or len(self.alpha) > 0, "Give at least one seam control α, or leave it out.")

    @property
    def scheme(self) -> PartitionScheme:
        """The row of its kind."""
        return PARTITION_SCHEMES[self.kind]

    @property
    def z_count(self) -> int:
        """Number of z partitions this choice asks for (1 for schemes that do not divide the depth)."""
        return self.count if self.scheme.divides_depth else 1

    @property
    def seam_alphas(self) -> tuple[float, ...] | None:
        """α_i in effect; None for self-similar splits. T4's slabs overlap in the light's picture the more the nearer γ is to 0, and (55)
        answers that; planes along the light do not overlap, and (50) measures better there at every γ (docs/laboratory.md)."""
        return USUAL_ALPHA if self.alpha is None and self.cut == "view" else self.alpha

    @property
    def uses_faces(self) -> bool:
        """True when the side faces of the view frustum get maps of their own (T4 §4.3.1)."""
        return self.scheme.has_faces


@dataclass(frozen=True, slots=True)
class FitChoice:
    """What the light frustum is fitted to, and the texels it gets.

    `kind`: 'frustum' the whole view frustum, 'scene' its intersection with the scene's bounds, 'samples' the receivers really visible.
    `size` texels per side and partition; `margin_texels` border kept free for filters.
    """

    kind: str = one_of("samples", "Fit", FITS)
    size: int = within(1024, "The map size (texels per side)", 16, 16384)
    margin_texels: float = within(1.0, "The margin (texels)", 0.0, 4095.0)

    def __post_init__(self) -> None:
        require_fields(self)
        require(self.margin_texels < self.size / 4, "The margin must be smaller than a quarter of the map.")


def unsuited(name: str, identifier: str, light_kind: str, is_orthographic: bool = False) -> str | None:
    """Why `identifier` as 'warp' or 'partition' means nothing under a light of kind 'sun', 'spot' or 'point', or for such a camera.

    None where it does mean something, and for every other option.
    """
    kind = light_kind.capitalize()
    warp, scheme = WARP_METHODS.get(identifier if name == "warp" else ""), PARTITION_SCHEMES.get(identifier if name == "partition" else "")
    if light_kind != "sun" and warp and warp.log is not None:
        return f"{kind} light: drawn as a perspective warp, a logarithm needs a sun"
    if light_kind == "point" and scheme and scheme.is_divided:
        return "Point light: six maps, one for each side of a cube, not divided further"
    if light_kind != "sun" and scheme and scheme.has_faces:
        return f"{kind} light: divided in depth only, faces need a sun"
    if is_orthographic and warp and warp.is_warped:
        return "Orthographic camera: sees every depth alike, there is nothing to warp"
    if is_orthographic and scheme and scheme.has_faces:
        return "Orthographic camera: divided in depth only, faces fan out from an eye"
    return None
