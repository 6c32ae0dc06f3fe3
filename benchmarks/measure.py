"""Many settings against one truth: every view and light is traced once, every setting rendered and compared with it."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import cache
from hashlib import blake2b
from pathlib import Path
from statistics import fmean, median
from time import perf_counter
from typing import Any

from addon.errors import SceneError
from addon.maths.view import Light
from addon.pipeline.job import Job
from addon.scene.records import Scene
from addon.settings.groups import Settings
from addon.studies.run import run
from addon.studies.truth import TruthTracer, compare
from addon.studies.truth.compare import COMPARED_PASSES
from benchmarks import models, views

Key = tuple[str, str, str, str]


@dataclass(frozen=True)
class Row:
    """One picture measured: where, with what, and what came out. `m_*` the measured error m, `*_ms` of the renderer's stages."""

    model: str
    view: str
    kind: str
    light: str
    method: str
    depth_ratio: float
    pixels: int
    misclassified_pct: float | None
    acne_pct: float | None
    leak_pct: float | None
    edge_px_p95: float | None
    m_p95: float | None
    m_max: float | None
    shadow_ms: float
    shade_ms: float
    code: str = ""

    @property
    def key(self) -> Key:
        """What a row is the measurement of; `code` says by which state of the renderer."""
        return self.model, self.view, self.light, self.method


@cache
def code_mark() -> str:
    """Eight hex digits that change with the renderer's sources (maths, pipeline, shaders); an export without git has them too."""
    addon = Path(__file__).resolve().parents[1] / "addon"
    files = sorted(path for folder in ("maths", "pipeline", "shaders") for path in (addon / folder).glob("*.*"))
    return blake2b(b"".join(path.read_bytes() for path in files), digest_size=4).hexdigest()


def measure(
    names: Iterable[str],
    methods: Mapping[str, Settings],
    elevations: tuple[float, ...] = (),
    only_first_view: bool = False,
    size: tuple[int, int] = views.SIZE,
    known: Container[Key] = (),
    every: int = 1,
    lamps: bool = False,
) -> Iterator[Row]:
    """Rows of every model × view × light × method, in that order, but those whose key is `known`. A view in which nothing faces the
    light is left out.

    `elevations` (degrees) replaces the five lights by suns at these heights, from the side, `lamps` by spots and point lights; `every` n-th
    light only.
    """
    for name in names:
        scene = models.load(name)
        tracer = TruthTracer(scene, "embree")
        for view in views.views(name, scene)[: 1 if only_first_view else None]:
            suns = views.elevated(view.camera, elevations) if elevations else views.lights(view.camera)
            for light_name, light in list((views.lamps(view.camera, scene) if lamps else suns).items())[::every]:
                wanted = {method: s for method, s in methods.items() if (name, view.name, light.name, method) not in known}
                if light.kind == "point":  # six maps, not parted
                    wanted = {method: s for method, s in wanted.items() if s.partition.z_count == 1}
                if not wanted:
                    continue
                begin = perf_counter()
                yield from _measure_light(name, scene, tracer, view, light, wanted, size)
                print(f"{name} {view.name} {light_name}: {perf_counter() - begin:.1f} s", file=sys.stderr, flush=True)


def _measure_light(
    name: str, scene: Scene, tracer: TruthTracer, view: views.View, light: Light, methods: Mapping[str, Settings], size: tuple[int, int]
) -> Iterator[Row]:
    truth = tracer.trace(view.camera, light, size)
    if not truth.lit_facing.any():
        return
    ratio = views.depth_ratio(truth.depth)
    for method, settings in _grouped(methods):
        frame = run(Job(scene, view.camera, light, settings, size=size, passes=COMPARED_PASSES)).frame
        result, _ = compare(frame, truth, view.camera, light, settings.fit.size, tracer)
        numbers = {key: result[key] for key in ("pixels", "misclassified_pct", "acne_pct", "leak_pct", "edge_px_p95")}
        yield Row(
            name,
            view.name,
            view.kind,
            light.name,
            method,
            ratio,
            **numbers,
            m_p95=frame.measured["m_p95"],
            m_max=frame.measured["m_max"],
            shadow_ms=frame.timing_ms["shadow"],
            shade_ms=frame.timing_ms["shade"],
            code=code_mark(),
        )


def _grouped(methods: Mapping[str, Settings]) -> Iterator[tuple[str, Settings]]:
    """Those that read the same maps follow one another: the renderer draws them once. The first of them says what the maps cost."""
    shared: dict[tuple, list[str]] = {}
    for method, settings in methods.items():
        shared.setdefault(
            (settings.warp, settings.partition, settings.fit, settings.test.kind, settings.test.depths, settings.test.has_outlines), []
        ).append(method)
    yield from ((name, methods[name]) for names in shared.values() for name in names)


def kept(path: Path, rows: Iterator[Row], others: Iterable[Row] = ()) -> None:
    """`path` anew: `others` (rows of an earlier run that stay), then the rows as they come, one JSON object a line.

    So a long run that is stopped leaves what it has, and can be resumed.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", encoding="utf-8") as file:
        for part in (others, rows):
            for row in part:
                file.write(json.dumps(asdict(row)) + "\n")
                file.flush()


def kept_by_model(path: Path, names: Iterable[str], measure: Callable[[str], object]) -> dict[str, Any]:
    """What is kept in a JSON file by model, with the models named measured anew, each written as soon as it is there."""
    kept = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    for name in names:
        kept[name] = measure(name)
        path.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    return kept


def read(path: Path) -> list[Row]:
    """Rows that `kept` wrote."""
    return [Row(**json.loads(line)) for line in path.read_text(encoding="utf-8").splitlines()]


def mean(rows: Iterable[Row], key: str) -> float:
    """Mean of a column over rows where it is known; raises `SceneError` when there is none."""
    values = [getattr(row, key) for row in rows if getattr(row, key) is not None]
    if not values:
        raise SceneError(f"No row has a value of {key}.")
    return fmean(values)


def middle(rows: Iterable[Row], key: str) -> float:
    """Median of a column over rows where it is known."""
    return median(getattr(row, key) for row in rows if getattr(row, key) is not None)


def where(rows: Iterable[Row], **equal: object) -> list[Row]:
    """Rows whose columns have these values (a tuple: one of them)."""
    return [row for row in rows if all(getattr(row, k) in v if isinstance(v, tuple) else getattr(row, k) == v for k, v in equal.items())]
