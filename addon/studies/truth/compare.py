"""A rendered frame against the traced truth: which pixels count, what surrounds them, and the numbers for all and for each partition."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...errors import SceneError
from ...maths.choices import require
from ...maths.error import comparison
from ...maths.shadow.projection import ShadowPlan
from ...maths.view import Camera, Light
from ...pipeline.frame import Frame
from ...pipeline.job import Job
from ...scene.records import Scene
from ...settings.groups import Settings
from ..run import run
from .footprint import texel_extent_px
from .tracer import Truth, TruthTracer

if TYPE_CHECKING:
    from ...pipeline.renderer import Renderer

COMPARED_PASSES = ("shadow", "depth", "object", "partition")
SAME_SURFACE = 1e-3
WITNESSES = 96


def pixel_size(truth: Truth, camera: Camera) -> np.ndarray:
    """(h, w) metres that a pixel covers on a surface that faces the camera; 0 where nothing is seen."""
    height = truth.depth.shape[0]
    per_metre = 2.0 / (height * float(camera.clip_from_view[1, 1]))
    depth = 1.0 if camera.is_orthographic else np.where(truth.object >= 0, truth.depth, 0.0)
    return np.broadcast_to(per_metre * depth, truth.depth.shape)


def truth_edges(truth: Truth, camera: Camera) -> tuple[comparison.Cracks, comparison.Cracks]:
    """All edges of the truth (shadow, depth, object, horizon of the light), and of them the shadow edges on one lit-facing surface."""
    surface = (
        comparison.changes(truth.object)
        | comparison.changes(truth.lit_facing)
        | comparison.depth_breaks(truth.point_ws, truth.normal_ws, pixel_size(truth, camera))
    )
    shadow = comparison.changes(truth.lit)
    return surface | shadow, shadow & ~surface & comparison.both(truth.lit_facing)


def counted_pixels(frame: Frame, truth: Truth) -> np.ndarray:
    """(h, w) lit-facing in truth, and the frame shows the same surface (same object, or the same depth within a thousandth).

    Raises `SceneError` when frame and truth do not show the same picture (more than 2 % of the pixels that either sees differ).
    """
    shown, traced = frame.passes["object"] >= 0, truth.object >= 0
    seen, either = shown & traced, shown | traced
    depth, shown_depth = np.where(seen, truth.depth, 1.0), np.where(seen, frame.passes["depth"], 1.0)
    same = seen & ((frame.passes["object"] == truth.object) | (np.abs(shown_depth - depth) < SAME_SURFACE * np.abs(depth)))
    if (either & ~same).sum() > 0.02 * max(int(either.sum()), 1) + 20:
        raise SceneError("The frame and its ray-traced truth show different surfaces: render both from the same scene and camera.")
    return same & truth.lit_facing


def compare(
    frame: Frame, truth: Truth, camera: Camera, light: Light, map_size: int, tracer: TruthTracer | None = None
) -> tuple[dict[str, object], np.ndarray]:
    """The report's `truth` dictionary (`partitions`: the same for each), and the difference image (h, w, 3).

    `frame` needs the passes in `COMPARED_PASSES`. With `tracer`, what looks like acne or a leak must also stand when the truth is asked
    at 96 places between the pixel centres around it: a wire thinner than a pixel may shade the place without touching any centre.
    """
    require(frame.plan is not None, "There is no shadow to compare: the view has no light.")
    partition, shadow = frame.passes["partition"], frame.passes["shadow"]
    edges, shadow_edges = truth_edges(truth, camera)
    counted = counted_pixels(frame, truth)
    uniform = np.zeros_like(counted)
    wrong = np.argwhere(comparison.misclassified(truth.lit, shadow, counted))
    uniform[tuple(wrong.T)] = uniform_around(wrong, truth, camera, light, edges, frame.plan, partition, map_size, tracer)
    classes = comparison.classify(truth.lit, shadow, counted, truth.facing, uniform)
    preview_edges = comparison.changes(shadow >= 0.5) & comparison.both(truth.lit_facing)
    displacement, where = comparison.edge_displacements_px(shadow_edges, preview_edges)
    served_by = partition[tuple(where.T)]
    metrics: dict[str, object] = comparison.statistics(classes, displacement)
    metrics["partitions"] = [
        {"index": i, **comparison.statistics(classes, displacement[served_by == i], partition == i)}
        for i in range(len(frame.plan.projections))
    ]
    return metrics, comparison.difference_image(classes, truth.lit, truth.object < 0)


def uniform_around(
    wrong: np.ndarray,
    truth: Truth,
    camera: Camera,
    light: Light,
    edges: comparison.Cracks,
    plan: ShadowPlan,
    partition: np.ndarray,
    map_size: int,
    tracer: TruthTracer | None,
) -> np.ndarray:
    """(K,) whether the truth is uniform around K pixels (K, 2: row, column): no edge within two pixels or a texel's footprint."""
    height, width = truth.depth.shape
    at = tuple(wrong.T)
    centres = wrong[:, ::-1] + 0.5
    texel_px = texel_extent_px(truth.at(at), centres, camera, (width, height), plan, partition[at], map_size)
    uniform = comparison.is_uniform(edges, wrong, texel_px)
    if tracer is not None and uniform.any():
        radius = np.maximum(comparison.SMALLEST_RADIUS_PX, texel_px[uniform])
        uniform[uniform] = ~disturbed(tracer, truth.at(tuple(wrong[uniform].T)), centres[uniform], radius, camera, light, (width, height))
    return uniform


def disturbed(
    tracer: TruthTracer, truth: Truth, centres: np.ndarray, radius: np.ndarray, camera: Camera, light: Light, size: tuple[int, int]
) -> np.ndarray:
    """(K,) whether a shadow, another object or another side lies within `radius` pixels (K,) of K `centres`, found between pixel centres.

    A sunflower of points covers the disc evenly; deterministic.
    """
    k = np.arange(WITNESSES)
    turn = k * (np.pi * (3.0 - np.sqrt(5.0)))
    disc = np.stack([np.cos(turn), np.sin(turn)], axis=-1) * np.sqrt((k + 0.5) / WITNESSES)[:, None]
    found = tracer.sample(camera, light, size, (centres[:, None] + radius[:, None, None] * disc).reshape(-1, 2))
    found = found.reshaped((len(centres), WITNESSES))
    differs = (found.lit != truth.lit[:, None]) | (found.object != truth.object[:, None]) | ~found.lit_facing
    return differs.any(axis=1)


def compare_view(
    scene: Scene,
    camera: Camera,
    light: Light,
    settings: Settings,
    size: tuple[int, int],
    renderer: Renderer,
    tracer: TruthTracer | None = None,
) -> tuple[Frame, Truth, dict[str, object], np.ndarray]:
    """Render one view and compare it: (frame, truth, metrics, difference image).

    Pass the `tracer` of the scene to compare more than one view of it: building it takes seconds per million triangles.
    """
    tracer = tracer or TruthTracer(scene)
    frame = run(Job(scene, camera, light, settings, size, ("combined", *COMPARED_PASSES)), on=renderer).frame
    truth = tracer.trace(camera, light, size)
    metrics, difference = compare(frame, truth, camera, light, settings.fit.size, tracer)
    return frame, truth, metrics, difference
