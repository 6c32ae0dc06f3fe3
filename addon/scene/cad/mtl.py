"""The colours and base colour pictures of a Wavefront material file."""

from __future__ import annotations

import re
from pathlib import Path

from ..cad_model import CadImage, CadMaterial
from ..user_files import note, read_bytes
from .companions import MOST_MATERIALS, companion
from .losses import Losses
from .obj_lines import BOM, INLINE

OTHER_TEXTURES = (b"map_", b"bump", b"disp", b"decal", b"norm", b"refl")
OPTIONS = {b"-o": 3, b"-s": 3, b"-t": 3, b"-mm": 2}  # of a texture, with the numbers that may follow; all others are followed by one word
NUMBER = re.compile(rb"[-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?")


def text_of(name: bytes) -> str:
    """A name in UTF-8, else in the letters of Windows programs."""
    try:
        return name.decode("utf-8")
    except UnicodeDecodeError:
        return name.decode("cp1252", "replace")


def read_mtl(path: Path, losses: Losses) -> dict[object, CadMaterial]:
    """Materials by name. `Kd` is taken as linear, as Blender takes it, and white below a picture; `d` (or 1 − `Tr`) is the opacity, `Pm`
    and `Pr` metalness and roughness, `Ke` the glow. Pictures are noted as inputs; those that are missing, and textures of other kinds, as
    lost. Raises `OSError` when the file cannot be read; a number that cannot be leaves the default."""
    found: dict[bytes, dict[bytes, bytes]] = {}
    current: dict[bytes, bytes] = {}
    for line in read_bytes(path, MOST_MATERIALS).removeprefix(BOM).replace(b"\r", b"\n").split(b"\n"):
        words = line.split(None, 1)
        if len(words) < 2 or words[0].startswith(b"#"):
            continue
        rest = INLINE.sub(b"", words[1]).strip()
        if words[0].lower() == b"newmtl":
            current = found.setdefault(rest, {})
        else:
            current[words[0].lower()] = rest
    return {name: _material(path, text_of(name), values, losses) for name, values in found.items()}


def _material(path: Path, name: str, values: dict[bytes, bytes], losses: Losses) -> CadMaterial:
    image = _image(path, values[b"map_kd"], losses) if b"map_kd" in values else None
    for key, line in values.items():
        if key.startswith(OTHER_TEXTURES) and key != b"map_kd":
            _note(path, line)
            losses.add("texture{s} other than base colours (bumps, gloss, masks)", name)
    color = ((_floats(values.get(b"kd")) or [0.8]) * 3)[:3] if image is None else [1.0, 1.0, 1.0]
    metallic, roughness = (_floats(values.get(b"pm")) or [0.0])[0], (_floats(values.get(b"pr")) or [0.6])[0]
    glow = ((_floats(values.get(b"ke")) or [0.0]) * 3)[:3]
    return CadMaterial(name, (*color, _opacity(values)), metallic, roughness, image, False, tuple(glow))


def _opacity(values: dict[bytes, bytes]) -> float:
    """`d`, with or without -halo, else 1 − `Tr`. A `Tr` of 1 alone means opaque: so MeshLab and openMVS write it, and nobody writes what
    cannot be seen."""
    if (d := _floats(values.get(b"d", b"").removeprefix(b"-halo"))) != []:
        return d[0]
    tr = (_floats(values.get(b"tr")) or [0.0])[0]
    return 1.0 if tr == 1.0 else 1.0 - tr


def _floats(text: bytes | None) -> list[float]:
    try:
        return [min(max(float(word), 0.0), 1.0) for word in (text or b"").split()]
    except ValueError:
        return []


def _file_name(line: bytes) -> bytes:
    """What is left of a texture's line behind its options."""
    words = line.split()
    while words and words[0].startswith(b"-") and len(words) > 1:
        option = words.pop(0)
        most = OPTIONS.get(option, 1)
        while most and len(words) > 1 and (option not in OPTIONS or NUMBER.fullmatch(words[0])):
            words.pop(0)
            most -= 1
    return line[line.rindex(words[0]) :].strip() if len(words) == 1 else b" ".join(words)


def _companions(path: Path, line: bytes) -> list[Path]:
    """The files that a texture's line may mean: all of it, what stands behind its options, its last word."""
    names = (text_of(name) for name in dict.fromkeys((line, _file_name(line), line.split()[-1])) if name)
    return [file for name in names if (file := companion(path, name)) is not None]


def _note(path: Path, line: bytes) -> None:
    for file in _companions(path, line):
        note(file)


def _image(path: Path, line: bytes, losses: Losses) -> CadImage | None:
    found = _companions(path, line) if line else []
    if not found:
        losses.add("picture{s} that are missing beside it", text_of(_file_name(line)) if line else "")
        return None
    note(found[0])
    return CadImage(found[0].name, path=str(found[0].absolute()))
