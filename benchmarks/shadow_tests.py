"""Costs and pictures of the shadow tests: `python -m benchmarks.shadow_tests` writes docs/shadow_tests.md and its pictures.

Quality against ray-traced truth is in docs/quality.md (`python -m benchmarks.quality bias`, `… exact`).
Times are the least of several interleaved runs of one pass, waited for; CPU time of the process, so that a busy machine does not count.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import chain, repeat
from pathlib import Path

import moderngl
import numpy as np

from addon.images.png import encode_png
from addon.maths import shadow_tests as definition
from addon.maths.view import Camera, Light
from addon.pipeline.device import device_of
from addon.pipeline.gbuffer_pass import surface_points_ws
from addon.pipeline.renderer import Renderer
from addon.pipeline.scene import Scene
from addon.pipeline.settings import Settings
from addon.pipeline.shadow_pass import ShadowMaps, draw_shadow_maps
from benchmarks.models import load
from benchmarks.tables import table
from benchmarks.views import views
from tests import scenes

INTRO = """# Shadow tests

Made by `python -m benchmarks.shadow_tests`; do not edit. Misclassified pixels, acne and leaks of each test are in
[quality](quality.md).

**Depth.** The occluder in the map is put back into the world and its height over the receiver's exact plane decides.
Automatic bias needs no number: it is the float noise, a step of the depth format at that place of the warped map, and a
share of the texel's tilt. At the foot of something low, where one of the four cells round a place shows the receiver's
own plane and the nearest something less than three texels above it, the map cannot tell the lit side from the dark one:
such a place is lit, so that no dark dots lie along lit creases. The other strategies (constant, slope-scaled,
normal-offset, receiver-plane) compare depths along the ray with the bias given.

**ID + depth** (IDD). Dark iff the difference exceeds ε_far, or the ids differ and it exceeds ε. Automatic: ε is the
bias above; ε_far is what a surface can rise within a texel, at most the object's own extent along the light.

**Triangle-exact** (method §8). The map says which triangles are near the ray, the ray itself decides. From each triangle
stored in the 3×3 cells round the place the surface is followed over its edges towards the ray, to the triangle that
holds it or to where the surface ends or folds back: slivers that never won a texel are found all the same. Where the
surface cannot be followed (an edge with more than two triangles, more than 64 steps) the nearest cell's depth decides;
where everything stored near the ray stands far above the receiver it is dark.

**n-SM** (SMMVP §4.5). A cell keeps n depths, its own and n − 1 of its neighbours'; every depth is compared at the place
it was stored.

