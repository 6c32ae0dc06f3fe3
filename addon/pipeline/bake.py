"""An impostor as images to keep: its colours beside the depths, normals and ids of the capture, read back. Worker thread only.

What is drawn in this program needs no colours (`impostors/capture.py`); what leaves it does. Colours are straight (not premultiplied),
linear, and go on a few texels beyond the outline under alpha 0, so that filtering brings in no black. Depth is never filtered.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..errors import DriverError, GpuError, SceneError
from ..maths.relief.frame import capture_frame
from ..maths.relief.warp import CaptureFrame
from ..scene.looks import PLAIN_LOOKS
from .device import Device
from .impostors.baked import BakedImpostor
from .impostors.capture import capture, capture_bytes
from .impostors.records import ImpostorChoice, ImpostorGroup
from .job import Job
from .renderer import Ticket, render_frame

BORDER_TEXELS = 8
BAKED_PASSES = ("combined", "depth", "normal", "object")


def bake(device: Device, job: Job, group: ImpostorGroup, choice: ImpostorChoice, unlit: bool = False) -> BakedImpostor:
    """Capture `group` of `job`'s scene for its camera and size, shaded by its light and shadows; `unlit` gives bare surface colours.

    Raises `SceneError` when there is nothing to capture, or it lies behind or around the camera; `GpuError` when it is too large.
    """
    rows = np.isin(job.scene.instances.object_id, group.object_ids)
    if not rows.any():
        raise SceneError(f"'{group.name}' has no surface to capture: it is empty, hidden, or holds no mesh.")
    boxes = job.scene.instance_bounds_ws()[rows]
    low, high = boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)
    hull = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    try:
        frame = capture_frame(hull, job.camera, job.size, choice.settings)
        taken = capture(device, device.store.sync(job.scene), rows, frame, with_back=choice.settings.back_layer, choice=choice.edges)
    except SceneError as error:
        raise SceneError(f"'{group.name}': {error}") from error
    taken.release()
    passes = _shaded(device, job, rows, frame, unlit)
    mask = np.isfinite(passes["depth"])
    if not mask.any():
        raise SceneError(f"'{group.name}' is thinner than the texels everywhere: come nearer, or raise the texels per pixel.")
    plane = -float(frame.source[2]) if frame.is_perspective else 0.0
    depth = np.where(mask, np.maximum(np.where(mask, passes["depth"], 0.0) - plane, 0.0), 0.0).astype(np.float32)
    counts = np.array([len(m.triangles) for m in job.scene.meshes])
    return BakedImpostor(
        group.name,
        frame,
        _straight(passes["combined"], mask),
        depth,
        np.where(mask & taken.mask, np.maximum(taken.back_m, depth), depth),
        mask,
        passes["normal"],
        passes["object"],
        taken.edges,
        int(counts[job.scene.instances.mesh_index[rows]].sum()),
        capture_bytes(frame),
        {"renderer": device.context.info["GL_RENDERER"], "version": device.context.info["GL_VERSION"]},
    )


def _shaded(device: Device, job: Job, rows: np.ndarray, frame: CaptureFrame, unlit: bool) -> dict[str, np.ndarray]:
    """The passes of the texture: these instances alone before nothing, in the shadows of all."""
    shading = {"background": (0.0, 0.0, 0.0, 0.0)}
    if unlit:
        shading |= {"ambient_sky": (1.0, 1.0, 1.0), "ambient_ground": (1.0, 1.0, 1.0), "display": "shaded"}
    scene = replace(job.scene, looks=np.tile(PLAIN_LOOKS, (len(job.scene.looks), 1))) if unlit else job.scene
    asked = replace(
        job,
        scene=scene,
        camera=frame.camera(),
        light=None if unlit else job.light,
        settings=job.settings.replaced(shading=shading),
        size=(frame.width, frame.height),
        passes=BAKED_PASSES,
        measure=False,
        impostors=None,
        shown=rows,
    )
    return render_frame(device, asked, Ticket()).passes


def _straight(premultiplied: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Colours (h, w, 4) divided by their coverage, continued beyond the outline, alpha 1 where the mask is."""
    coverage = premultiplied[..., 3]
    known = coverage > 1e-3
    color = np.zeros_like(premultiplied)
    color[known, :3] = premultiplied[known, :3] / coverage[known, None]
    color[..., :3] = dilated(color[..., :3], known, BORDER_TEXELS)
    color[..., 3] = mask
    return color


def dilated(image: np.ndarray, known: np.ndarray, texels: int) -> np.ndarray:
    """`image` (h, w, c) where `known` (h, w), continued by the mean of the neighbours known so far, `texels` times; else 0."""
    color, weight = np.where(known[..., None], image, 0.0), known.astype(np.float32)
    for _ in range(texels):
        total, count = _around(color), _around(weight[..., None])
        grows = (weight == 0.0) & (count[..., 0] > 0.0)
        color[grows] = total[grows] / count[grows]
        weight[grows] = 1.0
    return color.astype(np.float32)


def _around(image: np.ndarray) -> np.ndarray:
    """The sum of the four neighbours of every pixel."""
    padded = np.pad(image, ((1, 1), (1, 1), (0, 0)))
    return padded[:-2, 1:-1] + padded[2:, 1:-1] + padded[1:-1, :-2] + padded[1:-1, 2:]


def bake_all(
    device: Device, job: Job, ticket: Ticket, choice: ImpostorChoice, unlit: bool = False
) -> list[BakedImpostor | SceneError | GpuError]:
    """Every group of `choice` baked (a task of the renderer); in the place of one that could not be, its error."""
    out = []
    for number, group in enumerate(choice.groups):
        ticket.enter(number / len(choice.groups), "capturing")
        try:
            out.append(bake(device, job, group, choice, unlit))
        except DriverError:
            raise
        except (SceneError, GpuError) as error:
            out.append(error)
    return out
