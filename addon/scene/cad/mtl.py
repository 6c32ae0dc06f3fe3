"""The colours of a Wavefront material file. Textures and everything that needs them are left out."""

from __future__ import annotations

from pathlib import Path

from ..cad_model import CadMaterial
from ..user_files import read_bytes
from .companions import MOST_MATERIALS, note_all

TEXTURES = (b"map_", b"bump", b"disp", b"decal", b"norm", b"refl")


def read_mtl(path: Path) -> dict[bytes, CadMaterial]:
    """Materials by name. `Kd` is taken as linear, as Blender takes it; `d` (or 1 − `Tr`) is the opacity, `Pm` and `Pr` metalness and
    roughness. Textures are noted as inputs. Raises `OSError` when the file cannot be read; a number that cannot be leaves the default."""
    found: dict[bytes, dict[bytes, list[float]]] = {}
    current: dict[bytes, list[float]] = {}
    textures = set()
    for line in read_bytes(path, MOST_MATERIALS).split(b"\n"):
        words = line.split(None, 1)
        if len(words) < 2:
            continue
        if words[0].lower().startswith(TEXTURES):
            textures.update((words[1], words[1].split()[-1]))  # the whole line is the name, or its last word after options
        if words[0] == b"newmtl":
            current = found.setdefault(words[1].strip(), {})
        else:
            current[words[0]] = _floats(words[1])
    note_all(path, (name.strip().decode("utf-8", "surrogateescape") for name in textures))
    return {name: _material(name, values) for name, values in found.items()}


def _floats(text: bytes) -> list[float]:
    try:
        return [min(max(float(word), 0.0), 1.0) for word in text.split()]
    except ValueError:
        return []


def _material(name: bytes, values: dict[bytes, list[float]]) -> CadMaterial:
    color = (values.get(b"Kd") or [0.8]) * 3
    alpha = values[b"d"][0] if values.get(b"d") else 1.0 - (values.get(b"Tr") or [0.0])[0]
    metallic, roughness = (values.get(b"Pm") or [0.0])[0], (values.get(b"Pr") or [0.6])[0]
    return CadMaterial(name.decode("utf-8", "replace"), (*color[:3], alpha), metallic, roughness)
