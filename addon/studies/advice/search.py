"""The search: theory prunes, a few frames rank, all frames decide, the neighbours of the best are tried, a real picture confirms.

`advise` is a generator: it yields a `Step` after every piece of work (tens of milliseconds), so that a window stays alive and Esc is heard;
its return value is the `Advice`. It stops trying more when the time is up and decides on what it has.
"""

from __future__ import annotations

import time
from collections.abc import Generator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ...maths.error.aliasing import error_statistics
from ...maths.shadow.projection import ShadowPlan
from ...maths.warping import WARP_METHODS
from ...settings.groups import Settings
from .candidates import Candidate, all_candidates, candidate_of, neighbours, predicted, pruned
from .goal import LARGEST_MAP, Goal
from .sampled_frame import SampledFrame, statistics
from .shadow_tests import TestedRow, chosen, compared

KEEP, FINALISTS = 14, 12  # combinations per fit that the theory leaves; those measured on all frames
FEW = 3  # frames of the first ranking
SAME = 1.03  # errors (or budgets) this close are alike: then fewer maps win
SECONDS = 120.0


@dataclass(frozen=True, slots=True)
class Step:
    """How far the search is: 0…1, and what it did."""

    fraction: float
    text: str


@dataclass(frozen=True, eq=False)
class Row:
    """One combination measured: at `size` texels per side and `maps` maps, over `frames` frames pooled.

    `measured` has the report's keys, `frame_p95` is the p95 of every frame, `predicted` the theory's ln(maps · max S).
    """

    candidate: Candidate
    size: int
    maps: int
    frames: int
    measured: dict[str, object]
    frame_p95: tuple[float, ...]
    predicted: float

    @property
    def texels(self) -> int:
        """Of all maps together."""
        return self.maps * self.size**2

    @property
    def m_p95(self) -> float:
        """The error that 95 % of the pixels keep below."""
        return self.measured["m_p95"]


@dataclass(frozen=True, eq=False)
class Advice:
    """What was found. `rows` the combinations measured on all frames, best first; `current` the scene's own one, at its own size.

    `best` None when nothing reaches the wanted error. `splits` the view depths at which the best's maps end, per frame; `confirmed` and
    `confirmed_current` statistics and milliseconds of real pictures of the frame where the best is worst. `tests` the shadow tests of the
    proposal in that frame, `test` the one proposed.
    """

    goal: Goal
    frames: tuple[SampledFrame, ...]
    rows: tuple[Row, ...]
    current: Row
    best: Row | None
    splits: tuple[tuple[float, ...], ...]
    confirmed: dict[str, object] | None
    confirmed_current: dict[str, object] | None
    tried: int
    notes: tuple[str, ...] = field(default=())
    tests: tuple[TestedRow, ...] = ()
    test: TestedRow | None = None

    def settings(self, base: Settings) -> Settings:
        """`base` with the proposal in place (unchanged when there is none)."""
        if self.best is None:
            return base
        proposal = self.best.candidate.settings(base, self.best.size)
        return proposal if self.test is None else replace(proposal, test=self.test.choice)


def advise(frames: Sequence[SampledFrame], goal: Goal, seconds: float = SECONDS) -> Generator[Step, None, Advice]:
    """Search for the best combination for these frames. All frames have lights.

    Raises `SceneError` when the light reaches nothing in view, `GpuError`, `Cancelled`.
    """
    search = _Search(tuple(frames), goal, time.monotonic() + seconds)
    return (yield from search.run())


