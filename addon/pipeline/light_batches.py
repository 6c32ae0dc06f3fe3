"""What each light took and how far its samples are from their mean: found while they are added up. Worker thread only.

A small picture of the same view is added up in batches of a light's samples; how much the batches differ tells the error of their mean.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from ..maths.view import Light, LightSource
from .frame import LightReport
from .gl.readback import read_texture
from .many_lights import SummedView

LARGEST = 96
"""Pixels of the small picture's longer side."""
BATCHES = 4


def probe_size(size: tuple[int, int]) -> tuple[int, int]:
    """Of the small picture."""
    shrunk = min(1.0, LARGEST / max(size))
    return max(1, round(size[0] * shrunk)), max(1, round(size[1] * shrunk))


def standard_error(batches: Sequence[np.ndarray]) -> float | None:
    """Root mean square of s / √B over pixels and channels, of B ≥ 2 batches' means of one shape; None for fewer."""
    if len(batches) < 2:
        return None
    variance = np.var(np.asarray(batches, np.float64), axis=0, ddof=1) / len(batches)
    return float(np.sqrt(variance.mean()))


class LightBatches:
    """Notes of the lights of one picture, each of which has `rounds` samples; `probe` the view of the small picture, None: no errors."""

    def __init__(self, sources: Sequence[LightSource], rounds: int, probe: SummedView | None) -> None:
        self._sources, self._rounds, self.probe = sources, rounds, probe
        self._means: list[list[np.ndarray]] = [[] for _ in sources]
        self._seconds = [0.0 for _ in sources]
        self._light, self._count = -1, 0
        self._begin = time.perf_counter()

    def begin(self, source: int) -> None:
        """A hard light of that source is next."""
        self._begin = time.perf_counter()
        if source != self._light:
            self._light, self._count = source, 0
            if self.probe is not None:
                self.probe.sums.clear()

    def end(self, part: float) -> None:
        """It is added, also to the small picture's sums."""
        if self.probe is not None:
            self.probe.sums.added(part)
            self._count += 1
            if self._count >= max(1, self._rounds // BATCHES):
                self._means[self._light].append(read_texture(self.probe.sums.textures[0])[..., :3] / self.probe.sums.total)
                self.probe.sums.clear()
                self._count = 0
        self._seconds[self._light] += time.perf_counter() - self._begin

    def reports(self) -> tuple[LightReport, ...]:
        """What to say of each light."""
        return tuple(self._report(i, source) for i, source in enumerate(self._sources))

    def _report(self, i: int, source: LightSource) -> LightReport:
        error = standard_error(self._means[i]) if source.is_soft else 0.0
        shared = None if error is None else error / len(self._sources)
        samples = self._rounds if source.is_soft else 1
        return LightReport(source.name, source.kind, strength_of(source), samples, self._seconds[i] * 1e3, shared)


def strength_of(source: LightSource) -> float | None:
    """Mean of the channels of a light's colour; None of what has none."""
    return sum(source.color) / 3.0 if isinstance(source, Light) else None


def unmeasured(sources: Sequence[LightSource], rounds: int) -> tuple[LightReport, ...]:
    """What to say of lights that nobody watched."""
    return tuple(LightReport(one.name, one.kind, strength_of(one), rounds if one.is_soft else 1) for one in sources)


def alone(light: Light | None) -> tuple[LightReport, ...]:
    """The report of a picture that one hard light lights."""
    return () if light is None else (LightReport(light.name, light.kind, strength_of(light), 1, None, 0.0),)
