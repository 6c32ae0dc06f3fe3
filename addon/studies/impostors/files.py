"""Impostors as files: images and a JSON with all that is needed to draw them elsewhere. No bpy.

The JSON states its own conventions (`how`). World coordinates in files are true ones: the scene's local origin is put back.
"""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ...images.exr import encode_exr
from ...images.png import encode_png
from ...images.srgb import srgb
from ...maths.relief.edges import ReliefEdges
from ...maths.relief.warp import CaptureFrame
from ...pipeline.impostors.baked import BakedImpostor
from ...scene.records import Scene
from ..outputs import write_bytes, write_json

FORMAT, VERSION = "cad-shadow-impostor", 1
HOW = (
    "Texel (column, row), row 0 at the top, has its centre at u = column + 0.5, v = row + 0.5.",
    "d = metres behind the plane: the depth image's value times depth.scale_m (PNG), or the value itself (EXR, npz).",
    "relief = d / (source[2] - source[3] * d).",
    "world point = world_from_plane * ((u, v, 0, 1) + relief * source), divided by its last component; metres, Z up.",
    "warp for an eye e in plane coordinates (world_from_plane inverted): k = -(e0, e1, e3) / e2, K = (s0, s1, s3) + k * s2; the "
    "texel falls on (u + K0 * relief, v + K1 * relief) / (1 + K2 * relief) of the plane (RI 5-3, 5-4; any source).",
    "Where mask, and color's alpha, is 0 there is nothing; colours go on a few texels beyond, for filtering. Depth must not be filtered.",
)


def file_name(name: str) -> str:
    """A name as part of a file's name."""
    return re.sub(r"[^\w.-]+", "_", name).strip("._") or "impostor"


def unique_names(names: list[str]) -> list[str]:
    """File names for names, no two the same."""
    out: list[str] = []
    for name in map(file_name, names):
        number, wanted = 2, name
        while wanted.lower() in (n.lower() for n in out):
            wanted, number = f"{name}_{number}", number + 1
        out.append(wanted)
    return out


def critical_points(edges: ReliefEdges, origin_ws: np.ndarray) -> list[dict[str, object]]:
    """The critical point of every region that has one (RI §5.6, the outline included), nearest texel and true world place, largest first.

    `step_m` is the difference in depth of the two texels, in metres along the view of the plane.
    """
    frame, found = edges.frame, []
    for region, pair in enumerate(edges.corrected):
        if not pair[2:4].any():
            continue
        near, far = (float(_depth(frame, relief)) for relief in pair[4:])
        where = frame.points_ws(pair[:2] + 0.5 * pair[2:4], pair[4]) + origin_ws
        found.append(
            {"region": region, "uv": pair[:2].tolist(), "near_m": near, "far_m": far, "step_m": far - near, "world": where.tolist()}
        )
    return sorted(found, key=lambda point: -point["step_m"])


def _depth(frame: CaptureFrame, relief: float) -> float:
    return relief * frame.source[2] / (1.0 + relief * frame.source[3])


def depth_scale_m(baked: BakedImpostor) -> float:
    """Metres of the PNG depth's full scale per unit: 65535 stands for the back of the bounds."""
    return max(baked.frame.depth_m, float(baked.back_m.max()), 1e-9) / 65535.0


def metadata(baked: BakedImpostor, scene: Scene, files: dict[str, str]) -> dict[str, object]:
    """All needed to draw the impostor elsewhere, beside its images; `files` their names by content."""
    frame = baked.frame
    world = np.eye(4)
    world[:3, 3] = scene.origin_ws
    camera = frame.camera()
    return {
        "format": FORMAT,
        "version": VERSION,
        "name": baked.name,
        "projection": "perspective" if frame.is_perspective else "orthographic",
        "size": [frame.width, frame.height],
        "texel_m": frame.texel_m,
        "depth": {"scale_m": depth_scale_m(baked), "largest_m": float(baked.back_m.max())},
        "world_from_plane": (world @ frame.world_from_plane).tolist(),
        "source": frame.source.tolist(),
        "eye_in_plane": frame.eye.tolist(),
        "view_from_world": (camera.view_from_world @ np.linalg.inv(world)).tolist(),
        "clip_from_view": camera.clip_from_view.tolist(),
        "objects": [scene.object_names[i] for i in _ids(baked)],
        "critical_points": critical_points(baked.edges, scene.origin_ws),
        "covered_texels": int(baked.mask.sum()),
        "depth_edges": len(baked.edges.edges),
        "triangles": baked.triangles,
        "bytes": baked.bytes,
        "files": files,
        "how": list(HOW),
    }


