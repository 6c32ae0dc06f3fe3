"""Rows → Markdown. `write` makes docs/quality.md from whatever has been measured; a table without rows is left out and named."""

from __future__ import annotations

from collections.abc import Iterable
from math import inf
from pathlib import Path
from statistics import fmean, geometric_mean

from benchmarks.measure import Row, mean, middle, read, where
from benchmarks.texels import TexelRow
from benchmarks.texels import read as read_texels

INTRO = """# Quality, measured

Made by `python -m benchmarks.quality` (see its help); do not edit. Every number compares a rendered view with ray-traced truth at the
pixel centres (`addon/studies/truth`), hard sun, 640×360, three views × five lights of each model (`benchmarks/views.py`).

- **misclassified**: pixels lit in one and dark in the other, in per cent of the pixels whose surface faces the light, edges included.
- **acne** / **leak**: those of them (dark here / lit here) around which the truth is uniform within two pixels or one texel's
  footprint, whichever is larger. A texel of edge error is neither.
- **edge**: distance of a true shadow edge to the nearest edge of the preview, pixels (95th percentile).
- **m**: pixels of the picture covered by one texel of the map (the report's `measured`).
- What presets, tests and samples cost for their error: [error against time](front.md).
- Means are over view/light pairs, each pair counting the same, unless a table says otherwise. *At*: view at an object, f/n of what is
  visible < 15; *along*: ≥ 20.
"""


def table(head: Iterable[str], lines: Iterable[Iterable[object]]) -> str:
    """A Markdown table; floats with two digits, None as –."""

    def cell(value: object) -> str:
        return "–" if value is None else f"{value:.2f}" if isinstance(value, float) else str(value)

    head = list(head)
    return "\n".join("| " + " | ".join(row) + " |" for row in ([cell(c) for c in line] for line in (head, ["---"] * len(head), *lines)))


def first_light_warp(rows: list[Row]) -> str:
    """Uniform against the LiSPSMs on the deck, pair by pair and in the mean."""
    methods = list(dict.fromkeys(row.method for row in rows))
    pairs = list(dict.fromkeys((row.view, row.light) for row in rows))
    lines = [
        (
            view,
            light,
            round(where(rows, view=view, light=light)[0].depth_ratio),
            *(mean(where(rows, view=view, light=light, method=m), "misclassified_pct") for m in methods),
        )
        for view, light in pairs
    ]
    means = [mean(where(rows, method=m), "misclassified_pct") for m in methods]
    ratio = means[methods.index("lispsm-general")] / means[methods.index("uniform")]
    return (
        "## First light: the warp, along a scene\n\nPlatform deck (500 thousand triangles, 240 m), one 2048² map, `scene` fit; "
        f"misclassified %. Generalised LiSPSM over uniform: **{ratio:.2f}** (wanted ≤ 0.6).\n\n"
        + table(("view", "light", "f/n", *methods), [*lines, ("**mean**", "", "", *means)])
    )


def first_light_fit(rows: list[Row]) -> str:
    """`samples` against `scene`, outside views."""
    lines, gains = [], []
    for model in dict.fromkeys(row.model for row in rows):
        for view in dict.fromkeys(row.view for row in where(rows, model=model)):
            cells = [mean(where(rows, model=model, view=view, method=fit), "misclassified_pct") for fit in ("scene", "samples")]
            lines.append((model, view, *cells, cells[0] / cells[1]))
        whole = [mean(where(rows, model=model, method=fit), "misclassified_pct") for fit in ("scene", "samples")]
        lines.append((f"**{model}**", "mean", *whole, whole[0] / whole[1]))
        gains.append(f"{model} **{whole[0] / whole[1]:.2f} ×**")
    return (
        "## First light: the fit, at an object\n\nGeneralised LiSPSM, one 2048² map, mean of five lights; misclassified %. "
        f"Gain of `samples` over `scene`: {', '.join(gains)} (wanted ≥ 1.3 ×).\n\n"
        + table(("model", "view", "scene", "samples", "gain"), lines)
    )


def pooled_pct(rows: list[Row]) -> float:
    """Misclassified pixels of all pairs in per cent of all their pixels that face the light: a pair with few such pixels counts little."""
    return sum((row.misclassified_pct or 0.0) * row.pixels for row in rows) / sum(row.pixels for row in rows)


def over_models(rows: list[Row]) -> float:
    """Mean of the models' pooled misclassified %, each model counting the same."""
    return fmean(pooled_pct(where(rows, model=model)) for model in {row.model for row in rows})


