"""What the texts predict for a view, a light and a method, without a scene: the `theory` command.

`theory` is the command's JSON object; `text_report` prints it with the texts' other quantities. Sources: T4 §4.2–4.3, LogPSM §5.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, degrees, inf, pi, radians, sin
from typing import Any

import numpy as np

from ..choices import WARPS, PartitionChoice, WarpChoice, require
from ..shadow.partitions import split_distances
from ..warping.formulas import (
    eta_from_parameter,
    far_parameter,
    gamma_lim_rad,
    lispsm_parameter,
    omega_from_parameter,
    pseudo_near_parameter,
    warp_depth,
)
from .aliasing import (
    error_x,
    error_z,
    max_beam_error_z,
    max_error_x,
    max_error_z,
    side_face_maxima,
    storage_factor_log,
    storage_factor_parallel,
    storage_factor_z,
)
from .seams import seams
from .warped_map import WarpedMap, partition_maps


@dataclass(frozen=True, slots=True)
class Resolution:
    """The resolution terms: texels per side of each map, and pixels of the image; a term is 1 unless both are known."""

    map_size: int | None = None
    image_size: tuple[int, int] | None = None

    @property
    def terms(self) -> tuple[float, float]:
        """(res_cx/res_ls, res_cy/res_lt)."""
        if self.map_size is None or self.image_size is None:
            return 1.0, 1.0
        return self.image_size[0] / self.map_size, self.image_size[1] / self.map_size


def map_maxima(m: WarpedMap, faces: bool) -> tuple[float, float]:
    """(M_x, M_z) of a map, resolution terms 1; of a side face when `faces`. At γ = 0, where (37) has no value, M_z is the beam's (53)."""
    if faces:
        return side_face_maxima(m)
    return max_error_x(m), max_error_z(m) if m.gamma_rad > 0.0 else max_beam_error_z(m)


def map_row(index: int, m: WarpedMap, faces: bool, resolution: Resolution) -> dict[str, Any]:
    """One entry of the report's `partitions`. The critical resolution is that of an image of `image_size` (else of one pixel).

    `warp_parameter` is n' along z_ls, with faces along the face (n'/cos φ); None = ∞.
    """
    m_x, m_z = map_maxima(m, faces)
    rx, rz = resolution.terms
    width, height = resolution.image_size or (1, 1)
    depth = m.depth
    return {
        "index": index,
        "near": m.near,
        "far": m.far,
        "warp_parameter": None if m.parameter == inf else m.parameter / (cos(m.half_fov_rad) if faces else 1.0),
        "eta": eta_from_parameter(m.parameter, m.near, m.far, depth),
        "m_x_max": rx * m_x,
        "m_z_max": rz * m_z,
        "storage_factor": m_x * m_z,
        "critical_resolution": [width * m_x, height * m_z],
    }


def unknown_row(index: int, near: float, far: float) -> dict[str, Any]:
    """The entry of an orthographic camera: uniform, and m depends on the width of the view, which the theory does not know."""
    unknown = dict.fromkeys(("m_x_max", "m_z_max", "storage_factor", "critical_resolution"))
    return {"index": index, "near": near, "far": far, "warp_parameter": None, "eta": -1.0, **unknown}


def error_curve(maps: tuple[WarpedMap, ...], faces: bool, count: int, resolution: Resolution) -> dict[str, list[Any]]:
    """z, m_x(z), m_z(z) at `count` depths from near to far, in equal ratios; a border belongs to the partition behind it."""
    require(count >= 2, "A curve needs at least 2 points.")
    z = np.geomspace(maps[0].near, maps[-1].far, count)
    index = np.clip(np.searchsorted([m.near for m in maps], z, side="right") - 1, 0, len(maps) - 1)
    rx, rz = resolution.terms
    m_x, m_z = np.empty(count), np.empty(count)
    for i, m in enumerate(maps):
        c = cos(m.half_fov_rad) if faces else 1.0
        here = index == i
        m_x[here] = error_x(m, z[here], rx / c)
        m_z[here] = error_z(m, z[here], rz / c**2)
    return {"z": z.tolist(), "m_x": m_x.tolist(), "m_z": [value if value < inf else None for value in m_z.tolist()]}


def as_seen(maps: tuple[WarpedMap, ...], gamma_rad: float, curve: dict[str, list[Any]] | None, resolution: Resolution) -> dict[str, Any]:
    """m_z by T4's own definition (15), (19), (37) · sin γ: what an image shows (docs/laboratory.md). Maximum, in all and per map, and the
    curve at the depths of `curve` (None without one)."""
    rz = resolution.terms[1]
    maxima = [rz * max_beam_error_z(m) for m in maps]
    seen = None if curve is None else [None if value is None else value * sin(gamma_rad) for value in curve["m_z"]]
    return {"m_z_max": max(maxima), "partitions_m_z_max": maxima, "curve_m_z": seen}


