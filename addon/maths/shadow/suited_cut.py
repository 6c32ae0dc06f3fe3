"""Which cut suits a view, by the texels that each would give: what the cut 'auto' takes.

A slice is as wide as ever across the view, and a map is square: whether four slices or two of two halves have the smaller texels follows
from what is seen: how long and how wide it lies under the light, how it is turned to the light and to the eye. So both are fitted to a few
of the visible places, and the extents of their texels in the picture are compared there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..choices import FitChoice, PartitionChoice
from ..view import Camera, Light
from .lookup import partition_index, texel_footprint, towards_light
from .projection import ShadowPlan
from .slices import slice_count

Facets = tuple[np.ndarray, np.ndarray]
LONG = 4.0  # f/n of what is seen below which nothing is compared: slices hardly ever pay there
BETTER = 0.95  # of the halves' extents: less is not worth a change between frames
FACING = 0.05  # cosine from which a surface counts as facing the light
LARGEST_PX = 20.0  # a surface along the ray has no bound


def mean_extent_px(plan: ShadowPlan, camera: Camera, light: Light, facets: Facets, pixel: float, size: int) -> float:
    """Mean over the facets, points and normals (F, 3), of half the sum of a texel's two extents, on the surface, in pixels.

    `pixel` is a pixel's size at view depth 1 (perspective) or anywhere (orthographic). Facets that face away from the light or in no map
    do not count; 0 without any.
    """
    points, normals = facets
    facing = (normals * towards_light(light, points)).sum(axis=-1)
    index = np.where(facing > FACING, partition_index(plan, camera, points), -1)
    offset = points - camera.eye_ws
    depth = np.ones(len(points)) if camera.is_orthographic else offset @ camera.direction_ws
    ray = np.broadcast_to(camera.direction_ws, offset.shape) if camera.is_orthographic else offset / depth[:, None]
    total = 0.0
    for i, projection in enumerate(plan.projections):
        own = np.flatnonzero(index == i)
        steps = texel_footprint(projection, points[own], light, size)
        along = (steps * normals[own, None]).sum(axis=-1) / facing[own, None]
        steps -= along[..., None] * towards_light(light, points[own])[:, None]  # onto the surface, along the light's ray
        steps -= (steps @ camera.direction_ws)[..., None] * ray[own, None]  # to the same view depth, along the view's ray
        extents = np.linalg.norm(steps, axis=-1).mean(axis=-1) / (depth[own] * pixel)
        total += float(np.minimum(extents, LARGEST_PX).sum())
    return total / max(int((index >= 0).sum()), 1)


def suited_cut(
    camera: Camera,
    light: Light,
    partition: PartitionChoice,
    fit: FitChoice,
    facets: Facets | None,
    image_height: int,
    planned: Callable[[PartitionChoice, np.ndarray], ShadowPlan],
) -> str:
    """'light' where its texels are smaller than those of 'halves' by a twentieth, else 'halves'.

    Only the 'samples' fit, which follows what is seen anyway, may take slices: with the others nothing is to jump as an eye enters a scene.
    `planned` plans the maps of a choice for some receivers.
    """
    halves, slices = replace(partition, cut="halves"), replace(partition, cut="light")
    may_differ = slice_count(halves) < partition.z_count and not partition.uses_faces and light.kind == "sun" and fit.kind == "samples"
    if not may_differ or facets is None or not len(facets[0]):
        return "halves"
    points = facets[0]
    depths = (points - camera.eye_ws) @ camera.direction_ws
    if not camera.is_orthographic and depths.max() < LONG * depths.min():
        return "halves"
    pixel = 2.0 / float(camera.clip_from_view[1, 1]) / image_height
    extents = [mean_extent_px(planned(choice, points), camera, light, facets, pixel, fit.size) for choice in (halves, slices)]
    return "light" if extents[1] < BETTER * extents[0] else "halves"
