"""From camera, light and choices to the matrices of the shadow maps: a `ShadowPlan`. Pure numpy; the order is the texts'.

1. Light space (`light_space.py`), γ. 2. Near and far of what is to be divided: the camera's ('frustum'), those of view ∩ scene ('scene'),
or those of the receivers really visible ('samples'). 3. Splits (`partitions.py`), and the planes they stand for (`slices.py`). 4. Per
partition n' (`warps.py`), the apex placed before its part of the view frustum as T4 §4.2.2 has it, then the crop (`crop.py`): xy from
receivers, depth from casters. For a finite light 4. is `lamps.py`'s.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import expm1, inf, log1p, pi, sqrt
from typing import Any

import numpy as np

from ..choices import FitChoice, PartitionChoice, WarpChoice, unsuited
from ..frusta import Body, frustum_corners, hexahedron
from ..spaces import linear, smoothstep, translation
from ..view import Camera, Light
from ..warping.formulas import eta_from_parameter, faded_bend, gamma_lim_rad, warp_depth
from ..warping.row import RATE
from .crop import Casters, Receivers, Warp, casters_in, crop
from .faces import LEAST_SIZE, face_parameter, face_spaces
from .fit_view import FitView, view_to_fit
from .lamps import aimed, border, parts_the_picture, pyramid_corners, sections, share_of
from .light_space import NEAREST, LightSpace, cone_space, round_core, roundness, sun_space
from .partitions import split_distances
from .projection import ShadowPlan, ShadowProjection
from .slices import SLACK, UPRIGHT_BELOW, Slices, across_view, along_light, slice_count
from .strength import Range, steady_strength
from .suited_cut import Facets, suited_cut
from .warps import warp_parameter

LOG_LEAST = 1.0 / 64  # least f'/n' − 1 of a log map: below, its t would cancel; it is then uniform within 2 %


@np.errstate(under="ignore")  # float32 products of nearly parallel axes: zero is what they mean
def plan_shadows(
    camera: Camera,
    light: Light,
    warp: WarpChoice,
    partition: PartitionChoice,
    fit: FitChoice,
    *,
    receivers_ws: np.ndarray | None,
    scene_bounds_ws: np.ndarray,
    caster_bounds_ws: np.ndarray,
    image_size: tuple[int, int],
    facets: Facets | None = None,
) -> ShadowPlan:
    """The shadow maps of one light for one view.

    `receivers_ws` (P, 3) points of the visible surface (needed for the 'samples' fit only), `scene_bounds_ws` (2, 3), `caster_bounds_ws`
    (I, 2, 3) boxes of the casters, `image_size` (width, height) in pixels. The number of projections depends on the choices and the
    light's kind alone: partitions without receivers are there too (`is_empty`), with a matrix of their slab of the view.
    `facets`: points and normals (F, 3) of some of the receivers, by which the cut 'auto' chooses (without them it takes halves).
    """
    if partition.cut == "auto":

        def planned(choice: PartitionChoice, points_ws: np.ndarray) -> ShadowPlan:
            bounds: dict[str, Any] = {"scene_bounds_ws": scene_bounds_ws, "caster_bounds_ws": caster_bounds_ws[:0]}
            return plan_shadows(camera, light, warp, choice, fit, receivers_ws=points_ws, image_size=image_size, **bounds)

        partition = replace(partition, cut=suited_cut(camera, light, partition, fit, facets, image_size[1], planned))
    if fit.kind == "samples" and receivers_ws is None:
        raise ValueError("The 'samples' fit needs receivers_ws, the points of the visible surface.")
    view = view_to_fit(camera, warp, fit, receivers_ws, scene_bounds_ws, caster_bounds_ws, image_size)
    near, far = view.depth_range or (camera.near, camera.far)
    spaces = list(_spaces(view, light, partition, scene_bounds_ws))
    pieces = partition.z_count if light.kind == "spot" and parts_the_picture(partition) else 1
    choice = partition if light.kind != "point" and pieces == 1 else PartitionChoice(kind="none")
    first = spaces[0][1]
    along = choice.cut != "view" and light.kind == "sun" and not _has_faces(camera, light, partition) and choice.z_count > 1
    halved = along and slice_count(choice) < choice.z_count
    if not along:
        choice = replace(choice, cut="view")
    elif halved:
        choice = replace(choice, count=slice_count(choice))
    splits = split_distances(choice, near, far, first.gamma_rad, camera.is_orthographic)
    if light.kind == "sun":
        projections = tuple(p for face, space in spaces for p in _maps(view, space, splits, face, along, halved))
    else:
        projections = tuple(p for face, space in spaces for p in _lamp_maps(view, space, splits, face, pieces))
    gamma_lim = gamma_lim_rad(near, far, camera.half_fov_rad)
    first = sun_space(light, camera) if light.kind == "sun" else first
    return ShadowPlan(
        projections,
        first.gamma_rad,
        gamma_lim,
        _light_from_world(first, camera),
        camera.anchor_ws(near),
        near,
        _warnings(camera, light, warp, partition),
    )


def _spaces(view: FitView, light: Light, partition: PartitionChoice, scene_bounds: np.ndarray) -> Iterator[tuple[int, LightSpace]]:
    """(face, light space): one, six for the frustum's faces, or six for a point light (a cube along the world's axes)."""
    camera = view.camera
    if light.kind == "sun":
        yield from face_spaces(camera, light) if _has_faces(camera, light, partition) else [(-1, sun_space(light, camera))]
        return
    position = np.asarray(light.position_ws, np.float64) - camera.eye_ws
    reach = view.reach(position, scene_bounds)
    if light.kind == "spot":
        yield -1, cone_space(position, -np.asarray(light.direction_ws, np.float64), light.cone_rad, reach, camera)
        return
    axes = np.eye(3)
    for face in range(6):
        axis, sign = face // 2, 1.0 - 2.0 * (face % 2)
        yield face, cone_space(position, sign * axes[axis], pi / 4.0, reach, camera, axes[[(axis + 1) % 3, (axis + 2) % 3]])


def _has_faces(camera: Camera, light: Light, partition: PartitionChoice) -> bool:
    """Whether the view frustum's faces get maps: they fan out from an eye, and share the light's direction."""
    return partition.uses_faces and light.kind == "sun" and not camera.is_orthographic


def _light_from_world(space: LightSpace, camera: Camera) -> np.ndarray:
    """The plan's `light_from_world`: a rotation for the sun, homogeneous rows for a finite light."""
    return space.from_eye if space.position is None else space.from_eye @ translation(-camera.eye_ws)