def theory(
    near: float,
    far: float,
    half_fov_rad: float,
    gamma_rad: float,
    warp: WarpChoice,
    partition: PartitionChoice,
    map_size: int | None = None,
    image_size: tuple[int, int] | None = None,
    curve: int | None = None,
) -> dict[str, Any]:
    """The object of `theory --json`: γ, γ_lim, every partition, the totals, and with `curve` that many points of m_x(z), m_z(z).

    M_x and M_z take the resolution terms when `map_size` and `image_size` are both given; S = M_x M_z without them (T4 (30)), its total the
    sum over partitions (51). M_z follows (37), along the view axis; at γ = 0 it is (53), and its curve None. `as_seen`
    is (37) · sin γ, what an image shows. With faces the numbers are
    those of one side face lit from straight above, the worst over all light directions. An orthographic camera (φ = 0) has no theory: None.
    Raises SettingsError outside 0 < near < far, 0 ≤ φ < π/2, 0 ≤ γ ≤ π/2.
    """
    require(0.0 <= half_fov_rad < pi / 2.0, "The field of view must lie between 0 and 180 degrees.")
    splits = split_distances(partition, near, far, gamma_rad, half_fov_rad == 0.0)
    resolution = Resolution(map_size, image_size)
    result: dict[str, Any] = {"gamma_deg": degrees(gamma_rad), "gamma_lim_deg": degrees(gamma_lim_rad(near, far, half_fov_rad))}
    if half_fov_rad == 0.0:
        rows = [unknown_row(i, float(splits[i]), float(splits[i + 1])) for i in range(len(splits) - 1)]
        unknown = dict.fromkeys(("m_x_max", "m_z_max", "storage_factor"))
        return {**result, "partitions": rows, "total": unknown, "curve": None, "as_seen": None}
    maps = partition_maps(near, far, half_fov_rad, gamma_rad, warp, partition)
    rows = [map_row(i, m, partition.uses_faces, resolution) for i, m in enumerate(maps)]
    result["partitions"] = rows
    result["total"] = {
        "m_x_max": max(row["m_x_max"] for row in rows),
        "m_z_max": max(row["m_z_max"] for row in rows),
        "storage_factor": sum(row["storage_factor"] for row in rows),
    }
    result["curve"] = error_curve(maps, partition.uses_faces, curve, resolution) if curve else None
    result["as_seen"] = None if partition.uses_faces else as_seen(maps, gamma_rad, result["curve"], resolution)
    return result


# --- the same in words ------------------------------------------------------------------------------------------------------------


def text_report(result: dict[str, Any], half_fov_rad: float, warp: WarpChoice, partition: PartitionChoice) -> str:
    """`theory`'s object as a table, with the other quantities of the texts that apply: bounds, warps to compare, seams.

    `half_fov_rad`, `warp` and `partition` are those the object was made with.
    """
    rows = result["partitions"]
    near, far, gamma = rows[0]["near"], rows[-1]["far"], radians(result["gamma_deg"])
    lines = [
        f"view      near {near:g} m, far {far:g} m, φ {degrees(half_fov_rad):g}°",
        f"light     γ {result['gamma_deg']:.6g}°, γ_lim {result['gamma_lim_deg']:.6g}° (40)",
        f"method    warp {warp.kind}, partition {partition.kind}, {len(rows)} map(s)",
        "",
        *_partition_table(rows, gamma, half_fov_rad, partition.uses_faces),
    ]
    if half_fov_rad == 0.0:
        return "\n".join([*lines, "", "An orthographic camera sees every depth alike: no perspective aliasing, no warp."])
    lines += ["", *_warp_lines(near, far, half_fov_rad, gamma, warp.pseudo_near)]
    lines += ["", *_bound_lines(near, far, half_fov_rad, len(rows))]
    borders = seams(near, far, half_fov_rad, gamma, warp, partition)
    if borders:
        lines += ["", "seams: m behind the border over m before it"]
        lines += [f"  z {s.z:<12.6g} m_x × {s.jump_x:<8.4g} m_z × {s.jump_z:.4g}" for s in borders]
    return "\n".join(lines)


def _number(value: float | None) -> str:
    return "–" if value is None else "∞" if value == inf else f"{value:.5g}"


