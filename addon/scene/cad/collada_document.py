"""The XML of a COLLADA file: elements by their ids, arrays of numbers, materials. Source: COLLADA 1.4.1 and 1.5.0, chapter 5."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import unquote
from xml.etree import ElementTree

import numpy as np

from ..cad_model import CadImage, CadMaterial
from ..user_files import note
from .companions import companion
from .losses import Losses
from .text_numbers import numbers

Element = ElementTree.Element
SHADERS = ("phong", "blinn", "lambert", "constant")


def local(element: Element) -> str:
    """The tag without its namespace."""
    return element.tag.rpartition("}")[2]


def children(element: Element | None, *tags: str) -> list[Element]:
    """Those of the children that have one of these tags."""
    return [] if element is None else [one for one in element if local(one) in tags]


def found(element: Element | None, *path: str) -> Element | None:
    """The first element at the end of a path of tags."""
    for tag in path:
        element = next(iter(children(element, tag)), None)
    return element


class Collada:
    """A parsed document beside `path`."""

    def __init__(self, text: bytes, path: Path) -> None:
        self.root, self.path = ElementTree.fromstring(text), path
        self._by_id = {one.get("id"): one for one in self.root.iter() if one.get("id") is not None}
        self._arrays: dict[str, np.ndarray] = {}

    def target(self, url: str | None) -> Element | None:
        """The element that `#id` names."""
        return self._by_id.get((url or "").rpartition("#")[2])

    def numbers_of(self, url: str | None) -> np.ndarray:
        """(N, k) the values of a source, by its accessor's offset and stride; raises `ValueError` where they are not there."""
        key = url or ""
        if key not in self._arrays:
            source = self.target(key)
            accessor = found(source, "technique_common", "accessor")
            values = found(source, "float_array")
            values = values if values is not None else self.target(None if accessor is None else accessor.get("source"))
            if values is None:
                raise ValueError(f"the source {key[:40]} is used and is not there")
            data = numbers((values.text or "").encode(), np.float64)
            stride = int(accessor.get("stride", "1")) if accessor is not None else 3
            offset = int(accessor.get("offset", "0")) if accessor is not None else 0
            if stride < 1 or offset < 0:
                raise ValueError(f"the source {key[:40]} has a stride of {stride}")
            whole = data[offset:]
            self._arrays[key] = whole[: len(whole) // stride * stride].reshape(-1, stride)
        return self._arrays[key]

    def material(self, url: str | None, losses: Losses) -> tuple[CadMaterial, str | None] | None:
        """A material, and the name of the coordinates that its picture lies on; None where there is none."""
        element = self.target(url)
        link = found(element, "instance_effect")
        effect = None if link is None else self.target(link.get("url"))
        common = found(effect, "profile_COMMON")
        shader = next(iter(children(found(common, "technique"), *SHADERS)), None)
        if element is None or shader is None:
            return None
        name = element.get("name") or element.get("id") or "Material"
        diffuse = found(shader, "diffuse") if local(shader) != "constant" else found(shader, "emission")
        texture, color = found(diffuse, "texture"), _channels(found(diffuse, "color"), (0.8, 0.8, 0.8, 1.0))
        image = None if texture is None else self._image(common, texture.get("texture", ""), name, losses)
        rgb = (1.0, 1.0, 1.0) if image is not None else color[:3]
        alpha = 1.0 if found(shader, "transparent", "texture") is not None else _opacity(shader)
        glow = _channels(found(shader, "emission", "color"), (0.0, 0.0, 0.0, 1.0))[:3] if local(shader) != "constant" else (0.0, 0.0, 0.0)
        return CadMaterial(name, (*rgb, alpha), image=image, emission=tuple(glow)), None if texture is None else texture.get("texcoord")

    def _image(self, common: Element | None, sampler: str, owner: str, losses: Losses) -> CadImage | None:
        """The picture behind a texture: sampler → surface → image of 1.4, sampler → image of 1.5, or the image itself."""
        own = {one.get("sid"): one for one in children(common, "newparam")}
        surface = found(own.get(sampler), "sampler2D", "source")
        direct = found(own.get(sampler), "sampler2D", "instance_image")
        link = found(own.get(surface.text or ""), "surface", "init_from") if surface is not None else None
        image = self.target(direct.get("url") if direct is not None else link.text if link is not None else sampler)
        start = found(image, "init_from")
        start = found(start, "ref") if found(start, "ref") is not None else start
        name = unquote((start.text or "").strip()) if start is not None else ""
        path = companion(self.path, name.removeprefix("file://")) if name else None
        if path is None:
            losses.add("picture{s} that are missing beside it", name or owner)
            return None
        note(path)
        return CadImage(path.name, path=str(path.absolute()))


def _channels(element: Element | None, default: tuple[float, ...]) -> tuple[float, ...]:
    """Four numbers in 0…1."""
    values = [min(max(float(word), 0.0), 1.0) for word in (element.text or "").split()] if element is not None else []
    return (*values[:4], *default[len(values) :])


def _opacity(shader: Element) -> float:
    """From `transparent` and `transparency` in their four ways (§7, "Determining Transparency"); a whole transparency that would make all
    invisible is the mistake of exporters, and is opaque."""
    transparent, factor = found(shader, "transparent"), found(shader, "transparency", "float")
    if transparent is None and factor is None:
        return 1.0
    red, green, blue, alpha = _channels(found(transparent, "color"), (1.0, 1.0, 1.0, 1.0))
    luminance = 0.212671 * red + 0.715160 * green + 0.072169 * blue
    mode = "A_ONE" if transparent is None else transparent.get("opaque", "A_ONE")
    share = min(max(float(factor.text or "1"), 0.0), 1.0) if factor is not None else 1.0
    value = (luminance if mode.startswith("RGB") else alpha) * share
    opacity = 1.0 - value if mode.endswith("ZERO") else value
    return opacity if opacity > 0.0 else 1.0
