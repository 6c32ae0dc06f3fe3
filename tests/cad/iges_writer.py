"""A small IGES writer: bilinear patches (entity 128), with a name and a colour each."""

import numpy as np

UNITS = {"in": "1,2HIN", "mm": "2,2HMM", "m": "6,1HM"}


def _hollerith(text):
    return f"{len(text)}H{text}"


def _section(text, letter, width=72):
    lines = [text[i : i + width] for i in range(0, len(text), width)]
    return [f"{line:<{width}}{letter}{i + 1:7d}" for i, line in enumerate(lines)]


def iges(patches, unit="mm"):
    """The text of a file of (4, 3) patches, corners in the order 00, 10, 01, 11."""
    head = [
        "1H,", "1H;", _hollerith("part"), _hollerith("a.igs"), _hollerith("writer"), _hollerith("1"), "32", "38", "6", "308", "15",
        _hollerith("part"), "1.0", UNITS[unit], "1", "0.01", _hollerith("20260101.000000"), "1.0E-06", "1000.0", _hollerith("me"),
        _hollerith("us"), "11", "0", _hollerith("20260101.000000"),
    ]  # fmt: skip
    directory, parameters = [], []
    for patch in patches:
        numbers = [0, 0, 1, 1, 0, 0, 1, 1, 1, 1, 1, 1, *np.ravel(patch).tolist(), 0, 1, 0, 1]
        text = "128,1,1,1,1,0,0,1,0,0," + ",".join(f"{float(n):.6f}" for n in numbers) + ";"
        first, entry = len(parameters) + 1, len(directory) + 1
        lines = [text[i : i + 64] for i in range(0, len(text), 64)]
        parameters += [f"{line:<64} {entry:7d}P{first + i:7d}" for i, line in enumerate(lines)]
        directory.append(f"{128:8d}{first:8d}" + "       0" * 6 + f"{'00000000':>8}D{entry:7d}")
        directory.append(f"{128:8d}{0:8d}{0:8d}{len(lines):8d}{0:8d}" + " " * 16 + f"{'':8}{0:8d}D{entry + 1:7d}")
    start, general = _section("made by a test", "S"), _section(",".join(head) + ";", "G")
    end = f"S{len(start):7d}G{len(general):7d}D{len(directory):7d}P{len(parameters):7d}"
    return "\n".join([*start, *general, *directory, *parameters, f"{end:<72}T{1:7d}"]) + "\n"
