"""Stage times of this checkout beside another one's, frame by frame in turns, on the same views:

    python -m benchmarks.stages ../other [--frames 9]     medians of G-buffer and map pass, and their ratio, for the table of docs/scale.md

Each checkout draws in a process of its own, on the deck of a million triangles and on two dev models where they are here. A checkout from
before e2e8f34 needs a child that calls the renderer as it was then: `git show 1de6f70:benchmarks/stages.py > FILE`, `--child-file FILE`.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path
from statistics import median

MODELS = ("deck", "huldra_utilities.glb", "amazing_hand.glb")
STAGES = ("gbuffer", "shadow")
CAD_DEV = Path(__file__).resolve().parents[2] / "shared" / "cad" / "dev"


def draw(name: str) -> None:
    """The child: a frame a line of input, its stage times a line of output. Uses only what checkouts since e2e8f34 have in common."""
    import numpy as np

    from addon.pipeline.job import Job
    from addon.pipeline.renderer import Renderer
    from addon.settings.groups import Settings
    from addon.studies.run import run
    from benchmarks.models import load
    from benchmarks.views import lights, views

    if name == "deck":
        import benchmarks.models as models

        models.DECK = {"triangles": 1_000_000, "seed": 1, "length_m": 480.0}
    scene, renderer = load(name), Renderer()
    view = views(name, scene)[0]
    light = lights(view.camera)["side"]
    middle = scene.bounds_ws().mean(axis=0)
    for number, _ in enumerate(sys.stdin):
        camera = view.camera.carried(middle, number * np.radians(1.0))
        frame = run(Job(scene, camera, light, Settings(), (1280, 720), ("combined",), measure=False), on=renderer).frame
        print(json.dumps({stage: frame.timing_ms[stage] for stage in STAGES}), flush=True)


def child(checkout: Path, name: str, script: Path = Path(__file__)) -> subprocess.Popen[str]:
    """The process that draws with that checkout's program."""
    environment = {**os.environ, "PYTHONPATH": str(checkout)}
    command = [sys.executable, str(script.resolve()), "--child", name]
    return subprocess.Popen(command, cwd=checkout, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def times(process: subprocess.Popen[str]) -> dict[str, float]:
    """One frame."""
    process.stdin.write("\n")
    process.stdin.flush()
    while not (line := process.stdout.readline()).startswith("{"):
        if not line:
            raise SystemExit("The other process ended: see its message above.")
    return json.loads(line)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("other", type=Path, nargs="?")
    parser.add_argument("--frames", type=int, default=9)
    parser.add_argument("--child-file", type=Path, default=Path(__file__), help="the script that draws with the other checkout")
    parser.add_argument("--child")
    choice = parser.parse_args()
    if choice.child:
        draw(choice.child)
        return
    print("| scene | stage | other, ms | this, ms | this / other |\n|---|---|---|---|---|")
    for name in (m for m in MODELS if m == "deck" or (CAD_DEV / m).is_file()):
        pair = [child(choice.other.resolve(), name, choice.child_file), child(Path(__file__).resolve().parents[1], name)]
        rows = [[times(process) for process in pair] for _ in range(choice.frames + 1)][1:]
        for stage in STAGES:
            before, after = (median(row[k][stage] for row in rows) for k in (0, 1))
            print(f"| {name} | {stage} | {before:.1f} | {after:.1f} | {after / before:.3f} |", flush=True)
        for process in pair:
            process.stdin.close()
            process.wait()


if __name__ == "__main__":
    main()