def against_one_map(by_model: dict[tuple[str, str], float], name: str, models: list[str]) -> tuple[float, float] | tuple[None, None]:
    """(geometric mean over models, worst model) of a method's misclassified % over that of one map of the same warp, fit and texels."""
    warp, *_, fit = name.split(", ")
    one = f"{warp}, one map, {fit}"
    ratios = [by_model[m, name] / by_model[m, one] for m in models if (m, name) in by_model and by_model.get((m, one))]
    return (geometric_mean(ratios), max(ratios)) if ratios and name != one else (None, None)


def methods(rows: list[Row]) -> str:
    """Methods × models at equal texels, and the same by class of view."""
    models = list(dict.fromkeys(row.model for row in rows))
    names = list(dict.fromkeys(row.method for row in rows))
    by_model = {(m, name): pooled_pct(mine) for name in names for m in models if (mine := where(rows, method=name, model=m))}
    wide = [(name, *(by_model.get((m, name)) for m in models)) for name in names]
    classes = {"at": [r for r in rows if r.depth_ratio < 15.0], "along": [r for r in rows if r.depth_ratio >= 20.0]}
    lines = []
    by_class = {kind: {n: over_models(mine) for n in names if (mine := where(members, method=n))} for kind, members in classes.items()}
    against = {name: against_one_map(by_model, name, models) for name in names}
    for name in names:
        cells: list[object] = [name]
        for kind, members in classes.items():
            mine = where(members, method=name)
            largest = max((r.m_max for r in mine if r.m_max is not None), default=None)
            cells += [by_class[kind][name], mean(mine, "m_p95"), largest] if mine else [None] * 3
        mine = where(rows, method=name)
        lines.append(
            (
                *cells,
                *against[name],
                mean(mine, "acne_pct"),
                mean(mine, "leak_pct"),
                middle(mine, "shadow_ms"),
                middle(mine, "shade_ms"),
                len({r.model for r in mine}),
            )
        )
    return (
        "## Methods × models, 4 Mi texels\n\nBy class of view: misclassified % (of all its pairs' pixels, mean over models), 95th "
        "percentile of m (mean over pairs), largest m. *Of one map*: over the misclassified % of one map of the same warp, fit and "
        "number of texels, geometric mean over the models, and the worst model. Acne and leak over all pairs; milliseconds of the "
        "shadow and shading passes (median), taken on a loaded machine: `./dev bench` measures speed.\n\n"
        + table(
            (
                "method",
                "at: wrong",
                "m p95",
                "m max",
                "along: wrong",
                "m p95",
                "m max",
                "of one map",
                "worst",
                "acne %",
                "leak %",
                "shadow ms",
                "shade ms",
                "models",
            ),
            lines,
        )
        + "\n\nWhat was expected of them (the default partitioning is z-log 4: z-adaptive without α, along the light; z-adaptive "
        "here is T4's, with α = 3):\n\n"
        + expected(by_class, against)
        + "\n\nMisclassified % by model (of the pixels of its 15 pairs together):\n\n"
        + table(("method", *(Path(m).stem for m in models)), wide)
    )


def expected(by_class: dict[str, dict[str, float]], against: dict[str, tuple[float | None, float | None]]) -> str:
    """What was expected of the methods, beside what came out; `by_class` misclassified % by class of view and method."""
    at, along = by_class["at"], by_class["along"]
    lines = []
    for fit in ("scene", "samples"):
        one = {warp: along[f"{warp}, one map, {fit}"] for warp in ("lispsm-general", "lispsm", "uniform")}
        lines.append((f"along, `{fit}`: generalised ≤ original ≤ uniform", " / ".join(f"{v:.2f} %" for v in one.values())))
    for fit in ("scene", "samples"):
        best = min((n for n in along if n.endswith(fit)), key=along.__getitem__)
        ratio = along[best] / along["uniform, one map, scene"]
        wanted = " ≤ 0.4" if fit == "scene" else ""
        lines.append((f"along, `{fit}`: best over uniform with `scene`{wanted}", f"{ratio:.2f} ({best.removesuffix(', ' + fit)})"))
    for name in ("uniform, one map", "lispsm-general, one map", "lispsm-general, z-log 4"):
        gain = at[f"{name}, scene"] / at[f"{name}, samples"]
        lines.append((f"at an object, {name}: gain of `samples` over `scene` ≥ 1.5", f"{gain:.2f} ×"))
    for fit in ("scene", "samples"):
        ratio = at[f"lispsm-general, one map, {fit}"] / at[f"uniform, one map, {fit}"]
        lines.append((f"at an object, `{fit}`: the warp is neutral", f"generalised {ratio:.2f} of uniform"))
    for fit in ("scene", "samples"):
        ratio, worst = against[f"lispsm-general, z-log 4, {fit}"]
        lines.append((f"the default partitioning, `{fit}`, over one map ≤ 1.05", f"{ratio:.2f} in the mean, {worst:.2f} the worst model"))
    return table(("expected", "measured"), lines)


