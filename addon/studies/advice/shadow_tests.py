"""Which shadow test suits a proposal: real pictures with each, against the picture of the most exact test there is.

No number of texels does what a better test does (docs/quality.md): m says how large a texel is, and how wrong an edge may be only while the
test reads edges from texels.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, replace

import numpy as np

from ...maths.shadow.lookup import towards_light
from ...settings.groups import Settings, ShadowTestChoice
from ...settings.shadowing import SHADOW_TESTS
from .sampled_frame import FACING, SampledFrame, quick

EXACT = "triangle"
FINER = 2  # times the side of the maps, for the picture that the others are compared with
LARGEST_MAP = 8192
ALIKE_PCT = 0.02  # of the pixels: the cheapest test that differs by no more is proposed


@dataclass(frozen=True, slots=True)
class TestedRow:
    """One test of the proposal's maps: its choice, the pixels that differ from the most exact picture, and the picture's time."""

    choice: ShadowTestChoice
    differs_pct: float
    total_ms: float

    @property
    def options(self) -> dict[str, object]:
        """By the names of `options.OPTIONS`, those that a proposal may change."""
        return {"test": self.choice.kind, "outlines": self.choice.outlines, "depths": self.choice.depths}


def candidates(own: ShadowTestChoice) -> list[ShadowTestChoice]:
    """Every test with the scene's own filter and, where it has them, depths; the cheapest first, the exact one with outlines last."""
    tests = [replace(own, kind=k, depths=own.depths if "depths" in row.options else 1, outlines=False) for k, row in SHADOW_TESTS.items()]
    return [*tests, replace(own, kind=EXACT, depths=1, outlines=True)]


def compared(frame: SampledFrame, proposal: Settings) -> Generator[str, None, tuple[TestedRow, ...]]:
    """A row per candidate, in their order; yields what it is about to draw."""
    choices = candidates(proposal.test)
    yield "rendering the most exact shadows"
    finest = {"size": min(FINER * proposal.fit.size, max(LARGEST_MAP, proposal.fit.size))}
    truth, _ = _shadows(frame, replace(proposal.replaced(fit=finest), test=choices[-1]))
    rows = []
    for choice in choices:
        yield f"rendering with the {choice.kind} test"
        wanted = replace(proposal, test=choice)
        _shadows(frame, wanted)  # the first picture may compile and upload
        shown, total_ms = _shadows(frame, wanted)
        rows.append(TestedRow(choice, 100.0 * float((np.abs(shown - truth) > 0.5).mean()), total_ms))
    return tuple(rows)


def chosen(rows: tuple[TestedRow, ...]) -> TestedRow:
    """The cheapest that differs by at most `ALIKE_PCT`, or else by the least."""
    return next((row for row in rows if row.differs_pct <= ALIKE_PCT), min(rows, key=lambda row: row.differs_pct))


def _shadows(frame: SampledFrame, settings: Settings) -> tuple[np.ndarray, float]:
    """What the shadow lets through at the pixels that face the light, and milliseconds."""
    from ...pipeline.passes.gbuffer import seen_surface  # loads OpenGL
    from ..run import run

    job = replace(frame.job, settings=quick(settings), passes=("depth", "normal", "shadow"), measure=False)
    picture = run(job).frame
    seen, points = seen_surface(picture.passes["depth"], job.camera)
    facing = (picture.passes["normal"][::-1][seen] * towards_light(job.light, points)).sum(axis=1) > FACING
    return picture.passes["shadow"][::-1][seen][facing], picture.timing_ms["total"]