def _partition_table(rows: list[dict[str, Any]], gamma_rad: float, half_fov_rad: float, faces: bool) -> list[str]:
    """One line per partition, and the meaning of the columns."""
    lines = [f"{'':>2} {'near':>11} {'far':>11} {'n′':>11} {'η (32)':>9} {'ω (5.30)':>9} {'M_x':>10} {'M_z':>10} {'S':>10}  critical s × t"]
    for row in rows:
        near, far, parameter = row["near"], row["far"], inf if row["warp_parameter"] is None else row["warp_parameter"]
        depth = (far - near) / cos(half_fov_rad) if faces else warp_depth(near, far, half_fov_rad, gamma_rad)
        omega = omega_from_parameter(parameter, near, far, depth) if near > 0.0 else 0.0
        cells = [_number(near), _number(far), _number(parameter), _number(row["eta"]), _number(omega)]
        cells += [_number(row[key]) for key in ("m_x_max", "m_z_max", "storage_factor")]
        size = "–" if row["critical_resolution"] is None else " × ".join(_number(c) for c in row["critical_resolution"])
        widths = (11, 11, 11, 9, 9, 10, 10, 10)
        lines.append(f"{row['index']:>2} " + " ".join(f"{cell:>{width}}" for cell, width in zip(cells, widths, strict=True)) + f"  {size}")
    lines.append("M_x (25), (28); M_z (37), (29), along the view axis: times sin γ it is the error seen; S = M_x M_z, resolutions 1 (30)")
    return lines


def _warp_lines(near: float, far: float, half_fov_rad: float, gamma_rad: float, pseudo_near: float | None) -> list[str]:
    """n' of every method for one map over the whole view, with its two directions apart and S."""
    depth = warp_depth(near, far, half_fov_rad, gamma_rad)
    n_bar0, balanced = near / (far - near), lispsm_parameter(near, far) / (far - near)
    lines = [
        "one map over the whole view:",
        f"  P's depth f′−n′ {depth:.6g} m (36), n̄′₀ {n_bar0:.6g} (5.26), n̄′ LiSPSM {balanced:.6g} (5.29)",
        f"  {'':<24} {'n′':>11} {'f′':>11} {'M_x':>11} {'M_z':>11} {'S':>11}",
    ]
    named = [(kind, WarpChoice(kind, pseudo_near=pseudo_near)) for kind in WARPS]
    named.append(("lispsm-general, (43)", WarpChoice("lispsm-general", pseudo_near=pseudo_near, convergence="sine")))
    for name, choice in named:
        (m,) = partition_maps(near, far, half_fov_rad, gamma_rad, choice, PartitionChoice("none"))
        m_x, m_z = map_maxima(m, False)
        f_prime = far_parameter(m.parameter, near, far, half_fov_rad, gamma_rad)
        cells = [_number(value) for value in (m.parameter, f_prime, m_x, m_z, m_x * m_z)]
        lines.append(f"  {name:<24} " + " ".join(f"{cell:>11}" for cell in cells))
    if pseudo_near is not None and near < pseudo_near < far:
        optimum = _number(pseudo_near_parameter(near, far, pseudo_near))
        lines.append(f"  pseudo-near {pseudo_near:g} m: n′ {optimum} for light ⟂ view (5.64, 5.65)")
    return lines


def _bound_lines(near: float, far: float, half_fov_rad: float, count: int) -> list[str]:
    """The closed forms of S for light ⟂ view, light ∥ view and a side face."""
    cube = cos(half_fov_rad) ** 3
    flat, warped = (storage_factor_z(near, far, half_fov_rad, count, w) for w in (False, True))
    one_flat, one_warped = (storage_factor_z(near, far, half_fov_rad, 1, w) for w in (False, True))
    log = storage_factor_log(near, far, half_fov_rad)
    parallel = [storage_factor_parallel(near, far, k) for k in (1, count)]
    return [
        f"bounds of S{'':<24} {'one map':>12} {f'{count} log splits':>14}",
        f"  light ⟂ view, uniform (31), (51)  {one_flat:>12.6g} {flat:>14.6g}",
        f"  light ⟂ view, warped (31), (51)   {one_warped:>12.6g} {warped:>14.6g}",
        f"  light ⟂ view, logarithmic (52)    {log:>12.6g} {log:>14.6g}",
        f"  light ∥ view, any (53), (54)      {parallel[0]:>12.6g} {parallel[1]:>14.6g}",
        f"  side face, uniform 5.13, 5.55     {one_flat / cube:>12.6g} {flat / cube:>14.6g}",
        f"  side face, warped 5.38, 5.56      {one_warped / cube:>12.6g} {warped / cube:>14.6g}",
        f"  side face, log+persp. 5.52, 5.57  {log / cube:>12.6g} {log / cube:>14.6g}",
    ]