def texels(rows: list[TexelRow]) -> str:
    """The mean extent of a texel by method and class of view, and against one map of as many texels."""
    sides: dict[str, dict[tuple, float]] = {}
    for row in rows:
        sides.setdefault(row.method, {})[row.model, row.view, row.light] = row.side_mean
    ratio = {(row.model, row.view, row.light): row.depth_ratio for row in rows}
    base = sides["uniform, one map, scene"]
    lines = []
    for name, mine in sides.items():
        cells: list[object] = [name]
        for low, high in ((0.0, 15.0), (20.0, inf)):
            pairs = [pair for pair in mine if low <= ratio[pair] < high]
            cells += [fmean(mine[p] for p in pairs), fmean(mine[p] for p in pairs) / fmean(base[p] for p in pairs)] if pairs else [None] * 2
        warp, *_, fit = name.split(", ")
        one = sides.get(f"{warp}, one map, {fit}", {})
        against = [mine[p] / one[p] for p in mine if p in one] if "one map" not in name else []
        by_view = {p[:2]: [mine[q] / one[q] for q in mine if q[:2] == p[:2]] for p in mine} if against else {}
        lines.append(
            (
                *cells,
                fmean(against) if against else None,
                max(map(fmean, by_view.values())) if against else None,
                max(against) if against else None,
            )
        )
    head = ("method", "at: px", "of uniform", "along: px", "of uniform", "against one map", "worst view", "worst pair")
    return (
        "## Texels in the picture, 4 Mi texels\n\nMean extent of a texel, pixels (half the sum of its two, over the visible points "
        f"that face the light), no truth needed: {len({row.model for row in rows})} models, three views × five lights. *Of uniform*: "
        "against one uniform map with the `scene` fit. *Against one "
        "map*: partitions against one map of the same warp, fit and number of texels; mean, the worst view (mean of its lights), the "
        "worst pair.\n\n" + table(head, lines)
    )


def bias(rows: list[Row]) -> str:
    """Automatic over warps and map sizes; at one size, every other strategy at its best single value beside it; by model."""

    def columns(chosen: list[Row]) -> tuple[object, ...]:
        acne, leak = ([getattr(r, key) or 0.0 for r in chosen] for key in ("acne_pct", "leak_pct"))
        return (
            len(chosen),
            mean(chosen, "misclassified_pct"),
            f"{fmean(acne):.4f}",
            f"{max(acne):.3f}",
            sum(a > 0.02 for a in acne),
            f"{fmean(leak):.4f}",
            f"{max(leak):.3f}",
            sum(a > 0.1 for a in leak),
        )

    head = ("pictures", "wrong %", "acne %", "worst", "above 0.02", "leak %", "worst", "above 0.1")
    named = [(row, *row.method.split(", ")) for row in rows]
    places = dict.fromkeys((w, s) for _, _, w, s in named)
    automatic = {key: [r for r, n, *k in named if n == "automatic" and tuple(k) == key] for key in places}
    compared = {(w, s) for _, n, w, s in named if n != "automatic"}
    pictures: dict[tuple[str, ...], set[str]] = {}
    for row, name, warp, size in named:
        pictures.setdefault((row.model, row.view, row.light, warp, size), set()).add(name)
    every_name = max(pictures.values(), key=len)
    values: dict[str, list[Row]] = {}
    for row, name, warp, size in named:
        if (warp, size) in compared and pictures[row.model, row.view, row.light, warp, size] == every_name:
            values.setdefault(name, []).append(row)
    best: dict[str, str] = {}
    for name in sorted(values, key=lambda n: mean(values[n], "misclassified_pct")):
        best.setdefault(name.split()[0], name)
    models = list(dict.fromkeys(row.model for row in rows))
    every = [r for chosen in automatic.values() for r in chosen]
    per_model = [
        (m, len({r.light for r in where(rows, model=m)}), *(mean(where(values[n], model=m), "misclassified_pct") for n in best.values()))
        for m in models
    ]
    return (
        "## Bias\n\nOne view per model (320×180), up to 20 light elevations from 2° to 90° (how many of each model: last table), "
        "`samples` fit, one map. Every picture counts the same. Wanted of automatic, which needs no number: acne ≤ 0.02 %, leak ≤ "
        "0.1 %. Leaks count what is lit though all around it is dark, detached shadows included.\n\n"
        + table(
            ("warp", "map", *head), [*((*key, *columns(chosen)) for key, chosen in automatic.items()), ("**all**", "", *columns(every))]
        )
        + f"\n\nEvery strategy at the single value with the fewest misclassified pixels over all of that "
        f"({', '.join(sorted({s for _, s in compared}))}, all warps):\n\n"
        + table(("strategy and value", *head), [(name, *columns(values[name])) for name in best.values()])
        + "\n\nThe same by model, wrong %, on the pictures that every strategy was measured on (*lights*: of automatic):\n\n"
        + table(("model", "lights", *best.values()), per_model)
    )