**Filter.** k taps, a texel apart, or over a width in pixels or in metres across the light, which does not change with
warp and partition.
"""
DOCS = Path(__file__).resolve().parents[1] / "docs"
SIZE, MAP = (640, 360), 1024
CAMERA = scenes.look_at((1.1, -1.5, 1.1), (0.0, 0.05, 0.25), near=0.2, far=20.0)
SUN = scenes.sun(42.0, -20.0)
NEAR, FAR = 0.004, 0.12
FILTERS = ((4, 3), (9, 1), (9, 2), (16, 1))
SHADINGS = ((1, 1), (4, 1), (9, 1), (16, 1), (25, 1), (4, 2), (4, 3), (9, 2), (4, 4), (4, 8))


def settings(size: int = MAP, **test: object) -> Settings:
    """One map, generalised LiSPSM."""
    return Settings().replaced(partition={"kind": "none"}, fit={"size": size}, test=test, shading={"samples": 1})


@dataclass
class Cost:
    """Least CPU milliseconds so far of the map pass (without the n-SM's selection), of that selection, and of shading."""

    map_ms: float = math.inf
    select_ms: float = math.inf
    shade_ms: float = math.inf


def cpu_ms(job: Callable[[], None]) -> float:
    """CPU milliseconds of `job`, of all threads, so that other processes do not count."""
    begin = time.process_time()
    job()
    return 1e3 * (time.process_time() - begin)


def least_costs(
    renderer: Renderer, scene: Scene, camera: Camera, light: Light, tests: Mapping[str, Settings], draw_each_round: bool, rounds: int = 5
) -> dict[str, Cost]:
    """The cost of every test, round by round and not one after the other, so that a slow minute of the machine strikes all alike."""
    plan = renderer.render(scene, camera, light, settings(), SIZE, ("combined",), measure=False).plan

    def measured(context: moderngl.Context) -> dict[str, Cost]:
        device = device_of(context, renderer.worker)
        draw_list, gbuffer, target = device.store.sync(scene), device.gbuffer(SIZE), device.shade_target(SIZE, False)
        triangles = device.triangles(linked=True)
        maps = {name: ShadowMaps(context, MAP, len(plan.projections), chosen.test) for name, chosen in tests.items()}

        def draw(name: str) -> None:
            cells, maps[name].cells = maps[name].cells, None
            draw_shadow_maps(context, device.programs, maps[name], draw_list, plan, tests[name].test)
            maps[name].cells = cells
            context.finish()

        def select(name: str) -> None:
            maps[name].cells.select(device.programs, maps[name].depth, plan)
            context.finish()

        def shade(name: str) -> None:
            device.shade_pass.draw(target, gbuffer, maps[name], draw_list, triangles, camera, light, plan, tests[name])
            context.finish()

        out = {name: Cost() for name in tests}
        for name, cost in chain.from_iterable(repeat(tuple(out.items()), rounds)):
            if draw_each_round or cost.map_ms == math.inf:
                cost.map_ms = min(cost.map_ms, cpu_ms(partial(draw, name)))
            if maps[name].cells is not None:
                cost.select_ms = min(cost.select_ms, cpu_ms(partial(select, name)))
            cost.shade_ms = min(cost.shade_ms, cpu_ms(partial(shade, name)))
        device.unbind()
        for each in maps.values():
            each.release()
        return out

    return renderer.worker.call(measured)


def costs(renderer: Renderer) -> str:
    """Map and shading passes by test and filter on the deck, and both sides of SMMVP (5.6), (5.7)."""
    scene = load("deck")
    view, light = views("deck", scene)[0], scenes.sun(40.0, 60.0)
    kinds = {kind: settings(kind=kind) for kind in ("depth", "id-depth", "triangle")}
    kinds["triangle, PCF 9"] = settings(kind="triangle", pcf=9)
    tests = least_costs(renderer, scene, view.camera, light, kinds, draw_each_round=True)
    filters = {name_of(k, n): settings(pcf=k, depths=n) for k, n in SHADINGS}
    times = least_costs(renderer, scene, view.camera, light, filters, draw_each_round=False)
    one, nine, depth_map = times[name_of(1, 1)].shade_ms, times[name_of(9, 1)].shade_ms, tests["depth"].map_ms
    rows = [(name, c.map_ms, c.map_ms / depth_map, c.shade_ms, c.shade_ms / one, c.shade_ms / nine) for name, c in tests.items()]
    text = (
        "## Costs\n\nDeck (500 thousand triangles), one 1024² map, 640×360, CPU rasteriser; CPU milliseconds of all threads, least of 5 "
        f"interleaved rounds. Wanted: ID + depth map pass ≤ 1.25 × depth only (**{tests['id-depth'].map_ms / depth_map:.2f}**), "
        f"PCF(9,1) shading ≤ 1.6 × PCF(1,1) (**{nine / one:.2f}**).\n\n"
        + table(("test", "map pass", "× depth only", "shading", "× PCF(1,1)", "× PCF(9,1)"), rows)
    )
    rows = [
        (name_of(k, n), times[name_of(k, n)].select_ms if n > 1 else None, times[name_of(k, n)].shade_ms,
         times[name_of(k, n)].shade_ms / one, n * k + 1)
        for k, n in SHADINGS
    ]
    text += "\n\n" + table(("filter", "selection pass", "shading", "× PCF(1,1)", "levels n·k+1"), rows)
    return text + "\n\n" + break_even(times)


def name_of(k: int, n: int) -> str:
    """PCF(k,n)."""
    return f"PCF({k},{n})"


def break_even(times: Mapping[str, Cost]) -> str:
    """SMMVP's inequality against the clock: the n-SM pays when selection costs less than the larger filter's surplus."""
    lines = []
    for (k, n), larger in (((4, 2), 9), ((4, 3), 9), ((9, 2), 16)):
        mine, other = times[name_of(k, n)], times[name_of(larger, 1)]
        surplus = other.shade_ms - mine.shade_ms
        r, q = larger - k, 9
        ratio = SIZE[0] * SIZE[1] / MAP**2
        measured = mine.select_ms / surplus * ratio if surplus > 0.0 else None
        verdict = "cheaper" if mine.select_ms < surplus else "dearer"
        lines.append((f"{name_of(k, n)} for {name_of(larger, 1)}", f"{ratio:.2f}", q / r, measured, verdict))
    return (
        "The n-SM is the cheaper way to a larger filter when λ_h λ_w (picture's pixels over map's texels) > q/r (5.7), in texture reads; "
        "measured: the ratio at which the times are equal (– : the n-SM's shading alone is slower).\n\n"
        + table(("n-SM", "λ_h λ_w here", "q/r", "measured break-even", "here the n-SM is"), lines)
    )


def receivers(renderer: Renderer, frame: object, chosen: Settings) -> tuple[np.ndarray, definition.Receivers]:
    """Mask (h, w) of the lit-facing pixels of a frame and their `Receivers`."""
    depth = np.where(np.isfinite(frame.passes["depth"]), frame.passes["depth"], 0.0)[::-1]
    points = np.zeros((*depth.shape, 3))
    points[depth > 0.0] = surface_points_ws(np.ascontiguousarray(depth, dtype=np.float32), CAMERA)
    points, normals = points[::-1], frame.passes["normal"].astype(np.float64)
    chosen_pixels = (frame.passes["object"] >= 0) & (normals @ SUN.direction_ws > 0.05)
    r = definition.Receivers(
        frame.plan.projections[0],
        SUN,
        chosen.fit.size,
        points[chosen_pixels],
        normals[chosen_pixels],
        frame.passes["object"][chosen_pixels],
    )
    return chosen_pixels, r


def levels_across(levels: np.ndarray, most: int) -> float:
    """Mean number of different levels between dark and lit that a row of the picture shows where it crosses an edge from one to the other.

    `levels` (h, w) int, 0 dark … `most` lit.
    """
    counts = []
    for row in levels:
        partly = np.flatnonzero((row > 0) & (row < most))
        for run in np.split(partly, np.flatnonzero(np.diff(partly) > 1) + 1):
            if len(run) and run[0] > 0 and run[-1] + 1 < len(row) and {row[run[0] - 1], row[run[-1] + 1]} == {0, most}:
                counts.append(len(np.unique(row[run])))
    return float(np.mean(counts))


def smooth_edges(renderer: Renderer) -> str:
    """SMMVP's pictures: PCF(4,3) against PCF(9,1) and PCF(9,2) against PCF(16,1), with levels and error against 64 taps."""
    scene, crops, lines = scenes.chair(), [], []
    for k, n in FILTERS:
        chosen = settings(256, pcf=k, depths=n, bias_strategy="receiver-plane")
        frame = renderer.render(scene, CAMERA, SUN, chosen, SIZE, ("shadow", "depth", "normal", "object", "texel"))
        seen, r = receivers(renderer, frame, chosen)
        width = {(4, 3): 3.0, (9, 1): 3.0}.get((k, n), 4.0)
        depth = frame.passes["shadow_depth"][0].astype(np.float64) * 2.0 - 1.0
        cells = definition.tap_cells(r.texels(), 8, width / 8.0)
        heights = r.heights_m(cells, definition.cell_values(depth, cells))
        reference = definition.filtered((heights <= 0.5 * r.footprint_m()[:, None])[..., None])
        shadow = frame.passes["shadow"][seen]
        edge = (reference > 0.0) & (reference < 1.0)
        error = float(np.sqrt(np.mean((shadow[edge] - reference[edge]) ** 2)))
        levels = np.where(seen, np.round(frame.passes["shadow"] * n * k), 0).astype(int)
        lines.append((name_of(k, n), k, n * k + 1, len(np.unique(levels[seen])), levels_across(levels, n * k), error))
        crops.append(frame.passes["shadow"][140:230, 215:335])
    strip = np.concatenate([np.pad(np.kron(c, np.ones((4, 4))), ((0, 0), (0, 8)), constant_values=1.0) for c in crops], axis=1)
    write_png("tests_smmvp.png", np.repeat(strip[..., None], 3, axis=-1))
    return (
        "## Smooth edges: n-SM against larger filters\n\nChair, one 256² map (coarse on purpose). Error: root mean square against "
        "64 taps over 3 (4) texels of the same map, on the pixels that those find half lit. "
        "Across: levels between dark and lit where a row of the picture crosses an edge. "
        "Left to right: PCF(4,3), PCF(9,1), PCF(9,2), PCF(16,1).\n\n"
        "![edges](img/tests_smmvp.png)\n\n" + table(("filter", "map reads", "levels possible", "levels found", "across", "error"), lines)
    )


def chair_zones(renderer: Renderer) -> str:
    """IDD's figure 4: which line of the table in §5.5 decides each pixel."""
    scene = scenes.chair()
    chosen = settings(2048, kind="id-depth", epsilon=NEAR, epsilon_far=FAR)
    frame = renderer.render(scene, CAMERA, SUN, chosen, SIZE, ("combined", "shadow", "depth", "normal", "object", "texel"))
    seen, r = receivers(renderer, frame, chosen)
    depth = frame.passes["shadow_depth"][0].astype(np.float64) * 2.0 - 1.0
    cells = definition.tap_cells(r.texels(), 1)
    difference = r.distances_m(definition.cell_values(depth, cells))[:, 0]
    dark = frame.passes["shadow"][seen] < 0.5
    zones = np.stack(
        [difference > FAR, (difference > NEAR) & (difference <= FAR) & dark, (difference > NEAR) & (difference <= FAR) & ~dark]
    )
    picture = np.clip(frame.passes["combined"][..., :3], 0.0, 1.0) ** (1.0 / 2.2)
    painted = np.full((*seen.shape, 3), 0.92)
    painted[seen] = 0.8
    for zone, color in zip(zones, ((0.15, 0.25, 0.6), (0.85, 0.35, 0.1), (0.3, 0.65, 0.35)), strict=True):
        mask = seen.copy()
        mask[seen] = zone
        painted[mask] = color
    write_png("tests_idd_chair.png", np.concatenate([picture, painted], axis=1))
    counts = [int(z.sum()) for z in zones]
    return (
        f"## ID + depth: the three zones\n\nε = {1e3 * NEAR:.0f} mm, ε_far = {1e3 * FAR:.0f} mm, as in IDD §5.5. Blue: difference > ε_far, "
        f"always dark ({counts[0]} pixels). Orange: between, another object's shadow ({counts[1]}). Green: between, the same object's, lit "
        f"({counts[2]}). Grey: ≤ ε, never dark.\n\n![zones](img/tests_idd_chair.png)"
    )


def write_png(name: str, image: np.ndarray) -> None:
    """A picture (h, w, 3) 0…1 into docs/img."""
    (DOCS / "img" / name).write_bytes(encode_png(np.round(np.clip(image, 0.0, 1.0) * 255.0).astype(np.uint8)))


def main() -> None:
    """Measure, paint, write the page."""
    renderer = Renderer()
    parts = [make(renderer) for make in (chair_zones, smooth_edges, costs)]
    (DOCS / "shadow_tests.md").write_text("\n\n".join((INTRO, *parts)) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