def _warnings(camera: Camera, light: Light, warp: WarpChoice, partition: PartitionChoice) -> tuple[str, ...]:
    """What was asked for and means nothing here; a default was not asked for."""
    out = []
    for name, choice in (("warp", warp), ("partition", partition)):
        reason = unsuited(name, choice.kind, light.kind, camera.is_orthographic)
        if reason is not None and choice.kind != type(choice)().kind:
            out.append(f"The {name} '{choice.kind}' means nothing here. {reason}.")
    if light.kind == "point" and partition.z_count > 1 and partition.count != PartitionChoice().count:
        out.append(f"{partition.count} partitions mean nothing here. {unsuited('partition', partition.kind, light.kind)}.")
    return tuple(out)


def _maps(view: FitView, space: LightSpace, splits: np.ndarray, face: int, along: bool, halved: bool) -> Iterator[ShadowProjection]:
    """One projection per slab between the splits or, `along` the light's rays, one per slice worth as much, or two if it is `halved`."""
    rows, depths = _light_rows(view, space)
    casters = casters_in(space, view.boxes)
    slices = _slices(view, space, splits, rows, depths) if along else across_view(splits, view.camera.direction_ws)
    heights = depths if rows is None else slices.heights(depths, rows[2])
    for i in range(slices.count):
        near, far = slices.depths(i)
        cuts = slices.region(i)
        contents = _contents(view, space, rows, depths, heights, slices, i, cuts[:0])
        whole = _one_map(view, space, contents[0], casters, contents[1], cuts)
        parts = [cuts[:0]] if not halved else _halves(whole["clip_from_world"], contents[0], space, view)
        for half in parts:
            own = np.concatenate([cuts, half])
            if len(half):
                receivers, fitted = _contents(view, space, rows, depths, heights, slices, i, half)
                whole = _one_map(view, space, receivers, casters, fitted, own)
            yield ShadowProjection(
                **whole, near=near, far=far, face=face, is_cut_along_light=slices.along, region_planes_ws=_region(space, view.camera, own)
            )


