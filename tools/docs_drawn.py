"""The pictures of docs/look.md, docs/light.md and docs/section.md, and the film of the README: all drawn by the program itself.

python -m tools.docs_drawn [NAME …] draws those of that name (all when none is given) into docs/img. Look at them before they are committed.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from math import cos, radians, sin
from pathlib import Path

from PIL import Image

from addon.__main__ import attached
from addon.cli.main import main as cad
from tools.docs_model import write

IMG = Path(__file__).resolve().parents[1] / "docs" / "img"
VIEW = ["--up-axis", "Z", "--units", "m", "--eye=0.47,-0.55,0.42", "--target=0.02,0,0.06", "--fov-y", "32"]
SUN = "--light-direction=0.3,-0.6,0.8"
FRAMES, FRAME_MS = 20, 90
LOOKS = "cad", "clay", "technical", "sun-study"


def drawn(model: Path, size: str, *options: str) -> Image.Image:
    """The model as `cad preview` draws it."""
    with tempfile.TemporaryDirectory() as folder:
        code = cad(["preview", str(model), *VIEW, "--size", size, "--quiet", *options, "-o", folder])
        if code:
            raise SystemExit(code)
        return Image.open(Path(folder) / "valve_combined.png").convert("RGB")


def section(model: Path) -> None:
    """A section with hatched caps."""
    _keep(drawn(model, "840x560", SUN, "--look", "cad", "--section", "0,0,0,0,-1,0", "--section-caps", "hatch"), "section.png")


def looks(model: Path) -> None:
    """Four looks side by side."""
    pictures = [drawn(model, "480x400", SUN, "--look", look) for look in LOOKS]
    sheet = Image.new("RGB", (2 * 480, 2 * 400))
    for index, picture in enumerate(pictures):
        sheet.paste(picture, (480 * (index % 2), 400 * (index // 2)))
    _keep(sheet, "looks.png")


def film(model: Path) -> None:
    """The sun goes round the valve, then a section opens it."""
    frames = []
    for frame in range(FRAMES):
        turn = radians(360.0 * frame / FRAMES - 60.0)
        sun = f"--light-direction={0.6 * cos(turn):.4f},{0.6 * sin(turn):.4f},0.8"
        frames.append(drawn(model, "480x360", sun, "--look", "cad"))
    for frame in range(FRAMES):
        place = f"0,{-0.1 + 0.1 * frame / (FRAMES - 1):.4f},0,0,-1,0"
        caps = ["--section", place, "--section-caps", "hatch"]
        frames.append(drawn(model, "480x360", "--light-direction=0.3,-0.5196,0.8", "--look", "cad", *caps))
    times = [FRAME_MS] * (len(frames) - 1) + [1500]
    path = IMG / "film.webp"
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=times, loop=0, quality=70, method=6)
    print(f"{path.name}: {len(frames)} frames, {path.stat().st_size // 1024} kB")


def _keep(picture: Image.Image, name: str) -> None:
    picture.quantize(256, dither=Image.Dither.FLOYDSTEINBERG).save(IMG / name, optimize=True)
    print(f"{name}: {picture.width}×{picture.height}, {(IMG / name).stat().st_size // 1024} kB")


DRAWN: dict[str, Callable[[Path], None]] = {"section": section, "looks": looks, "film": film}


def main() -> None:
    """Draw what is asked for."""
    with tempfile.TemporaryDirectory() as folder, attached():
        model = write(Path(folder))
        for name in sys.argv[1:] or DRAWN:
            DRAWN[name](model)


if __name__ == "__main__":
    main()
