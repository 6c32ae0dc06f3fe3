"""The report of one picture, a dictionary with the keys of docs/scripting.md, described in `report_schema.json`.

Unknown is None, an infinite warp parameter too. No bpy.
"""

from __future__ import annotations

import tomllib
from math import degrees, isfinite
from pathlib import Path
from typing import TYPE_CHECKING

from ..maths.error.aliasing import WarpedMap
from ..maths.error.theory import Resolution, map_row, unknown_row
from ..maths.shadow.projection import ShadowPlan, ShadowProjection
from ..pipeline.frame import Frame
from ..settings.groups import Settings
from ..settings.versions import KEY, VERSION

if TYPE_CHECKING:
    from ..pipeline.frame import ImpostorReport
    from ..pipeline.job import Job

TIMINGS = ("sync", "upload", "shadow", "gbuffer", "shade", "readback", "total")
CASTERS = ("caster_triangles", "caster_error_texels")
COUNTS = ("meshes", "instances", "triangles")


def extension_version() -> str:
    """The version in the manifest beside the package: the one place where it is written."""
    manifest = Path(__file__).resolve().parents[2] / "blender_manifest.toml"
    return tomllib.loads(manifest.read_text(encoding="utf-8"))["version"]


def known(value: float | None) -> float | None:
    """The number, or None where it is unknown or not finite."""
    return float(value) if value is not None and isfinite(value) else None


def report_of(job: Job, frame: Frame) -> dict[str, object]:
    """The report of a finished picture."""
    plan = frame.plan
    return {
        **head_of(job.name, frame.gl, job.settings),
        "gamma_deg": known(degrees(plan.gamma_rad)) if plan else None,
        "gamma_lim_deg": known(degrees(plan.gamma_lim_rad)) if plan else None,
        "partitions": partitions_of(job, plan) if plan else [],
        "measured": frame.measured,
        "timing_ms": _timing(job.sync_ms, frame.timing_ms),
        "geometry": geometry_of(frame),
        "lights": lights_of(frame),
        **({"impostors": [impostor_row(one) for one in frame.impostors]} if frame.impostors else {}),
        "warnings": [*job.warnings, *frame.warnings],
        "errors": [],
    }


def failed_report(name: str, settings: Settings | None, message: str) -> dict[str, object]:
    """The report of an input that could not be drawn: the same keys, nothing known but the reason."""
    return {
        **head_of(name, {}, settings),
        "gamma_deg": None,
        "gamma_lim_deg": None,
        "partitions": [],
        "measured": None,
        "timing_ms": dict.fromkeys(TIMINGS),
        "geometry": dict.fromkeys(COUNTS),
        "lights": [],
        "warnings": [],
        "errors": [message],
    }


def geometry_of(frame: Frame) -> dict[str, float | None]:
    """What was counted; where there are impostors also the triangles that the camera was spared by them, where maps were drawn with coarser
    meshes the triangles that all maps took, and the largest error of those meshes in texels."""
    names = (*COUNTS, "triangles_saved") if frame.impostors else COUNTS
    return {name: frame.geometry.get(name) for name in (*names, *(one for one in CASTERS if one in frame.geometry))}


def lights_of(frame: Frame) -> list[dict[str, object]]:
    """One entry per light that lights the picture: its samples, its share of the lights' time, the estimated error of its part."""
    spent = sum(light.ms or 0.0 for light in frame.lights)
    return [
        {
            "name": light.name,
            "kind": light.kind,
            "strength": known(light.strength),
            "samples": light.samples,
            "share_of_time": 1.0 if len(frame.lights) == 1 else light.ms / spent if light.ms is not None and spent > 0.0 else None,
            "error_estimate": known(light.error),
        }
        for light in frame.lights
    ]


def impostor_row(one: ImpostorReport) -> dict[str, object]:
    """One impostor in one picture: its stage and why, Schaufler's β, every predictor, what it takes and what it stands for."""
    betas = one.betas
    return {
        "name": one.name,
        "stage": one.stage,
        "reason": one.reason,
        "age": one.age,
        "error": known(one.error),
        "limit": known(one.limit),
        "tilt_deg": known(degrees(one.tilt_rad)),
        "beta_screen": known(betas.screen) if betas else None,
        "beta_trans_p": known(betas.trans_p) if betas else None,
        "beta_trans_n": known(betas.trans_n) if betas else None,
        "beta": known(betas.total) if betas else None,
        "predicted": {name: known(value) for name, value in one.errors.items()},
        "size": list(one.size),
        "bytes": one.bytes,
        "triangles": one.triangles,
    }


def head_of(name: str, gl: dict[str, str], settings: Settings | None) -> dict[str, object]:
    """What every report begins with: the input, this version, the OpenGL used, every effective setting."""
    return {
        "input": name,
        "version": extension_version(),
        "gl": {"renderer": gl.get("renderer"), "version": gl.get("version")},
        "settings": {KEY: VERSION, **_finite(settings.as_dict())} if settings else None,
    }


def _timing(sync_ms: float | None, timing_ms: dict[str, float | None]) -> dict[str, float | None]:
    timing = {name: timing_ms.get(name) for name in TIMINGS}
    timing["sync"] = sync_ms
    if sync_ms is not None and timing["total"] is not None:
        timing["total"] += sync_ms
    return timing


def partitions_of(job: Job, plan: ShadowPlan) -> list[dict[str, object]]:
    """One entry per shadow map, in the order the shader asks: bounds, n' and η of the map as fitted, and what the theory predicts for it.

    The predictions are None for orthographic views and for empty maps, of which the theory knows nothing.
    """
    return [_partition(index, job, plan, projection) for index, projection in enumerate(plan.projections)]


def warped_map(job: Job, plan: ShadowPlan, projection: ShadowProjection) -> WarpedMap | None:
    """A fitted map as the theory sees it: the view depths it serves and its n'. None for orthographic views and empty maps."""
    half_fov, log = job.camera.half_fov_rad, projection.log
    if half_fov <= 0.0 or projection.is_empty or not 0.0 < projection.depth_range[0] < projection.depth_range[1]:
        return None
    return WarpedMap(
        *projection.depth_range,
        half_fov,
        plan.gamma_rad,
        projection.warp_parameter,
        log is not None,
        log is None or log.perspective_s,
        log.bend if log is not None else 0.0,
    )


def _partition(index: int, job: Job, plan: ShadowPlan, projection: ShadowProjection) -> dict[str, object]:
    row, warped = unknown_row(index, *projection.depth_range), warped_map(job, plan, projection)
    if warped is not None:
        row = map_row(index, warped, projection.face >= 0, Resolution(job.settings.fit.size, job.size))
    fitted = {"warp_parameter": known(projection.warp_parameter), "eta": known(projection.eta)}
    return {key: _finite(value) for key, value in (row | fitted).items()}


def _finite(value: object) -> object:
    """Infinite numbers as None, in lists and dictionaries too: JSON has no infinity."""
    if isinstance(value, dict):
        return {key: _finite(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(one) for one in value]
    return known(value) if isinstance(value, float) else value