def _ids(baked: BakedImpostor) -> list[int]:
    return [int(i) for i in np.unique(baked.object_id) if i >= 0]


def images_of(baked: BakedImpostor) -> dict[str, np.ndarray]:
    """Every image by its content; `object` counts the impostor's own objects from 1, 0 = none."""
    ids = _ids(baked)
    number = np.searchsorted(ids, baked.object_id) + 1
    own = np.where(baked.object_id >= 0, number, 0)
    return {"color": baked.color, "depth": baked.depth_m, "back": baked.back_m, "normal": baked.normal, "object": own}


def color_png(color: np.ndarray) -> np.ndarray:
    """(h, w, 4) uint8: linear colours as files hold them (sRGB), alpha straight."""
    return np.rint(srgb(color) * 255.0).astype(np.uint8)


def _pngs(baked: BakedImpostor) -> dict[str, bytes]:
    images, scale = images_of(baked), depth_scale_m(baked)
    values = {
        "color": color_png(images["color"]),
        "depth": np.rint(images["depth"] / scale).astype(np.uint16),
        "back": np.rint(images["back"] / scale).astype(np.uint16),
        "normal": np.rint(np.where(baked.mask[..., None], images["normal"] * 0.5 + 0.5, 0.5) * 65535.0).astype(np.uint16),
        "object": images["object"].astype(np.uint16),
        "mask": _mask(baked),
    }
    return {f"{content}.png": encode_png(value) for content, value in values.items()}


def _mask(baked: BakedImpostor) -> np.ndarray:
    """(h, w) uint8: white where there is something."""
    return np.where(baked.mask, np.uint8(255), np.uint8(0))


def _exrs(baked: BakedImpostor) -> dict[str, bytes]:
    images = images_of(baked)
    channels = {
        "color": dict(zip("RGBA", np.moveaxis(images["color"], -1, 0), strict=True)),
        "depth": {"Z": images["depth"], "ZBack": images["back"]},
        "normal": dict(zip("RGB", np.moveaxis(images["normal"], -1, 0), strict=True)),
        "object": {"Y": images["object"]},
    }
    types = {"object": np.uint32}
    files = {
        f"{content}.exr": encode_exr({key: np.ascontiguousarray(plane, types.get(content, np.float32)) for key, plane in planes.items()})
        for content, planes in channels.items()
    }
    return files | {"mask.png": encode_png(_mask(baked))}


def _npz(baked: BakedImpostor) -> dict[str, bytes]:
    buffer = io.BytesIO()
    np.savez(buffer, **images_of(baked), mask=baked.mask)
    return {"npz": buffer.getvalue()}


_ENCODERS: dict[str, Callable[[BakedImpostor], dict[str, bytes]]] = {"png": _pngs, "exr": _exrs, "npz": _npz}


def encoded(baked: BakedImpostor, kind: str) -> dict[str, bytes]:
    """The images as whole files of format 'png', 'exr' or 'npz', by content and suffix: 'depth.png'."""
    return _ENCODERS[kind](baked)


def write_impostor(stem: Path, baked: BakedImpostor, scene: Scene, kind: str) -> tuple[dict[str, object], list[Path]]:
    """Write images in format `kind` ('png', 'exr', 'npz') and the JSON, all names starting with `stem`; gives the JSON and the paths.

    Raises `OutputError`.
    """
    files, paths = {}, []
    for ending, data in encoded(baked, kind).items():
        path = stem.with_name(f"{stem.name}.npz" if ending == "npz" else f"{stem.name}_{ending}")
        write_bytes(path, data)
        files[ending.split(".")[0]] = path.name
        paths.append(path)
    data = metadata(baked, scene, files)
    path = stem.with_name(f"{stem.name}.json")
    write_json(path, data)
    return data, [*paths, path]