def exact(rows: list[Row]) -> str:
    """Triangle-exact against depth, by model, and where it is worse."""
    names = list(dict.fromkeys(row.method for row in rows))
    models = list(dict.fromkeys(row.model for row in rows))
    lines = [(model, *(mean(where(rows, model=model, method=n), "misclassified_pct") for n in names)) for model in models]
    means = {n: mean(where(rows, method=n), "misclassified_pct") for n in names}
    tests = [name for name in ("exact", "outlines") if f"{name}, 2048²" in means]
    ratios = [
        f"{size}: " + ", ".join(f"{name} **{means[f'{name}, {size}'] / means[f'depth, {size}']:.2f}**" for name in tests)
        for size in ("1024²", "2048²")
    ]
    acne = [
        (n, f"{mean(where(rows, method=n), 'acne_pct'):.4f}", f"{max(r.acne_pct or 0.0 for r in where(rows, method=n)):.4f}") for n in names
    ]
    by_place = {(r.model, r.light, r.method): r.misclassified_pct for r in rows}
    pairs = [
        (by_place[m, light, f"exact, {size}"], value)
        for (m, light, name), value in by_place.items()
        for size in ("1024²", "2048²")
        if name == f"depth, {size}"
    ]
    worse = sum(exact_pct > depth_pct for exact_pct, depth_pct in pairs)
    lights = [len({r.light for r in where(rows, model=m)}) for m in models]
    return (
        f"## The triangle-exact test\n\nOne view per model, {min(lights)} to {max(lights)} lights each, generalised LiSPSM, `samples` "
        f"fit, one map, automatic bias; misclassified %. *outlines*: the exact test with `outlines`. "
        f"Over depth: {'; '.join(ratios)} (wanted ≤ 0.35); "
        f"exact at 2048² over depth at 8192²: **{means['exact, 2048²'] / means['depth, 8192²']:.2f}** (wanted ≤ 1). "
        f"Pictures in which exact is worse than depth with the same map: {worse} of {len(pairs)}.\n\n"
        + table(("model", *names), [*lines, ("**mean**", *means.values())])
        + "\n\n"
        + "What each costs: [shadow tests](shadow_tests.md).\n\n"
        + table(("test", "acne %", "worst"), acne)
    )


def lamps(rows: list[Row]) -> str:
    """Spots and point lights, by where they stand: uniform, warped and parted at equal texels a light's side."""
    methods = list(dict.fromkeys(row.method for row in rows))
    lights = list(dict.fromkeys(row.light for row in rows))
    shown = {(light, m): where(rows, light=light, method=m) for light in lights for m in methods}
    lines = [(light, *(mean(shown[light, m], "misclassified_pct") if shown[light, m] else None for m in methods)) for light in lights]
    total = [mean(where(rows, method=m), "misclassified_pct") for m in methods]
    flaws = [(m, *(f"{x:.4f}" for key in ("acne_pct", "leak_pct") for x in spread(where(rows, method=m), key))) for m in methods]
    return (
        f"## Lamps\n\nOne view of {len({row.model for row in rows})} models (640×360), spots and point lights at the camera, above the "
        "model and beyond it, `samples` fit; 1024² texels a spot or a side of a point light's cube, *four maps*: a spot's parted into "
        "4 × 512²; wrong %.\n\n"
        + table(("light", *methods), [*lines, ("**mean**", *total)])
        + "\n\n"
        + table(("method", "acne %", "worst", "leak %", "worst"), flaws)
    )


def spread(rows: list[Row], key: str) -> tuple[float, float]:
    """Mean and largest of a column."""
    return mean(rows, key), max(getattr(row, key) for row in rows if getattr(row, key) is not None)


SECTIONS = {
    "first-light-warp": first_light_warp,
    "first-light-fit": first_light_fit,
    "methods": methods,
    "texels": texels,
    "bias": bias,
    "exact": exact,
    "lamps": lamps,
}
READERS = {"texels": read_texels}


def write(page: Path, results: Path, machine: str) -> None:
    """The page from the rows that are there."""
    parts = [INTRO]
    for name, section in SECTIONS.items():
        path = results / f"{name}.jsonl"
        if path.is_file() and (rows := READERS.get(name, read)(path)):
            parts.append(section(rows))
        else:
            parts.append(f"*Not measured yet: `{name}`.*")
    parts.append(f"---\nMeasured with {machine}; OpenGL on the CPU (Mesa llvmpipe) unless said otherwise.\n")
    page.parent.mkdir(parents=True, exist_ok=True)
    page.write_text("\n\n".join(parts), encoding="utf-8")
