"""The life of impostors along a camera path: each frame drawn with them and without, what was predicted and what came out. No bpy."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import count
from math import inf, radians
from typing import TYPE_CHECKING

import numpy as np

from ...maths.relief.picture import PictureErrors, picture_errors
from ...pipeline.job import Job
from ...scene.asked_view import Lens
from ...scene.default_view import depth_range
from ...scene.records import Mark, Scene
from ..report import impostor_row, known
from ..run import run

if TYPE_CHECKING:
    from ...pipeline.frame import ImpostorReport
    from ...pipeline.impostors.records import ImpostorChoice, ImpostorGroup

FRAME_KEYS = (
    "index",
    "stage",
    "beta_screen",
    "beta_trans_p",
    "beta_trans_n",
    "critical_error",
    "critical_error_corrected",
    "regions_sum",
    "edge_sum_px",
    "psnr_db",
    "ssim",
    "silhouette_iou",
    "missing_pct",
    "false_pct",
)
"""The keys of a frame: the columns of the CSV."""
PREDICTED = {
    "critical_error": "critical",
    "critical_error_corrected": "critical_px",
    "regions_sum": "regions_sum",
    "edge_sum_px": "edge_sum_px",
}
MOST_NOTABLE_FIRST = ("geometry", "regenerated", "warp", "sprite", "hidden")
JUDGED_PASSES = ("combined", "object")
_serial = count(1)


@dataclass(frozen=True, eq=False)
class PathFrame:
    """One frame: `place` its frame number or angle, the impostors' `reports`, the `errors` of the picture against direct rendering, the
    picture (h, w, 4), the milliseconds that the surfaces took to draw either way, and the OpenGL used."""

    index: int
    place: float
    reports: tuple[ImpostorReport, ...]
    errors: PictureErrors
    picture: np.ndarray
    impostor_ms: float
    direct_ms: float
    gl: dict[str, str]

    def row(self) -> dict[str, object]:
        """The frame's keys. Of several impostors: the stage that says most, and the largest of each number.

        None where a number is not known (nothing captured yet, nothing in view) or infinite (the pictures are equal).
        """
        stage = min((MOST_NOTABLE_FIRST.index(r.stage) for r in self.reports), default=0)
        betas = [r.betas for r in self.reports if r.betas is not None]
        measured = self.errors
        return {
            "index": self.index,
            "stage": "geometry" if MOST_NOTABLE_FIRST[stage] == "hidden" else MOST_NOTABLE_FIRST[stage],
            "beta_screen": _largest(b.screen for b in betas),
            "beta_trans_p": _largest(b.trans_p for b in betas),
            "beta_trans_n": _largest(b.trans_n for b in betas),
            **{key: _largest(r.errors[name] for r in self.reports if name in r.errors) for key, name in PREDICTED.items()},
            "psnr_db": known(measured.psnr_db),
            "ssim": known(measured.ssim),
            "silhouette_iou": known(measured.silhouette_iou),
            "missing_pct": known(measured.missing_pct),
            "false_pct": known(measured.false_pct),
        }

    def detail(self, place_name: str) -> dict[str, object]:
        """What the row leaves out: where on the path, the times, each impostor with every predictor."""
        return {
            "index": self.index,
            place_name: self.place,
            "gbuffer_ms": {"impostors": self.impostor_ms, "direct": self.direct_ms},
            "impostors": [impostor_row(r) for r in self.reports],
        }


def _largest(values: Iterable[float]) -> float | None:
    return known(max(values, default=inf))


def orbit(job: Job, degrees: float, steps: int, groups: tuple[ImpostorGroup, ...]) -> Iterator[tuple[float, Job]]:
    """(angle in degrees, job) of `steps` + 1 views: the camera turned about the vertical axis through the middle of the groups' bounds.

    Near and far are those of the first view, widened for all views alike to what they may need.
    """
    ids = [i for group in groups for i in group.object_ids]
    boxes = job.scene.instance_bounds_ws()[np.isin(job.scene.instances.object_id, ids)]
    middle = (boxes[:, 0].min(axis=0) + boxes[:, 1].max(axis=0)) / 2.0
    angles = [degrees * step / steps for step in range(steps + 1)]
    cameras = [job.camera.carried(middle, radians(angle)) for angle in angles]
    ranges = np.array([depth_range(camera.view_from_world, job.scene) for camera in cameras])
    lens = Lens(near=min(job.camera.near, float(ranges[:, 0].min())), far=max(job.camera.far, float(ranges[:, 1].max())))
    for angle, camera in zip(angles, cameras, strict=True):
        yield angle, replace(job, camera=lens.on(camera))


def walk(
    jobs: Iterable[tuple[float, Job]],
    groups_of: Callable[[Scene], tuple[ImpostorGroup, ...]],
    choice: ImpostorChoice,
    on_frame: Callable[[PathFrame], None] = lambda frame: None,
) -> Iterator[PathFrame]:
    """Every frame of the path, in order, from a fresh start: nothing captured before counts. `on_frame` after each."""
    serial = next(_serial)
    for index, (place, job) in enumerate(jobs):
        groups = tuple(_own(group, serial) for group in groups_of(job.scene))
        ids = [i for group in groups for i in group.object_ids]
        asked = replace(job, passes=JUDGED_PASSES, measure=False)
        shown = run(replace(asked, impostors=replace(choice, groups=groups))).frame
        truth = run(replace(asked, impostors=None)).frame
        pictures = shown.passes["combined"], truth.passes["combined"]
        masks = (np.isin(frame.passes["object"], ids) for frame in (shown, truth))
        times = (float(frame.timing_ms["gbuffer"]) for frame in (shown, truth))
        frame = PathFrame(index, place, shown.impostors, picture_errors(*pictures, *masks), pictures[0], *times, shown.gl)
        on_frame(frame)
        yield frame


def _own(group: ImpostorGroup, serial: int) -> ImpostorGroup:
    """The group under a key of this path's own."""
    mark = group.key
    return replace(group, key=Mark("path " + mark.kind, mark.uid, (*mark.place, -serial), mark.name))


def summaries(frames: list[PathFrame]) -> list[dict[str, object]]:
    """One entry per impostor: how often it was captured and how long the captures lived, its stages, its texture."""
    rows: dict[object, list[ImpostorReport]] = {}
    for frame in frames:
        for report in frame.reports:
            rows.setdefault(report.key, []).append(report)
    return [_summary(reports) for reports in rows.values()]


def _summary(reports: list[ImpostorReport]) -> dict[str, object]:
    stages = [r.stage for r in reports]
    captures = stages.count("regenerated")
    used = sum(stage in ("sprite", "warp", "regenerated") for stage in stages)
    last = reports[-1]
    return {
        "name": last.name,
        "triangles": last.triangles,
        "captures": captures,
        "regenerations": max(captures - 1, 0),
        "frames_per_capture": used / captures if captures else None,
        "stages": {stage: stages.count(stage) for stage in dict.fromkeys(stages)},
        "limit": known(last.limit),
        "size": list(max(r.size for r in reports)),
        "bytes": max(r.bytes for r in reports),
    }


def csv_text(frames: list[PathFrame]) -> str:
    """The frames as CSV: the frames' keys as columns, empty where nothing is known."""
    text = io.StringIO()
    writer = csv.DictWriter(text, FRAME_KEYS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(frame.row() for frame in frames)
    return text.getvalue()
