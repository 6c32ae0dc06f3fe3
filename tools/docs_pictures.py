"""The screenshots of the documentation: those that its pages show, taken from the last `./dev gui-test` (build/gui) into docs/img/gui.

Reduced to 256 colours, which screenshots bear, and to 1200 pixels in width; a sidebar ends below its last line of text. Look at each one
before it is committed: the GUI test says that something is there, not that it is beautiful.
"""

import argparse
import re
import sys
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
SHOWN = re.compile(r"\(img/gui/([a-z0-9_]+\.png)\)")
WIDEST = 1200
SIDEBAR_PX, MARGIN_PX, TEXT_GREY = 400, 16, 180


def shown_names() -> list[str]:
    """The pictures that the pages ask for."""
    return sorted({name for page in DOCS.glob("*.md") for name in SHOWN.findall(page.read_text(encoding="utf-8"))})


def without_empty_end(sidebar: Image.Image) -> Image.Image:
    """A sidebar cut off below the last row with light text in it (the tabs at its right do not count)."""
    grey = np.asarray(sidebar.convert("L"))[:, : int(0.8 * sidebar.width)]
    rows = np.flatnonzero((grey >= TEXT_GREY).any(axis=1))
    return sidebar.crop((0, 0, sidebar.width, min(int(rows[-1]) + MARGIN_PX, sidebar.height))) if len(rows) else sidebar


def take(name: str, taken: Path) -> None:
    """One picture, made small."""
    image = Image.open(taken / name).convert("RGB")
    if image.width <= SIDEBAR_PX:
        image = without_empty_end(image)
    if image.width > WIDEST:
        image = image.resize((WIDEST, round(image.height * WIDEST / image.width)), Image.Resampling.LANCZOS)
    target = DOCS / "img" / "gui" / name
    target.parent.mkdir(parents=True, exist_ok=True)
    image.quantize(256, dither=Image.Dither.NONE).save(target, optimize=True)
    print(f"{target.relative_to(ROOT)}  {image.width}×{image.height}, {target.stat().st_size // 1024} kB")


def main() -> int:
    """Take all that are there; exit code 1 when one that a page shows is neither in build/gui nor in docs already."""
    parser = argparse.ArgumentParser(prog="python -m tools.docs_pictures", description="Take the screenshots that the documentation shows.")
    parser.add_argument("--taken", type=Path, default=ROOT / "build" / "gui", help="the GUI test's pictures (default: build/gui)")
    taken = parser.parse_args().taken
    missing = []
    for name in shown_names():
        if (taken / name).is_file():
            take(name, taken)
        elif not (DOCS / "img" / "gui" / name).is_file():
            missing.append(name)
    if missing:
        print(f"run ./dev gui-test first: {', '.join(missing)} are shown in the documentation and not in {taken}", file=sys.stderr)
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
