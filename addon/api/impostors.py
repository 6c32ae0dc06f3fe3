"""Impostors for scripts: captured as arrays, and their life along a camera path. Reached as `api.impostors`, `api.impostor_path`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import bpy
import numpy as np

from ..blender.impostors.chosen import ChosenImpostors
from ..blender.impostors.plane import make_plane
from ..blender.rendering import animated, read
from ..errors import SceneError, UserError
from ..maths.relief.warp import CaptureFrame
from ..pipeline.impostors.baked import BakedImpostor
from ..pipeline.job import Job
from ..studies.impostors.asked import baked, choice_for
from ..studies.impostors.files import critical_points, metadata, write_impostor
from ..studies.impostors.path import PathFrame, csv_text, orbit, summaries, walk
from ..studies.outputs import write_bytes
from .view import wish_for


@dataclass(frozen=True, eq=False)
class Impostor:
    """A captured impostor. Images are (height, width[, channels]) arrays, row 0 at the top."""

    baked: BakedImpostor
    job: Job

    @property
    def name(self) -> str:
        """What it was captured of."""
        return self.baked.name

    @property
    def color(self) -> np.ndarray:
        """(h, w, 4) float32 linear, straight alpha."""
        return self.baked.color

    @property
    def depth_m(self) -> np.ndarray:
        """(h, w) float32 metres behind the plane of the first surface; 0 where `mask` is False."""
        return self.baked.depth_m

    @property
    def back_m(self) -> np.ndarray:
        """(h, w) float32 metres behind the plane of where the solid behind the first surface ends."""
        return self.baked.back_m

    @property
    def mask(self) -> np.ndarray:
        """(h, w) bool."""
        return self.baked.mask

    @property
    def normal(self) -> np.ndarray:
        """(h, w, 3) float32, world axes."""
        return self.baked.normal

    @property
    def object_id(self) -> np.ndarray:
        """(h, w) int32 into `job.scene.object_names`, −1 = none."""
        return self.baked.object_id

    @property
    def frame(self) -> CaptureFrame:
        """The quad and the projection; its world is relative to `job.scene.origin_ws`."""
        return self.baked.frame

    @property
    def metadata(self) -> dict[str, object]:
        """All needed to draw it elsewhere: the JSON of the command `impostor`."""
        return metadata(self.baked, self.job.scene, {})

    @property
    def critical_points(self) -> list[dict[str, object]]:
        """The critical point of every region, the largest step in depth first, in true world coordinates."""
        return critical_points(self.baked.edges, self.job.scene.origin_ws)

    def save(self, stem: str | Path, kind: str = "png") -> list[Path]:
        """Write images ('png', 'exr' or 'npz') and JSON, all names beginning with `stem`; gives the paths. Raises `OutputError`."""
        return write_impostor(Path(stem), self.baked, self.job.scene, kind)[1]

    def to_plane(self, collection: bpy.types.Collection | None = None) -> bpy.types.Object:
        """A plane at its place whose material shows it, images packed; in `collection` (default: the scene's)."""
        plane = make_plane(self.baked, self.metadata)
        (collection or bpy.context.scene.collection).objects.link(plane)
        return plane


@dataclass(frozen=True, eq=False)
class ImpostorPath:
    """The life of impostors along a path: `rows` one entry per frame, with the CSV's columns; `impostors` one summary per impostor."""

    frames: tuple[PathFrame, ...]

    @property
    def rows(self) -> list[dict[str, object]]:
        """One dictionary per frame: stage, predicted and measured errors; None where nothing is known."""
        return [frame.row() for frame in self.frames]

    @property
    def impostors(self) -> list[dict[str, object]]:
        """Captures, frames per capture, stages and size of each impostor."""
        return summaries(list(self.frames))

    def save(self, path: str | Path) -> None:
        """Write the rows as CSV. Raises `OutputError`."""
        write_bytes(Path(path), csv_text(list(self.frames)).encode())


def impostors(
    objects: Sequence[str] | None = None, *, scene: bpy.types.Scene | None = None, unlit: bool = False, **arguments: object
) -> tuple[Impostor, ...]:
    """Capture impostors from a view: of the objects, empties or collections named (patterns too), else of those marked, else of everything.

    `arguments` are those of `preview`: the view, the light, and options of the method. Raises `SceneError` when one cannot be captured.
    """
    scene = scene or bpy.context.scene
    chosen = ChosenImpostors.of(objects, scene.name)
    job = read(scene, replace(wish_for(scene, **arguments), marked=chosen.holders))
    results = baked(job, chosen.some(job.scene), unlit)
    for result in results:
        if isinstance(result, UserError):
            raise result
    return tuple(Impostor(result, job) for result in results)


def impostor_path(
    objects: Sequence[str] | None = None,
    *,
    orbit_deg: float | None = None,
    steps: int | None = None,
    frames: tuple[int, int] | None = None,
    scene: bpy.types.Scene | None = None,
    **arguments: object,
) -> ImpostorPath:
    """Run the life of impostors along an orbit of `orbit_deg` in `steps`, or along the animation's `frames` (first, last).

    Every frame is drawn with impostors and without, and compared. Other arguments as for `impostors`.
    """
    scene = scene or bpy.context.scene
    if (orbit_deg is None) == (frames is None):
        raise SceneError("Say where the camera goes: orbit_deg=… or frames=(first, last).")
    wish = wish_for(scene, **{"impostor_break_even": False} | arguments)
    chosen = ChosenImpostors.of(objects, scene.name)
    wish.marked = chosen.holders
    first = read(scene, wish)
    groups = chosen.some(first.scene)
    if orbit_deg is not None:
        jobs: Iterator[tuple[float, Job]] = orbit(first, orbit_deg, steps or max(round(abs(orbit_deg)), 1), groups)
    else:
        jobs = animated(scene, wish, *frames)
    return ImpostorPath(tuple(walk(jobs, chosen.groups, choice_for(groups, first.settings.impostor, exact=True))))
