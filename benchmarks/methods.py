"""The settings that are compared. Equal texels within a table: one map of N², or k maps of N²/k (sides rounded down to whole texels)."""

from __future__ import annotations

from math import isqrt

from addon.maths.choices import USUAL_ALPHA, WARPS
from addon.settings.groups import Settings

TEXELS = 2048**2
ELEVATIONS = tuple(2.0 + 88.0 * i / 19.0 for i in range(20))


def settings(
    warp: str,
    partition: str = "none",
    count: int = 1,
    fit: str = "samples",
    texels: int = TEXELS,
    cut: str = "halves",
    alpha: tuple[float, ...] | None = USUAL_ALPHA,
    **test: object,
) -> Settings:
    """One method at a number of texels in all its maps together. `faces` has up to four maps, `faces-z` four times as many as slices.

    'z-adaptive' is T4 (55) with its usual α; without α and along the light it is 'z-log'.
    """
    maps = {"none": 1, "faces": 4, "faces-z": 4 * count}.get(partition, count)
    return Settings().replaced(
        warp={"kind": warp},
        partition={"kind": partition, "count": max(count, 1), "cut": cut, "alpha": alpha},
        fit={"kind": fit, "size": isqrt(texels // maps)},
        test={"kind": "depth", **test},
    )


FIRST_LIGHT_WARP = {warp: settings(warp, fit="scene") for warp in ("uniform", "lispsm", "lispsm-general")}
FIRST_LIGHT_FIT = {fit: settings("lispsm-general", fit=fit) for fit in ("scene", "samples")}

PARTITIONED = {
    "uniform": (("z-log", 4), ("z-adaptive", 4)),
    "lispsm-general": (("z-log", 4), ("z-linear", 4), ("z-pssm", 4), ("z-pseudo-near", 4), ("z-adaptive", 4), ("faces", 1), ("faces-z", 2)),
}
METHODS = {
    **{f"{warp}, one map, {fit}": settings(warp, fit=fit) for fit in ("scene", "samples") for warp in WARPS},
    **{
        f"{warp}, {kind} {count}, {fit}": settings(warp, kind, count, fit)
        for fit in ("scene", "samples")
        for warp, divided in PARTITIONED.items()
        for kind, count in divided
    },
    **{
        f"{warp}, z-adaptive 4 {name}, {fit}": settings(warp, "z-adaptive", 4, fit, cut=cut)
        for fit in ("scene", "samples")
        for warp in PARTITIONED
        for cut, name in (("light", "slices along the light"), ("view", "across the view"))
    },
    **{
        f"{warp}, z-log {count} {name}, {fit}": settings(warp, "z-log", count, fit, cut=cut)
        for fit in ("scene", "samples")
        for warp in PARTITIONED
        for count, cut, name in ((4, "light", "slices along the light"), (8, "halves", "in halves"), (4, "auto", "by the view"))
        if fit == "samples" or cut != "auto"
    },
    "frustum fit: uniform, one map": settings("uniform", fit="frustum"),
    "frustum fit: lispsm-general, one map": settings("lispsm-general", fit="frustum"),
}

BIAS_VALUES = {
    "constant": (0.001, 0.003, 0.01, 0.03, 0.1, 0.3),
    "slope-scaled": (0.5, 1.0, 1.5),
    "normal-offset": (0.5, 1.0, 2.0, 3.0),
    "receiver-plane": (0.5, 1.0, 2.0, 3.0, 4.0),
}
BIAS_WARPS, BIAS_SIZES, COMPARED_SIZE = ("uniform", "lispsm-general", "logpsm"), (512, 1024, 2048, 4096), 1024
BIAS_METHODS = {
    f"{name}, {warp}, {size}²": settings(warp, texels=size * size, **test)
    for warp in BIAS_WARPS
    for size in BIAS_SIZES
    for name, test in (
        ("automatic", {"bias_strategy": "automatic"}),
        *(
            (f"{strategy} {value}", {"bias_strategy": strategy, "bias": value})
            for strategy, values in BIAS_VALUES.items()
            for value in values
        ),
    )
    if name == "automatic" or size == COMPARED_SIZE
}

TESTS = (("depth", {"kind": "depth"}), ("exact", {"kind": "triangle"}))
EXACT_METHODS = {
    f"{name}, {size}²": settings("lispsm-general", texels=size * size, **test)
    for size, tests in ((1024, ("depth", "exact", "outlines", "pcf")), (2048, ("depth", "exact", "outlines", "pcf")), (8192, ("depth",)))
    for name, test in (
        ("depth", {}),
        ("exact", {"kind": "triangle"}),
        ("outlines", {"kind": "triangle", "outlines": True}),
        ("pcf", {"pcf": 9}),
    )
    if name in tests
}

LAMP_METHODS = {
    **{f"{warp}, {name}": settings(warp, texels=1024**2, **test) for warp in ("uniform", "lispsm-general", "psm") for name, test in TESTS},
    **{f"four maps, {name}": settings("lispsm-general", "z-adaptive", 4, texels=1024**2, alpha=None, **test) for name, test in TESTS},
}
