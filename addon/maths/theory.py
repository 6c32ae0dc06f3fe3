"""What the texts predict for a view, a light and a method, without a scene: the `theory` command.

`theory` is the contract's JSON object; `theory_text.py` prints it with the texts' other quantities. Sources: T4 §4.2–4.3, LogPSM §5.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, degrees, inf, pi

import numpy as np

from .choices import PartitionChoice, WarpChoice, require
from .errors import WarpedMap, error_x, error_z, max_beam_error_z, max_error_x, max_error_z, side_face_maxima
from .partitions import split_distances
from .warps import eta_from_parameter, gamma_lim_rad, warp_parameter


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


def partition_maps(
    near: float, far: float, half_fov_rad: float, gamma_rad: float, warp: WarpChoice, partition: PartitionChoice
) -> tuple[WarpedMap, ...]:
    """The maps the choices ask for, near to far. With faces: a side face's, as for light ⟂ view (a face keeps its warp at every γ)."""
    angle = pi / 2.0 if partition.uses_faces else gamma_rad
    splits = split_distances(partition, near, far, gamma_rad).tolist()
    return tuple(
        WarpedMap(n, f, half_fov_rad, angle, warp_parameter(warp, n, f, half_fov_rad, angle), warp.is_logarithmic, warp.kind != "log")
        for n, f in zip(splits[:-1], splits[1:], strict=True)
    )


def map_maxima(m: WarpedMap, faces: bool) -> tuple[float, float]:
    """(M_x, M_z) of a map, resolution terms 1; of a side face when `faces`. At γ = 0, where (37) has no value, M_z is the beam's (53)."""
    if faces:
        return side_face_maxima(m)
    return max_error_x(m), max_error_z(m) if m.gamma_rad > 0.0 else max_beam_error_z(m)


def map_row(index: int, m: WarpedMap, faces: bool, resolution: Resolution) -> dict[str, object]:
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


def unknown_row(index: int, near: float, far: float) -> dict[str, object]:
    """The entry of an orthographic camera: uniform, and m depends on the width of the view, which the theory does not know."""
    unknown = dict.fromkeys(("m_x_max", "m_z_max", "storage_factor", "critical_resolution"))
    return {"index": index, "near": near, "far": far, "warp_parameter": None, "eta": -1.0, **unknown}


def error_curve(maps: tuple[WarpedMap, ...], faces: bool, count: int, resolution: Resolution) -> dict[str, list[float | None]]:
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
) -> dict[str, object]:
    """The contract's `theory --json` object: γ, γ_lim, every partition, the totals, and with `curve` that many points of m_x(z), m_z(z).

    M_x and M_z take the resolution terms when `map_size` and `image_size` are both given; S = M_x M_z without them (T4 (30)), its total the
    sum over partitions (51). M_z follows (37), along the view axis; at γ = 0 it is (53), and its curve None. With faces the numbers are
    those of one side face lit from straight above, the worst over all light directions. An orthographic camera (φ = 0) has no theory: None.
    Raises SettingsError outside 0 < near < far, 0 ≤ φ < π/2, 0 ≤ γ ≤ π/2.
    """
    require(0.0 <= half_fov_rad < pi / 2.0, "The field of view must lie between 0 and 180 degrees.")
    splits = split_distances(partition, near, far, gamma_rad, half_fov_rad == 0.0)
    resolution = Resolution(map_size, image_size)
    result: dict[str, object] = {"gamma_deg": degrees(gamma_rad), "gamma_lim_deg": degrees(gamma_lim_rad(near, far, half_fov_rad))}
    if half_fov_rad == 0.0:
        rows = [unknown_row(i, float(splits[i]), float(splits[i + 1])) for i in range(len(splits) - 1)]
        return {**result, "partitions": rows, "total": dict.fromkeys(("m_x_max", "m_z_max", "storage_factor")), "curve": None}
    maps = partition_maps(near, far, half_fov_rad, gamma_rad, warp, partition)
    rows = [map_row(i, m, partition.uses_faces, resolution) for i, m in enumerate(maps)]
    result["partitions"] = rows
    result["total"] = {
        "m_x_max": max(row["m_x_max"] for row in rows),
        "m_z_max": max(row["m_z_max"] for row in rows),
        "storage_factor": sum(row["storage_factor"] for row in rows),
    }
    result["curve"] = error_curve(maps, partition.uses_faces, curve, resolution) if curve else None
    return result
