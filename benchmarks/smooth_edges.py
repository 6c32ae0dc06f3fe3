"""How smooth PCF(k, n) makes the edges of shadows, against larger filters over one depth per cell (SMMVP §5.1, its figures 5.2 and 5.3).

On a straight edge the text's comparison can be had without anything else in the way: how wide the filter's ramp is, how many levels it
has, and whether it stands where the edge is. On the chair it is a picture.
"""

from __future__ import annotations

import numpy as np

from addon.maths.shadow.lookup import project
from addon.maths.view import Camera, Light
from addon.pipeline.frame import Frame
from addon.pipeline.job import Job
from addon.pipeline.passes.gbuffer import surface_points_ws
from addon.pipeline.renderer import Renderer
from addon.scene.records import Scene
from addon.settings.groups import Settings
from addon.studies.run import run
from tests import scenes
from tests.pipeline import shadow_definition as definition

SIZE = (640, 360)
FILTERS = ((4, 3), (9, 1), (9, 2), (16, 1))
REACH = {1: 0, 2: 1, 3: 2}
"""Texels by which the ramp of PCF(k, n) is wider than its √k taps: a cell beside the edge is half (n = 2), or both are a third (n = 3)."""
TURNS_DEG = (8.0, 27.0, 41.0, 63.0)
PASSES = ("shadow", "depth", "normal", "object", "texel")
SUN = scenes.sun(50.0, 0.0)
ABOVE = scenes.look_at((0.0, -0.2, 1.4), (0.0, 0.0, 0.0), near=0.2, far=20.0)
ABOVE_M = 2.0  # of the sheet: above the camera, which does not see it
DRIFTS = np.arange(-1.0, 1.01, 0.25)
NEAR_EDGE = 4.0  # texels
MOST_COMPARED = 1500  # pixels of a picture


def name_of(k: int, n: int) -> str:
    """PCF(k,n)."""
    return f"PCF({k},{n})"


def receivers(frame: Frame, camera: Camera, light: Light, size: int) -> tuple[np.ndarray, definition.ReceiverSamples]:
    """Mask (h, w) of the lit-facing pixels of a frame and their `ReceiverSamples` in its first map."""
    depth = np.where(np.isfinite(frame.passes["depth"]), frame.passes["depth"], 0.0)[::-1]
    points = np.zeros((*depth.shape, 3))
    points[depth > 0.0] = surface_points_ws(np.ascontiguousarray(depth, dtype=np.float32), camera)
    points, normals = points[::-1], frame.passes["normal"].astype(np.float64)
    chosen = (frame.passes["object"] >= 0) & (normals @ light.direction_ws > 0.05)
    ids = frame.passes["object"][chosen]
    return chosen, definition.ReceiverSamples(frame.plan.projections[0], light, size, points[chosen], normals[chosen], ids)


def levels_across(levels: np.ndarray, most: int) -> float:
    """Mean number of different levels between dark and lit that a row of the picture shows where it crosses an edge from one to the other.

    `levels` (h, w) int, 0 dark … `most` lit.
    """
    counts = []
    for row in levels:
        partly = np.flatnonzero((row > 0) & (row < most))
        for span in np.split(partly, np.flatnonzero(np.diff(partly) > 1) + 1):
            if len(span) and span[0] > 0 and span[-1] + 1 < len(row) and {row[span[0] - 1], row[span[-1] + 1]} == {0, most}:
                counts.append(len(np.unique(row[span])))
    return float(np.mean(counts))


def sixty_four(r: definition.ReceiverSamples, depth: np.ndarray, width: float, moved: np.ndarray | float = 0.0) -> np.ndarray:
    """(P,) light through 8 × 8 taps over `width` texels of the map's own cells, the receivers moved by `moved` texels (2,)."""
    cells = definition.tap_cells(r.texels() + moved, 8, width / 8.0)
    heights = r.heights_m(cells, definition.cell_values(depth, cells))
    return definition.filtered((heights <= 0.5 * r.footprint_m()[:, None])[..., None])


def half_covered(turn_deg: float) -> tuple[Scene, np.ndarray]:
    """A floor half under a sheet whose edge is turned by that angle in plan, and the edge's two ends (2, 3)."""
    a = np.radians(turn_deg)
    along, away, top = np.array([np.cos(a), np.sin(a), 0.0]), np.array([-np.sin(a), np.cos(a), 0.0]), np.array([0.0, 0.0, ABOVE_M])
    at = top + np.array([SUN.direction_ws[0], SUN.direction_ws[1], 0.0]) * (ABOVE_M / SUN.direction_ws[2])  # its shadow ends in the middle
    ends = np.array([at - 6.0 * along, at + 6.0 * along])
    sheet = scenes.sheet(*(tuple(p) for p in (ends[0], ends[1], ends[1] + 6.0 * away, ends[0] + 6.0 * away)))
    return scenes.scene_of(scenes.floor(5.0), sheet), ends


