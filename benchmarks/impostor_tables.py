"""The impostor benchmark's rows → docs/impostors.md."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from addon.maths.relief.error import PREDICTORS
from benchmarks.tables import table

RESULTS = Path(__file__).resolve().parent / "results"
DOC = Path(__file__).resolve().parents[1] / "docs" / "impostors.md"
HOLE_PX = 200.0
DRAWN = "triangles followed"
"""How impostors are drawn when a row is measured: it is kept with the row."""
UNTOUCHED = ("predictors", "shadows", "speed")
"""Tables that say the same whichever way impostors are shaded."""
EARLIER = (
    "*Measured (or some of its rows) while impostors were shaded on their texels' own planes, without following the ray to the triangle "
    "that it meets: pictures are nearer to the geometry now.*"
)
INTRO = """# Relief impostors, measured

Made by `python -m benchmarks.impostors` (see its help); do not edit. Models: the dev set, each as one impostor. Software
rasteriser. What was found is in [the laboratory's log](laboratory.md), *Impostors*.
"""


def keep(name: str, rows: list[dict]) -> None:
    """Write rows of one table, replacing those of the same models (and distances)."""
    new = {(row.get("model"), row.get("radii")) for row in rows}
    rest = [row for row in kept(name) if (row.get("model"), row.get("radii")) not in new]
    RESULTS.mkdir(exist_ok=True)
    rows = [row | {"drawn": DRAWN} for row in rows]
    (RESULTS / f"impostors-{name}.json").write_text(json.dumps(rest + rows, indent=0) + "\n", encoding="utf-8")


def kept(name: str) -> list[dict]:
    """The rows of one table, if it was measured."""
    path = RESULTS / f"impostors-{name}.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else []


def write() -> None:
    """docs/impostors.md from all that was measured."""
    parts = [INTRO]
    makers = {
        "predictors": _predictors,
        "rest": _rest,
        "pictures": _pictures,
        "orbit": _orbit,
        "elsewhere": _elsewhere,
        "life": _life,
        "shadows": _shadows,
        "limits": _limits,
        "approach": _approach,
        "pay": _pay,
        "speed": _speed,
    }
    for name, make in makers.items():
        rows = kept(name)
        parts.append(make(rows) if rows else f"(`{name}` was not measured.)")
        if rows and name not in UNTOUCHED and any(row.get("drawn") != DRAWN for row in rows):
            parts.append(EARLIER)
    DOC.write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def _ranks(values: np.ndarray) -> np.ndarray:
    """Ranks with ties shared."""
    _, inverse, counts = np.unique(values, return_inverse=True, return_counts=True)
    ends = np.cumsum(counts)
    return (ends - (counts - 1) / 2.0)[inverse]


def _spearman(a: np.ndarray, b: np.ndarray) -> float:
    ranks = _ranks(a), _ranks(b)
    return float(np.corrcoef(*ranks)[0, 1]) if min(np.ptp(r) for r in ranks) > 0 else 0.0


def _balanced_accuracy(values: np.ndarray, truth: np.ndarray) -> float:
    """The best over all thresholds of the mean of sensitivity and specificity for 'more than `HOLE_PX` pixels unseen'."""
    bad = truth > HOLE_PX
    if bad.all() or not bad.any():
        return float("nan")
    order = np.argsort(values)
    above = np.concatenate([[bad.sum()], bad.sum() - np.cumsum(bad[order])]) / bad.sum()
    below = np.concatenate([[0], np.cumsum(~bad[order])]) / (~bad).sum()
    return float(((above + below) / 2).max())


def _predictors(rows: list[dict]) -> str:
    rows = [r for r in rows if np.isfinite(r["edge_sum_px"])]
    models = list(dict.fromkeys(r["model"] for r in rows))
    truth = np.array([r["truth"] for r in rows])
    of_model = np.array([r["model"] for r in rows])
    lines = []
    for name in (n for n in PREDICTORS if all(n in r for r in rows)):
        values = np.array([r[name] for r in rows])
        single = [_spearman(values[of_model == m], truth[of_model == m]) for m in models]
        over = np.median(values[truth > 20] / truth[truth > 20]) if name.endswith("sum_px") or name.startswith("edge_") else None
        lines.append(
            (
                name,
                float(np.median(single)),
                min(single),
                max(single),
                _spearman(values, truth),
                _balanced_accuracy(values, truth),
                None if over is None else float(over),
            )
        )
    return (
        f"## Predictors against truth\n\n{len(models)} models × {len(rows) // len(models)} cameras (0…35°, 3…14 radii, capture at 8), "
        "truth = pixels of the true picture whose surface the capture's front layer does not hold. Rank correlation per model and "
        f"pooled; balanced accuracy of telling more than {HOLE_PX:.0f} such pixels, at the best threshold; over-estimate = median of "
        "predicted over true pixels.\n\n"
        + table(("predictor", "rank, median", "worst", "best", "pooled", "balanced accuracy", "over-estimate"), lines)
    )


def _rest(rows: list[dict]) -> str:
    tests, eyes = (list(dict.fromkeys(of(r) for r in rows)) for of in (lambda r: r["test"], lambda r: tuple(r["eye"])))
    of = {(r["model"], r["test"], tuple(r["eye"])): r["psnr_db"] for r in rows}
    lines = []
    for model in dict.fromkeys(r["model"] for r in rows):
        lines.append((model, *(f"{np.median(q):.1f} / {min(q):.1f}" for q in ([of[model, t, e] for e in eyes] for t in tests))))
    every = [[r["psnr_db"] for r in rows if r["test"] == test] for test in tests]
    lines.append(("all", *(f"{np.median(q):.1f} / {min(q):.1f}" for q in every)))
    return (
        f"## At the capture's own eye\n\n192² pixels of 2 × 2 samples, a texel a sample, shadows, {len(eyes)} eyes round each model at "
        f"{min(e[2] for e in eyes):g} to {max(e[2] for e in eyes):g} radii; PSNR dB over both silhouettes, median / least, by shadow "
        "test (99 = equal).\n\n" + table(("model", *tests), lines)
    )


def _pictures(rows: list[dict]) -> str:
    lit = "with" if all(row.get("drawn") == DRAWN for row in rows) else "without"
    parts = [
        f"## Pictures\n\n240² pixels, 4 × 4 samples, two texels a pixel, {lit} shadows; medians over the models. PSNR and SSIM over the "
        "union of the silhouettes. Two captures: the eye in the middle between them, each that angle away."
    ]
    for radii in sorted({r["radii"] for r in rows}):
        lines = []
        for way in dict.fromkeys(r["way"] for r in rows):
            cells = []
            for angle in sorted({r["angle"] for r in rows}):
                chosen = [r for r in rows if (r["way"], r["radii"], r["angle"]) == (way, radii, angle)]
                db, iou = (float(np.median([r[k] for r in chosen])) for k in ("psnr_db", "silhouette_iou"))
                ssim, missing, false = (float(np.median([r[k] for r in chosen])) for k in ("ssim", "missing_pct", "false_pct"))
                cells.append(f"{db:.1f} / {ssim:.2f} / {iou:.3f} / {missing:.1f} / {false:.1f}")
            models = len({r["model"] for r in rows if (r["way"], r["radii"]) == (way, radii)})
            lines.append((way, models, *cells))
        angles = [f"{a}°" for a in sorted({r["angle"] for r in rows})]
        parts.append(f"{radii:g} radii: PSNR dB / SSIM / silhouette IoU / missing % / false %\n\n" + table(("", "models", *angles), lines))
    return "\n\n".join(parts)


def _life(rows: list[dict]) -> str:
    lines = []
    for way in dict.fromkeys(r["way"] for r in rows):
        chosen = [r for r in rows if r["way"] == way]
        lived = [r["frames"] / max(r["captures"], 1) for r in chosen]
        jumps = [r["jump"] for r in chosen if r["jump"] is not None]
        against = [degrees / r["sprite_deg"] for degrees, r in zip(lived, chosen, strict=True)]
        median, worst = float(np.median([r["psnr_median"] for r in chosen])), min(r["psnr_min"] for r in chosen)
        largest = float(max(jumps)) if jumps else None
        lines.append(
            (
                way,
                float(np.median(lived)),
                min(lived),
                float(np.median(against)),
                min(against),
                median,
                worst,
                largest,
                sum(r["geometry"] for r in chosen),
            )
        )
    head = (
        "life cycle",
        "degrees per capture, median",
        "fewest",
        "× sprite, median",
        "least",
        "PSNR, median",
        "PSNR, worst",
        "largest jump",
        "geometry frames",
    )
    return (
        f"## Life\n\nThe first {min(r['frames'] for r in rows)} frames of these orbits under other life cycles, "
        f"{len({r['model'] for r in rows})} models; degrees "
        "(= frames) per capture, and over the degrees that a sprite lives by Schaufler's β; worst frame over all models; largest jump = "
        "the frame difference at a renewal over the median frame difference.\n\n" + table(head, lines)
    )


def _orbit(rows: list[dict]) -> str:
    return (
        f"## Orbits\n\n{max(r['frames'] for r in rows)} frames at 1° round each model, 8 radii, with shadows, the default life cycle, 192² "
        "pixels of 2 × 2 samples, a texel a sample; all captures, those too that were thrown away; PSNR over both silhouettes "
        "(99 = equal). Jump: the largest frame difference at "
        "a renewal over the median frame difference; true jump: the largest of the geometry's own over their median. An object finer "
        "than its texels is drawn as geometry and looked at again from every 15°.\n\n" + _orbits(rows)
    )


def _elsewhere(rows: list[dict]) -> str:
    return (
        "## Elsewhere\n\nThe weights and the limit of the predicted error were chosen by the orbits above. "
        f"{max(r['frames'] for r in rows)} frames at 1° of another, at 5 radii from 50° above.\n\n" + _orbits(rows)
    )


def _orbits(rows: list[dict]) -> str:
    lines = [
        (
            r["model"],
            r["captures"],
            r["geometry"],
            r["frames"] / max(r["captures"], 1) / r["sprite_deg"] if r["captures"] > r["geometry"] / 10 else None,
            r["psnr_median"],
            r["psnr_min"],
            r["below_26"],
            r["jump"],
            r["true_jump"],
        )
        for r in rows
    ]
    head = ("model", "captures", "as geometry", "life × sprite's", "PSNR, median", "PSNR, worst", "below 26 dB", "jump", "true jump")
    return table(head, lines)


def _shadows(rows: list[dict]) -> str:
    lines = []
    for model in dict.fromkeys(r["model"] for r in rows):
        floor, dark, wrong = (sum(r[k] for r in rows if r["model"] == model) for k in ("floor", "dark", "wrong"))
        lines.append((model, 100.0 * dark / floor, 100.0 * wrong / floor, 100.0 * wrong / max(dark, 1)))
    return (
        "## Shadows cast by impostors\n\nA floor under each model, a sun, a map of 1024², four sides at 5 radii; captured from the "
        "sun against the triangles in the same map. Misclassified: pixels of the floor lit in one picture and dark in the other.\n\n"
        + table(("model", "floor in shadow %", "misclassified %", "of the shadow %"), lines)
    )


def _limits(rows: list[dict]) -> str:
    shown = [r for r in rows if "psnr_db" in r]
    lines = []
    for path in (*dict.fromkeys(r["path"] for r in rows), "all"):
        of = [r for r in rows if path in (r["path"], "all")]
        drawn = [r for r in of if "psnr_db" in r]
        quality, wrong = (np.array([r[key] for r in drawn]) for key in ("psnr_db", "wrong"))
        over = float(100.0 * np.mean(wrong > drawn[0]["limit"]))
        share = 100.0 * len(drawn) / len(of)
        captures = sum(r["captures"] for r in of)
        lines.append((path, len(of), share, captures, float(np.median(quality)), float(quality.min()), int((quality < 26.0).sum()), over))
    squared = np.array([10.0 ** (-r["psnr_db"] / 10.0) for r in shown])
    rank = _spearman(np.array([r["predicted"] for r in shown]), squared)
    models = len({r["model"] for r in rows})
    head = ("path", "frames", "as impostors %", "captures", "PSNR, median", "PSNR, worst", "below 26 dB", "over the limit %")
    return (
        f"## Limits\n\n{models} models, {max(r['frame'] for r in rows) + 1} frames a path, 96² pixels of 4 camera samples, two texels a "
        "pixel, shadows of the exact test, the default life cycle: 1.5° a frame at 6 radii; from 16 to 2.5 radii; back; nearer while "
        "turning 2° a frame. Over the limit: frames of which a larger share of the pixels (of both silhouettes) than the limit of "
        f"{100.0 * rows[0]['limit']:.2f} % is wrong, by more than 0.15 in one colour. Rank correlation of the predicted error with the "
        f"squared error of the picture, pooled: {rank:.2f}.\n\n" + table(head, lines)
    )


def _approach(rows: list[dict]) -> str:
    pair = "{:.1f} ({:.1f})".format
    lines = []
    for r in rows:
        took = (pair(r["anew_ms"], r["anew_cpu_ms"]), pair(r["carried_ms"], r["carried_cpu_ms"])) if r["carried"] else (None, None)
        opened = "{:.2f} / {:.2f} ({:.2f})".format(*r["opened_pct"], r["apart_pct"]) if r["carried"] else None
        lines.append((r["model"], r["captures"], r["carried"], *took, opened, r["psnr_min"], r["captures_anew"], r["psnr_min_anew"]))
    head = (
        "model",
        "captures",
        "edges carried over",
        "ms, all anew",
        "ms, carried over",
        "% opened, carried over / anew (most apart)",
        "PSNR, worst",
        "captures, all anew",
        "PSNR, worst, all anew",
    )
    return (
        f"## Approach\n\n{max(r['frames'] for r in rows)} frames from 16 to 3 radii, 192² pixels of 2 × 2 samples, the default life "
        "cycle. A capture from nearer carries the edges that the predictors need over from the last one instead of gathering them anew. "
        "Milliseconds per such capture, made again both ways in turn (in brackets processor time of all threads); what either's edges "
        "predict 5 and 10° aside, medians. The last columns: the same film with everything gathered anew.\n\n" + table(head, lines)
    )


def _pay(rows: list[dict]) -> str:
    pair, frames = "{:.0f} ({:.0f})".format, rows[0]["frames"]
    lines = []
    for r in rows:
        ways = [
            (pair(r[f"{w}_ms"], r[f"{w}_cpu_ms"]), r[f"{w}_cpu_ms"] / r["geometry_cpu_ms"], r[f"{w}_impostors"]) for w in ("view", "fresh")
        ]
        lines.append((r["triangles"], pair(r["geometry_ms"], r["geometry_cpu_ms"]), *ways[0], *ways[1]))
    head = ("triangles", "geometry, ms", "view, ms", "÷ geometry", "as impostor", "final renders, ms", "÷ geometry", "as impostor")
    return (
        f"## Do they pay?\n\nA ball, whole pictures of 256² pixels and 4 camera samples, exact shadows, {frames} pictures half a "
        "degree apart, the first two not counted; in brackets processor time of all threads, which the shares are of. With the break-even "
        "as it is by default: a view that moves, whose costs are measured, and final renders, which capture anew in each picture.\n\n"
        + table(head, lines)
    )


def _speed(rows: list[dict]) -> str:
    pair = "{:.1f} ({:.1f})".format
    lines = [
        (
            r["triangles"],
            r["texture"],
            pair(r["geometry_ms"], r["geometry_cpu_ms"]),
            pair(r["impostor_ms"], r["impostor_cpu_ms"]),
            f"1/{r['geometry_ms'] / r['impostor_ms']:.1f} (1/{r['geometry_cpu_ms'] / r['impostor_cpu_ms']:.1f})",
            r["capture_ms"],
            pair(r["predict_200_ms"], r["predict_200_cpu_ms"]),
        )
        for r in rows
    ]
    return (
        "## Speed\n\nA ball, the G-buffer pass at 512², the impostor seen 10° from its capture; drawn in turn, medians, ms; in brackets "
        "processor time of all threads, which other programs on the machine disturb less.\n\n"
        + table(("triangles", "texture", "geometry", "impostor", "share", "capture", "200 predictions"), lines)
    )
