"""Costs and pictures of the shadow tests: `python -m benchmarks.shadowing` writes docs/shadow_tests.md and its pictures.

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
from addon.maths.view import Camera, Light
from addon.pipeline.device import device_of
from addon.pipeline.job import Job
from addon.pipeline.passes.shadow import ShadowMaps, draw_shadow_maps
from addon.pipeline.renderer import Renderer
from addon.scene.records import Scene
from addon.settings.groups import Settings
from addon.studies.run import run
from benchmarks.models import load
from benchmarks.smooth_edges import chair_edges, name_of, receivers, straight_edges
from benchmarks.tables import table
from benchmarks.views import views
from tests import scenes
from tests.pipeline import shadow_definition as definition

INTRO = """# Shadow tests

Made by `python -m benchmarks.shadowing`; do not edit. Misclassified pixels, acne and leaks of each test are in
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
where everything stored near the ray stands far above the receiver it is dark. With `outlines` all casters are drawn once
more as lines, and the triangles whose edges cross the nine cells are started from, too: wires that cover no texel's centre.

**n-SM** (SMMVP §4.5). A cell keeps n depths, its own and n − 1 of its neighbours'; every depth is compared at the place
it was stored.

**Filter.** k taps, a texel apart, or over a width in pixels or in metres across the light, which does not change with
warp and partition. The taps lie on the receiver's plane; one that nobody sees there, inside a wall at whose foot the
receiver lies or beyond an edge, counts as the receiver's own place (`python -m benchmarks.filters` measures
rims). With limits given by hand it counts itself.
"""
DOCS = Path(__file__).resolve().parents[1] / "docs"
SIZE, MAP = (640, 360), 1024
CAMERA = scenes.look_at((1.1, -1.5, 1.1), (0.0, 0.05, 0.25), near=0.2, far=20.0)
SUN = scenes.sun(42.0, -20.0)
SMALL_MAP = 256
NEAR, FAR = 0.004, 0.12
RIVALS = {("PCF(4,2)", "PCF(9,1)"): 9 / 5, ("PCF(4,3)", "PCF(9,1)"): 9 / 5, ("PCF(9,2)", "PCF(16,1)"): 9 / 7}
"""What SMMVP compares, and q/r: cells read to select a cell's depths, over the filter's reads that are saved."""
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
    renderer: Renderer,
    scene: Scene,
    camera: Camera,
    light: Light,
    tests: Mapping[str, Settings],
    draw_each_round: bool,
    size: int = MAP,
    rounds: int = 5,
) -> dict[str, Cost]:
    """The cost of every test with a map of `size` texels, round by round and not one after the other, so that a slow minute of the machine
    strikes all alike."""
    plan = run(Job(scene, camera, light, settings(size), SIZE, ("combined",), measure=False), on=renderer).frame.plan

    def measured(context: moderngl.Context) -> dict[str, Cost]:
        device = device_of(context, renderer.worker)
        draw_list, gbuffer, target = device.store.sync(scene), device.gbuffer(SIZE), device.shade_target(SIZE, False)
        triangles = device.triangles(linked=True)
        maps = {name: ShadowMaps(context, size, len(plan.projections), chosen.test) for name, chosen in tests.items()}

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
    kinds["triangle, outlines"] = settings(kind="triangle", outlines=True)
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
        (
            name_of(k, n),
            times[name_of(k, n)].select_ms if n > 1 else None,
            times[name_of(k, n)].shade_ms,
            times[name_of(k, n)].shade_ms / one,
            n * k + 1,
        )
        for k, n in SHADINGS
    ]
    text += "\n\n" + table(("filter", "selection pass", "shading", "× PCF(1,1)", "levels n·k+1"), rows)
    compared = {name: chosen for name, chosen in filters.items() if any(name in pair for pair in RIVALS)}
    small = least_costs(renderer, scene, view.camera, light, compared, draw_each_round=False, size=SMALL_MAP)
    return text + "\n\n" + break_even({MAP: times, SMALL_MAP: small})


def break_even(times: Mapping[int, Mapping[str, Cost]]) -> str:
    """SMMVP's inequality against the clock: the n-SM pays when selection costs less than the larger filter's surplus. `times` by
    map size."""
    lines = []
    for size, costs_there in times.items():
        ratio = SIZE[0] * SIZE[1] / size**2
        for (mine, other), reads in RIVALS.items():
            n_sm, larger = costs_there[mine], costs_there[other]
            surplus = larger.shade_ms - n_sm.shade_ms
            measured = n_sm.select_ms / surplus * ratio if surplus > 0.0 else None
            whole = n_sm.select_ms + n_sm.shade_ms
            verdict = "cheaper" if whole < larger.shade_ms else "dearer"
            lines.append(
                (
                    f"{mine} for {other}",
                    f"{size}²",
                    ratio,
                    reads,
                    "n-SM" if ratio > reads else "larger filter",
                    whole,
                    larger.shade_ms,
                    measured,
                    verdict,
                )
            )
    return (
        "The n-SM is the cheaper way to a larger filter when λ_h λ_w (picture's pixels over map's texels) > q/r, counted in texture reads "
        "((5.6), (5.7)). On both sides of it, milliseconds of selection and shading together, and the ratio at which the times would be "
        "equal (– : the n-SM's shading alone is slower).\n\n"
        + table(
            (
                "n-SM",
                "map",
                "λ_h λ_w",
                "q/r",
                "by (5.7) cheaper",
                "n-SM ms",
                "larger filter ms",
                "measured break-even",
                "measured: n-SM is",
            ),
            lines,
        )
    )


def smooth_edges(renderer: Renderer) -> str:
    """SMMVP's pictures: PCF(4,3) against PCF(9,1) and PCF(9,2) against PCF(16,1), by levels across an edge and error against 64 taps."""
    lines, strip = chair_edges(renderer, CAMERA, SUN)
    write_png("tests_smmvp.png", strip)
    return (
        "## Smooth edges: n-SM against larger filters\n\n**A straight edge**, turned by 8° to 63°, one uniform 256² map (a texel is some "
        "pixels). *Ramp*: texels over which the filter goes from dark to lit, its taps and what an n-SM cell sees beyond itself. *Across*: "
        "levels between dark and lit where a row of the picture crosses the edge. *Error*: root mean square against 64 taps over as many "
        "texels as the ramp, within four texels of the edge. *Drift*: texels by which the edge stands too far on the dark side; "
        "*moved*: the error when the 64 taps are moved by as much.\n\n"
        + table(
            ("filter", "map reads", "ramp", "levels possible", "across", "error", "drift", "moved"),
            [(name, name[4:].split(",")[0], *line) for name, *line in straight_edges(renderer)],
        )
        + "\n\nPCF(9,2) is as smooth as PCF(16,1), and PCF(4,3) smoother than PCF(9,1), as SMMVP §5.1 shows. But a 2-SM keeps the "
        "*largest* depth round each cell: its edges stand half a texel (across a diagonal more) inside the shadow, and shadows a texel "
        "wide fade. A 3-SM keeps the smallest as well and stays in place.\n\n**The chair**, one 256² map (coarse on purpose); error on the "
        "pixels that 64 taps find half lit. Left to right: PCF(4,3), PCF(9,1), PCF(9,2), PCF(16,1).\n\n![edges](img/tests_smmvp.png)\n\n"
        + table(("filter", "levels found", "across", "error"), lines)
    )


def chair_zones(renderer: Renderer) -> str:
    """IDD's figure 4: which line of the table in §5.5 decides each pixel."""
    scene = scenes.chair()
    chosen = settings(2048, kind="id-depth", epsilon=NEAR, epsilon_far=FAR)
    frame = run(Job(scene, CAMERA, SUN, chosen, SIZE, ("combined", "shadow", "depth", "normal", "object", "texel")), on=renderer).frame
    seen, r = receivers(frame, CAMERA, SUN, chosen.fit.size)
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