def at_edge(renderer: Renderer, chosen: Settings, turn_deg: float) -> tuple[float, np.ndarray]:
    """Levels across the straight edge, and for each of `DRIFTS` (texels towards the light side) the rms error against 64 taps there."""
    (scene, ends), k, n = half_covered(turn_deg), chosen.test.pcf, chosen.test.depths
    frame = run(Job(scene, ABOVE, SUN, chosen, SIZE, PASSES), on=renderer).frame
    seen, r = receivers(frame, ABOVE, SUN, chosen.fit.size)
    on_floor = r.ids == 0
    s, t, _, _ = project(r.projection, ends)
    texels = (np.stack([s, t], axis=-1) + 1.0) * (r.size / 2.0)
    normal = np.array([texels[0, 1] - texels[1, 1], texels[1, 0] - texels[0, 0]])
    normal /= np.linalg.norm(normal)
    distance = (r.texels() - texels[0]) @ normal
    shadow = frame.passes["shadow"][seen]
    if shadow[on_floor & (distance > NEAR_EDGE)].mean() < 0.5:
        normal, distance = -normal, -distance
    near = np.flatnonzero(on_floor & (np.abs(distance) < NEAR_EDGE))
    near = near[:: -(-len(near) // MOST_COMPARED)]
    mine = definition.ReceiverSamples(r.projection, SUN, r.size, r.points_ws[near], r.normals_ws[near], r.ids[near])
    depth = frame.passes["shadow_depth"][0].astype(np.float64) * 2.0 - 1.0
    width = np.sqrt(k) + REACH[n]
    errors = [np.sqrt(np.mean((shadow[near] - sixty_four(mine, depth, width, drift * normal)) ** 2)) for drift in DRIFTS]
    levels = np.where(frame.passes["object"] == 0, np.round(frame.passes["shadow"] * n * k), 0).astype(int)
    return levels_across(levels, n * k), np.array(errors)


def straight_edges(renderer: Renderer) -> list[tuple[object, ...]]:
    """A line per filter: name, ramp, levels possible, levels across, error in place, drift, error once moved by it."""
    lines = []
    for k, n in FILTERS:
        chosen = Settings().replaced(
            warp={"kind": "uniform"},
            partition={"kind": "none"},
            fit={"kind": "scene", "size": 256},
            test={"pcf": k, "depths": n, "bias_strategy": "receiver-plane"},
            shading={"samples": 1},
        )
        across, errors = zip(*(at_edge(renderer, chosen, turn) for turn in TURNS_DEG), strict=True)
        mean = np.mean(errors, axis=0)
        least = int(mean.argmin())
        lines.append(
            (
                name_of(k, n),
                f"{np.sqrt(k):.0f} + {REACH[n]}",
                n * k + 1,
                float(np.mean(across)),
                float(mean[DRIFTS == 0.0][0]),
                float(DRIFTS[least]),
                float(mean[least]),
            )
        )
    return lines


def chair_edges(renderer: Renderer, camera: Camera, light: Light) -> tuple[list[tuple[object, ...]], np.ndarray]:
    """A line per filter (name, levels found, levels across, error) on the chair's shadows, thin ones among them, and a strip of crops."""
    scene, crops, lines = scenes.chair(), [], []
    for k, n in FILTERS:
        chosen = Settings().replaced(
            partition={"kind": "none"},
            fit={"size": 256},
            shading={"samples": 1},
            test={"pcf": k, "depths": n, "bias_strategy": "receiver-plane"},
        )
        frame = run(Job(scene, camera, light, chosen, SIZE, PASSES), on=renderer).frame
        seen, r = receivers(frame, camera, light, chosen.fit.size)
        depth = frame.passes["shadow_depth"][0].astype(np.float64) * 2.0 - 1.0
        reference, shadow = sixty_four(r, depth, np.sqrt(k) + REACH[n]), frame.passes["shadow"][seen]
        edge = (reference > 0.0) & (reference < 1.0)
        error = float(np.sqrt(np.mean((shadow[edge] - reference[edge]) ** 2)))
        levels = np.where(seen, np.round(frame.passes["shadow"] * n * k), 0).astype(int)
        lines.append((name_of(k, n), len(np.unique(levels[seen])), levels_across(levels, n * k), error))
        crops.append(np.pad(np.kron(frame.passes["shadow"][140:230, 215:335], np.ones((4, 4))), ((0, 0), (0, 8)), constant_values=1.0))
    return lines, np.repeat(np.concatenate(crops, axis=1)[..., None], 3, axis=-1)
