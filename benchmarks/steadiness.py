"""How steady texels are while the camera moves: `python -m benchmarks.steadiness` writes docs/steadiness.md; `… flicker [MODEL …]` measures
how much shadows flicker and writes docs/flicker.md (`flicker.py`).

The orbit of tests/orbit.py in steps of a degree; every warp in the default partitioning, every partition and sun in the default warp.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from addon.maths.choices import PARTITIONS, WARPS
from addon.maths.view import Light
from addon.pipeline.job import Job
from addon.pipeline.passes.gbuffer import surface_points_ws
from addon.scene.records import Scene
from addon.settings.groups import Settings
from addon.studies.run import run
from benchmarks import flicker
from benchmarks.tables import table
from tests.orbit import STEP_DEG, SUN, camera_at, largest_jump, orbited_scene, plan_at, sizes_by_face, sun_at

PAGE = Path(__file__).resolve().parents[1] / "docs" / "steadiness.md"
FITS = ("frustum", "scene", "samples")
DEFAULT = "lispsm-general"
ELEVATIONS = (-8.0, -3.0, 1.5, 3.0, 8.0, 20.0, 40.0)
ANGLES = np.arange(0.0, 181.0, STEP_DEG)
SEEN = (256, 144)  # pixels of the pictures whose surfaces the samples fit is given
INTRO = """# How steady texels are while the camera moves

Made by `python -m benchmarks.steadiness`; do not edit. A camera goes half round a floor with three boxes in steps of a degree, f/n = 100,
and the sun passes through its view axis behind it and ahead of it (tests/orbit.py; the other half is the mirror image). The largest change
of a map's texel (its side, or its extent along s or t, at the map's middle) from one frame to the next, and the degree where it begins.
Wanted: at most 1.25. With the `samples` fit texels follow what is visible: a slice that few pixels belong to is fitted closely, and opens
when a box comes into view.
"""


def visible(scene: Scene) -> list[np.ndarray]:
    """(P, 3) points of the visible surfaces at each place of the orbit."""
    chosen = Settings().replaced(fit={"size": 64}, shading={"samples": 1})
    frames = (run(Job(scene, camera_at(a), None, chosen, SEEN, ("depth",))).frame for a in ANGLES)
    depths = (frame.passes["depth"][::-1] for frame in frames)
    return [surface_points_ws(np.where(np.isfinite(d), d, 0.0), camera_at(a)) for a, d in zip(ANGLES, depths, strict=True)]


def worst(scene: Scene, points: list[np.ndarray], fit: str, warp: str = DEFAULT, sun: Light = SUN, **partition: object) -> str:
    """The largest jump and where."""
    slices = int(partition.get("count", 1))
    sizes = [
        sizes_by_face(plan_at(scene, a, warp, fit, sun, p if fit == "samples" else None, **partition), sun, slices)
        for a, p in zip(ANGLES, points, strict=True)
    ]
    jumps = [largest_jump(*pair) for pair in zip(sizes, sizes[1:], strict=False)]
    at = int(np.argmax(jumps))
    return f"{jumps[at]:.2f} at {ANGLES[at]:.0f}°"


def main() -> None:
    """Measure all, write the page."""
    if sys.argv[1:2] == ["flicker"]:
        flicker.main(sys.argv[2:])
        return
    scene = orbited_scene()
    points = visible(scene)
    cases = {f"{warp}, default partitioning": {"warp": warp} for warp in WARPS}
    cases |= {f"{warp}, one map": {"warp": warp, "kind": "none"} for warp in WARPS}
    cases |= {f"{DEFAULT}, {kind}": {"kind": kind, **({"count": 2} if kind == "faces-z" else {})} for kind in PARTITIONS if kind != "none"}
    cases |= {f"{DEFAULT}, default partitioning, sun {e:g}° above the axis": {"sun": sun_at(e)} for e in ELEVATIONS}
    lines = []
    for name, case in cases.items():
        lines.append((name, *(worst(scene, points, fit, **case) for fit in FITS)))
        print(*lines[-1], flush=True)
    PAGE.write_text(INTRO + "\n" + table(("method", *FITS), lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