def _lamp_maps(view: FitView, space: LightSpace, splits: np.ndarray, face: int, pieces: int) -> Iterator[ShadowProjection]:
    """One projection per slab between the splits for a finite light's space, or `pieces` of one: a map is parted in the middle, along the
    axis whose error is the larger, and each part has a map of its own; four together have no larger texels than one of as many."""
    rows, depths = _light_rows(view, space)
    slices = across_view(splits, view.camera.direction_ws)
    capped = view.warp.eta is None and view.warp.parameter is None
    for i in range(slices.count):
        near, far = slices.depths(i)
        todo = [(pieces, slices.region(i))]
        while todo:
            count, cuts = todo.pop()
            receivers, fitted = _lamp_contents(view, space, rows, depths, slices, i, cuts)
            aim = aimed(space, receivers, share_of(view.warp, *fitted, view.camera.half_fov_rad), capped)
            casters = casters_in(aim.space, view.boxes if receivers is not None else view.boxes[:0])
            fields = _one_map(view, aim.space, aim.receivers, casters, fitted, cuts, aim.strength)
            if count > 1:
                plane = border(fields["clip_from_world"] @ translation(view.camera.eye_ws), aim.error, (count // 2) / count)
                todo += [(count - count // 2, np.concatenate([cuts, plane])), (count // 2, np.concatenate([cuts, -plane]))]
                continue
            region = _region(space, view.camera, cuts)
            yield ShadowProjection(**fields, near=near, far=far, face=face, is_cut_along_light=pieces > 1, region_planes_ws=region)


def _lamp_contents(
    view: FitView, space: LightSpace, rows: np.ndarray | None, depths: np.ndarray, slices: Slices, i: int, cuts: np.ndarray
) -> tuple[Receivers | None, tuple[float, float]]:
    """What of slab i lies inside the planes `cuts` through a finite light (P, 4): its receivers in light space or None, their depths."""
    if rows is None:
        body = _cut(view.body.clipped(slices.planes(i)), space).clipped(cuts)
        points = sections(body, view.camera.direction_ws)
        own = points @ view.camera.direction_ws
        kept = space.points(points).T if len(points) else np.empty((3, 0))
    else:
        held = slices.holds(i, depths)
        for plane in cuts:
            x, travel, z = plane[:3] @ np.stack([space.from_eye[0, :3], space.travel_ws, space.from_eye[2, :3]]).T
            held &= travel + x * rows[0] + z * rows[2] >= -SLACK
        chosen = np.flatnonzero(held)
        own, kept = depths[chosen], rows.take(chosen, axis=1)
    if not len(own):
        return None, view.padded_range(float(slices.splits[i]), float(slices.splits[i + 1]))
    radius = (np.ones_like(own) if view.camera.is_orthographic else own) * view.pixel * kept[1]
    return Receivers(kept, radius.astype(kept.dtype)), view.padded_range(float(own.min()), float(own.max()))


def _halves(clip_from_world: np.ndarray, receivers: Receivers | None, space: LightSpace, view: FitView) -> list[np.ndarray]:
    """The two sides, (1, 4) each, of a map's middle line s = 0, relative to the eye; the first is that of the camera's left.

    A slice of the whole frustum has the eye in it: there the corner that s = 0 depends on changes fast, and the line goes through the eye
    and the middle of the slice's far end instead (the orbit of tests/pipeline/test_orbit.py: 1.10 × a degree instead of 1.66).
    Towards γ = 0, where the line turns round with the light, it turns to stand upright in the picture, through the receivers' middle.
    """
    plane = clip_from_world[0] @ translation(view.camera.eye_ws)
    if view.fit.kind == "frustum" and receivers is not None:
        x, _, z = receivers.rows
        far_end = np.array([0.5 * (float(x.min()) + float(x.max())), 0.0, float(z.max())])
        plane = np.append(np.cross([0.0, 1.0, 0.0], far_end) @ space.from_eye[:3, :3], 0.0)
    plane = plane / np.linalg.norm(plane[:3])
    right = view.camera.view_from_world[0, :3] + 1e-6 * view.camera.view_from_world[1, :3]
    plane = plane if plane[:3] @ right >= 0.0 else -plane
    upright = right - space.travel_ws * (space.travel_ws @ right)
    length = float(np.linalg.norm(upright))
    share = 1.0 - smoothstep(space.gamma_rad, 0.0, UPRIGHT_BELOW)
    if share > 0.0 and length > 1e-6 and receivers is not None:
        across = linear(space.from_eye[:3, :3] @ upright / length, receivers.rows)
        middle = 0.5 * (float(across.min()) + float(across.max()))
        plane = (1.0 - share) * plane + share * np.append(upright / length, -middle)
        plane = plane / np.linalg.norm(plane[:3])
    return [-plane[None], plane[None]]


def _slices(view: FitView, space: LightSpace, splits: np.ndarray, rows: np.ndarray | None, depths: np.ndarray) -> Slices:
    """The partitions of a sun's space along its rays."""
    contents = view.body if rows is None else (depths, rows[2])
    near, far, phi = float(splits[0]), float(splits[-1]), view.camera.half_fov_rad
    return along_light(
        splits,
        view.camera.direction_ws,
        space,
        gamma_lim_rad(near, far, phi) if phi > 0.0 else inf,
        _side_angle(view.camera, space),
        contents,
    )


def _region(space: LightSpace, camera: Camera, cuts: np.ndarray) -> np.ndarray:
    """The planes that select this map, moved from the eye to the world (a spot has none: the shader knows the cone)."""
    planes = (cuts if space.select is None else space.select).copy()
    planes[:, 3] -= planes[:, :3] @ camera.eye_ws
    return planes


def _light_rows(view: FitView, space: LightSpace) -> tuple[np.ndarray | None, np.ndarray]:
    """Samples as rows x, y, z of light space (3, P) float32, and their view depths; for a finite light only those in its pyramid."""
    if view.samples is None:
        return None, view.depths
    axes = space.from_eye.astype(np.float32)
    if space.planes is None:
        return linear(axes[:3, :3], view.samples), view.depths
    planes = space.planes.astype(np.float32)
    inside = np.flatnonzero((linear(planes[:, :3], view.samples) >= -planes[:, 3:]).all(axis=0))
    h = linear(axes[:, :3], view.samples.take(inside, axis=1)) + axes[:, 3:]
    rows, depths = h[:3] / h[3], view.depths[inside]
    if space.select is None:  # a spot: outside its cone nothing is lit
        lit = np.flatnonzero(rows[0] ** 2 + rows[2] ** 2 <= (1.0 + SLACK) * space.slope**2)
        rows, depths = rows.take(lit, axis=1), depths[lit]
    return rows, depths


def _contents(
    view: FitView,
    space: LightSpace,
    rows: np.ndarray | None,
    depths: np.ndarray,
    heights: np.ndarray,
    slices: Slices,
    i: int,
    half: np.ndarray,
) -> tuple[Receivers | None, tuple[float, float]]:
    """Partition i's receivers in a sun's space (None where there are none), and their own view-depth range."""
    empty = float(slices.splits[0 if slices.along else i]), float(slices.splits[-1 if slices.along else i + 1])
    if rows is None:
        inside = _cut(view.body.clipped(slices.planes(i)).clipped(half), space).vertices
        if not len(inside):
            return None, view.padded_range(*empty)
        own = inside @ view.camera.direction_ws
        return Receivers(space.points(inside).T), view.padded_range(float(own.min()), float(own.max()))
    held = slices.holds(i, heights)
    for plane in half:
        side = linear((space.from_eye[:3, :3] @ plane[:3]).astype(np.float32), rows) + np.float32(plane[3])
        held &= side >= -SLACK * np.abs(rows).max(axis=0)
    chosen = np.flatnonzero(held)
    if not len(chosen):
        return None, view.padded_range(*empty)
    own, kept = depths[chosen], rows.take(chosen, axis=1)
    radius = np.full(len(own), view.pixel, np.float32) if view.camera.is_orthographic else own * np.float32(view.pixel)
    return Receivers(kept, radius), view.padded_range(float(own.min()), float(own.max()))


def _cut(body: Body, space: LightSpace) -> Body:
    """What of a body lies where a finite light serves."""
    return body if space.planes is None else body.clipped(space.planes)


def _one_map(
    view: FitView,
    space: LightSpace,
    receivers: Receivers | None,
    casters: Casters,
    fitted: tuple[float, float],
    cuts: np.ndarray,
    strength: float | None = None,
) -> dict[str, Any]:
    """The fields of one projection: warp from the slab of the view frustum at the receivers' own depths (a finite light brings its
    `strength`), crop to the receivers."""
    (near, far), method = fitted, view.warp.method
    hull = _hull(view, space, near, far, cuts) if receivers is None or space.position is None else np.empty((0, 3))
    lit = receivers if receivers is not None else Receivers(hull.T)
    z = hull[:, 2] if space.position is None else lit.rows[2]
    start, depth = float(z.min()), max(float(np.ptp(z)), 1e-9)
    round_share = _round_share(view, space, near, far) if space.position is None else 0.0
    least = 0.0
    if strength is not None:
        depth_m = warp_depth(near, far, view.camera.half_fov_rad, space.gamma_rad)
    elif space.rise is None:
        strength, depth_m = _strength(view, space, near, far, depth, method.slice_rate if len(cuts) else RATE)
    else:
        least = LEAST_SIZE * float(np.ptp(frustum_corners(view.camera, near, far), axis=0).max())
        across = warp_parameter(view.warp, near, far, view.camera.half_fov_rad, 0.5 * pi)
        strength, depth_m = log1p(depth / face_parameter(across, hull, (near, far), space.rise, least)), depth
    log = method.log if space.position is None else None
    bend = faded_bend(view.warp.log_bend, near, far, strength) if log and method.bends else 0.0
    warp = Warp(expm1(strength if log is None else max(strength, log1p(LOG_LEAST))) / depth, start, log, bend)
    cropped = crop(space, warp, lit, casters, view.fit, round_share, least)
    parameter = depth_m / (warp.kappa * depth) if warp.kappa else inf
    eta = eta_from_parameter(parameter, near, far, depth_m) if near > 0.0 else -1.0
    return {
        "clip_from_world": cropped.clip_from_eye @ translation(-view.camera.eye_ws),
        "log": cropped.log,
        "warp_parameter": parameter,
        "eta": eta,
        "light_depth_range": _light_depths(space, view.camera, cropped.y_range, cropped.centre),
        "is_empty": receivers is None,
        "fitted_range": (near, far),
    }


def _hull(view: FitView, space: LightSpace, near: float, far: float, cuts: np.ndarray) -> np.ndarray:
    """(V, 3) light space: the part of the view frustum that the map is responsible for; where there is none, a harmless body."""
    slab = hexahedron(frustum_corners(view.camera, near, far))
    own = _cut(slab.clipped(cuts), space).vertices
    if len(own):
        return space.points(own)
    return space.points(slab.vertices if space.position is None else pyramid_corners(space, 2.0 * space.least, space.least / NEAREST))


def _round_share(view: FitView, space: LightSpace, near: float, far: float) -> float:
    """`roundness` of this map; a view with parallel rays has no γ_lim, its rectangle turns about the axis all the same."""
    if space.rise is not None:
        return 0.0  # a face's axis does not depend on the view direction
    phi = view.camera.half_fov_rad
    return roundness(space.gamma_rad, gamma_lim_rad(near, far, phi) if phi > 0.0 else inf)


def _strength(view: FitView, space: LightSpace, near: float, far: float, depth: float, rate: float) -> tuple[float, float]:
    """ln(f'/n') of a sun's map, which grows by at most `rate` per degree of γ, and the depth of P in metres that n' refers to."""
    phi, gamma = view.camera.half_fov_rad, space.gamma_rad
    if phi <= 0.0:
        return 0.0, depth
    extent = Range(near, far, phi, max(phi, _side_angle(view.camera, space)), depth / warp_depth(near, far, phi, gamma))
    return steady_strength(view.warp, extent, gamma, round_core(gamma_lim_rad(near, far, phi)), rate), depth


def _side_angle(camera: Camera, space: LightSpace) -> float:
    """Half angle of the view frustum in the plane of the light and the view: from the picture's half sides as the light sees them."""
    across = camera.view_from_world[:2, :3] @ (space.ray - camera.direction_ws * (space.ray @ camera.direction_ws))
    length = float(np.hypot(*across))
    half_sides = 1.0 / np.array([camera.clip_from_view[0, 0], camera.clip_from_view[1, 1]])
    return float(np.arctan(np.abs(across) @ half_sides / length)) if length > 0.0 else camera.half_fov_rad


def _light_depths(space: LightSpace, camera: Camera, y: tuple[float, float], centre: tuple[float, float]) -> tuple[float, float]:
    """Light depths of two y of light space on the map's central ray: −y_ls (sun), or the distance to the light along that ray."""
    if space.position is None:
        offset = float(space.travel_ws @ camera.eye_ws)
        return offset - y[0], offset - y[1]
    slant = sqrt(1.0 + centre[0] ** 2 + centre[1] ** 2)
    return slant / y[0] if y[0] > 0.0 else inf, slant / y[1] if y[1] > 0.0 else inf