class _Search:
    def __init__(self, frames: tuple[SampledFrame, ...], goal: Goal, deadline: float) -> None:
        self.frames, self.goal, self.deadline = frames, goal, deadline
        self.base = frames[0].job.settings
        self.few = tuple(frames[i] for i in sorted({round(i) for i in np.linspace(0, len(frames) - 1, min(FEW, len(frames)))}))
        self.maps: dict[tuple[str, int], int] = {}
        self.notes: list[str] = []
        self.tried = 0

    def run(self) -> Generator[Step, None, Advice]:
        """The stages in order."""
        for i, frame in enumerate(self.frames):
            yield Step(0.15 * i / len(self.frames), f"reading frame {frame.number}" if frame.number else "reading the picture")
            _ = frame.points
        listed = self._listed()
        ranked = yield from self._measured(listed, self.few, 0.15, 0.55)
        current = candidate_of(self.base)
        finalists = [row.candidate for row in self._ordered(ranked)[:FINALISTS]]
        finalists = list(dict.fromkeys([*finalists, *self._steady(ranked), current]))
        rows = ranked if self.few == self.frames else (yield from self._measured(finalists, self.frames, 0.55, 0.75))
        best = self._best(rows)
        if best is not None:
            more = [c for c in neighbours(best.candidate) if c not in {row.candidate for row in rows}]
            rows = rows + (yield from self._measured(more, self.frames, 0.75, 0.9))
            best = self._best(rows)
        yield Step(0.9, "rendering the proposal")
        return (yield from self._advice(rows, best, current))

    def _listed(self) -> list[Candidate]:
        """The combinations worth measuring: the theory's best of every fit, and the current one."""
        job = self.frames[0].job
        every = [c for c in all_candidates(self.base, job.camera.is_orthographic, job.light.kind) if self._size(c) is not None]
        if job.camera.is_orthographic:
            listed = every
        else:
            theory = {c: self._predicted(c) for c in every}
            fits = dict.fromkeys(c.fit for c in every)
            listed = [c for fit in fits for c in pruned(sorted((c for c in every if c.fit == fit), key=theory.__getitem__), KEEP)]
        return list(dict.fromkeys([candidate_of(self.base), *listed]))

    def _predicted(self, candidate: Candidate) -> float:
        """The theory's mean over a few frames; ∞ where it knows nothing."""
        if self.frames[0].job.camera.is_orthographic:
            return np.inf
        return float(np.mean([predicted(candidate, self.base, frame.view, self._count(candidate)) for frame in self.few]))

    def _count(self, candidate: Candidate) -> int:
        """How many maps the combination draws."""
        key = candidate.partition, candidate.count
        if key not in self.maps:
            self.maps[key] = len(self.frames[0].plan(candidate.settings(self.base, 64)).projections)
        return self.maps[key]

    def _size(self, candidate: Candidate) -> int | None:
        return self.goal.size_to_measure(self._count(candidate))

    def _measured(
        self, candidates: list[Candidate], frames: tuple[SampledFrame, ...], start: float, end: float
    ) -> Generator[Step, None, list[Row]]:
        """Rows of the candidates over these frames; those left when the time is up are not measured."""
        rows = []
        for i, candidate in enumerate(candidates):
            if rows and time.monotonic() > self.deadline:
                self._note("The time was up before all combinations were measured: give it more, or fewer frames.")
                break
            if self._size(candidate) is not None:
                rows.append(self._row(candidate, frames))
            self.tried += 1
            yield Step(start + (end - start) * (i + 1) / len(candidates), f"{candidate.warp}, {candidate.partition}, {candidate.fit}")
        return rows

    def _row(self, candidate: Candidate, frames: tuple[SampledFrame, ...], size: int | None = None) -> Row:
        """The combination over these frames: at `size`, at the budget's size, or (an error being wanted) at the size that error needs.

        Measured at one size; at another every m, an area, is that many texels smaller.
        """
        measured_at = size or self._size(candidate)
        settings = candidate.settings(self.base, measured_at)
        per_frame = [frame.errors(settings) for frame in frames]
        wanted = size or self.goal.size_for(measured_at, _p95(np.concatenate(per_frame))) or measured_at
        scale = (measured_at / wanted) ** 2
        per_frame = [e * np.array([scale, scale**0.5, scale**0.5]) for e in per_frame]
        return Row(
            candidate,
            wanted,
            self._count(candidate),
            len(frames),
            statistics(np.concatenate(per_frame)),
            tuple(_p95(e) for e in per_frame),
            self._predicted(candidate),
        )

    def _cost(self, row: Row) -> float:
        """What is to be small: the error, or the texels (∞ where the wanted error is out of reach)."""
        if self.goal.texels is not None:
            return row.m_p95
        return float(row.texels) if row.m_p95 <= self.goal.error * 1.001 else np.inf

    def _ordered(self, rows: list[Row]) -> list[Row]:
        return sorted(rows, key=lambda row: (self._cost(row), row.measured["m_p99"], row.maps))

    def _best(self, rows: list[Row]) -> Row | None:
        """The least cost; among those within `SAME` of it the one with the fewest maps, a logarithmic one (slow to draw) last."""
        least = min(self._cost(row) for row in rows)
        if least == np.inf:
            return None
        return min(
            (row for row in rows if self._cost(row) <= SAME * least),
            key=lambda row: (row.maps, WARP_METHODS[row.candidate.warp].log is not None, self._cost(row)),
        )

    def _steady(self, rows: list[Row]) -> list[Candidate]:
        """The best combinations that do not follow what is visible, for animations."""
        return [row.candidate for row in self._ordered(rows) if row.candidate.fit != "samples"][: FINALISTS // 3]

    def _note(self, text: str) -> None:
        if text not in self.notes:
            self.notes.append(text)

    def _advice(self, rows: list[Row], best: Row | None, current: Candidate) -> Generator[Step, None, Advice]:
        own = self._row_at_own_size(current)
        rows = self._ordered(rows)
        if best is None:
            self._note(f"No combination keeps 95 % of the pixels below m = {self.goal.error:g} with maps of at most {LARGEST_MAP}² texels.")
            return Advice(self.goal, self.frames, tuple(rows), own, None, (), None, None, self.tried, tuple(self.notes))
        self._note_about_flicker(rows, best)
        others = tuple(row for row in rows if row is not best)
        best, proof = self._confirmed(best)
        proposal, frame = best.candidate.settings(self.base, best.size), self._worst(best)
        splits = tuple(splits_of(one.plan(proposal)) for one in self.frames)
        tests = yield from self._tested(frame, proposal)
        test = chosen(tests)
        proof = {**proof, "total_ms": test.total_ms}
        today = frame.rendered(self.base)
        notes = tuple(self.notes)
        return Advice(self.goal, self.frames, (best, *others), own, best, splits, proof, today, self.tried, notes, tests, test)

    def _tested(self, frame: SampledFrame, proposal: Settings) -> Generator[Step, None, tuple[TestedRow, ...]]:
        """The shadow tests of the proposal, compared in one frame."""
        comparing, done = compared(frame, proposal), 0.92
        while True:
            try:
                yield Step(done, next(comparing))
            except StopIteration as stop:
                return stop.value
            done = min(done + 0.02, 1.0)

    def _worst(self, row: Row) -> SampledFrame:
        return self.frames[int(np.argmax(row.frame_p95))]

    def _confirmed(self, best: Row) -> tuple[Row, dict[str, object]]:
        """The proposal as a real picture of its worst frame; where that needs more texels for the wanted error, with those."""
        proof = self._worst(best).rendered(best.candidate.settings(self.base, best.size))
        ratio = proof["m_p95"] / max(best.frame_p95)
        if self.goal.error is None or ratio * best.m_p95 <= self.goal.error:
            return best, proof
        size = self.goal.size_for(best.size, ratio * best.m_p95)
        if size is None:
            return best, proof
        best = self._row(best.candidate, self.frames, size)
        return best, self._worst(best).rendered(best.candidate.settings(self.base, best.size))

    def _row_at_own_size(self, current: Candidate) -> Row:
        """The settings as they are, a warp set by hand included."""
        per_frame = [frame.errors(self.base) for frame in self.frames]
        measured = statistics(np.concatenate(per_frame))
        count, theory = self._count(current), self._predicted(current)
        return Row(current, self.base.fit.size, count, len(self.frames), measured, tuple(_p95(e) for e in per_frame), theory)

    def _note_about_flicker(self, rows: list[Row], best: Row) -> None:
        """The 'samples' fit follows what is visible, which jumps when something comes into view (docs/laboratory.md)."""
        other = next((row for row in rows if row.candidate.fit != "samples"), None)
        if len(self.frames) > 1 and best.candidate.fit == "samples" and other is not None:
            c = other.candidate
            self._note(
                "The 'samples' fit follows what is visible, so texel sizes can jump from frame to frame. The best steady one: "
                f"{c.warp}, {c.partition} × {c.count}, fit {c.fit}, {other.maps} × {other.size}², m p95 {other.m_p95:.3g}."
            )


def _p95(errors: np.ndarray) -> float:
    """The total m that 95 % of (Q, 3) errors keep below."""
    return error_statistics(errors[:, 0])["m_p95"]


def splits_of(plan: ShadowPlan) -> tuple[float, ...]:
    """The least view depth that a map serves and those at which the maps end, near to far, each once."""
    ranges = [p.depth_range for p in plan.projections]
    ends = np.unique(np.round([min(near for near, _ in ranges), *(far for _, far in ranges)], 6))
    return tuple(float(end) for end in ends)
