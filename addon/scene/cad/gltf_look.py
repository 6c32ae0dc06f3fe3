"""The materials, lights and cameras of a glTF document. Source: the Khronos specification, §3.9, and the extensions named here."""

from __future__ import annotations

from math import cos, pi
from typing import Any
from urllib.parse import unquote

import numpy as np

from ..cad_model import CadCamera, CadImage, CadLight, CadMaterial
from ..user_files import note
from .companions import companion
from .gltf_document import Document, data_of
from .losses import Losses

SPEC_GLOSS = "KHR_materials_pbrSpecularGlossiness"
OTHER_TEXTURES = ("normalTexture", "occlusionTexture", "emissiveTexture")
PICTURES = (b"\x89PNG", b"\xff\xd8\xff", b"RIFF", b"BM")
UNSEEN_IMAGES = ("KHR_texture_basisu", "MSFT_texture_dds")
LUMENS_PER_WATT = 683.0  # of the eye at its best wavelength: glTF's photometric units to Blender's radiometric ones
FAINTEST_LUX = 50.0


def materials_of(document: Document, losses: Losses) -> tuple[list[CadMaterial], list[dict | None]]:
    """All materials in order, and of each the texture reference (`index`, `texCoord`, `extensions`) of its base colour, or None."""
    made = [_material(document, material, number, losses) for number, material in enumerate(document.entries("materials"))]
    return [material for material, _ in made], [texture for _, texture in made]


def _material(document: Document, material: dict, number: int, losses: Losses) -> tuple[CadMaterial, dict | None]:
    extensions = material.get("extensions", {})
    plain, gloss = material.get("pbrMetallicRoughness", {}), extensions.get(SPEC_GLOSS)
    name = material.get("name") or f"Material {number}"
    if gloss is not None:
        color, texture = gloss.get("diffuseFactor"), gloss.get("diffuseTexture")
        metallic, roughness = 0.0, 1.0 - _unit(gloss.get("glossinessFactor", 1.0))
    else:
        color, texture = plain.get("baseColorFactor"), plain.get("baseColorTexture")
        metallic, roughness = _unit(plain.get("metallicFactor", 1.0)), _unit(plain.get("roughnessFactor", 1.0))
    rgba = _channels(color, 4, 1.0)
    if material.get("alphaMode", "OPAQUE") == "OPAQUE":
        rgba = (*rgba[:3], 1.0)
    image = None if texture is None else _image(document, texture, name, losses)
    others = sum(key in material for key in OTHER_TEXTURES) + sum(key in plain for key in ("metallicRoughnessTexture",))
    losses.add("texture{s} other than base colours (bumps, metal, glow)", name, others)
    strength = extensions.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
    glow = [] if "emissiveTexture" in material else material.get("emissiveFactor")
    emission = tuple(float(strength) * c for c in _channels(glow, 3, 0.0))
    transmission = _unit(extensions.get("KHR_materials_transmission", {}).get("transmissionFactor", 0.0))
    return CadMaterial(name, rgba, metallic, roughness, image, False, emission, transmission), texture if image is not None else None


def _unit(value: Any) -> float:
    return min(max(float(value), 0.0), 1.0)


def _channels(values: object, count: int, default: float) -> tuple[float, ...]:
    """That many numbers in 0…1; the default where they are not there."""
    given = values if isinstance(values, list) and len(values) >= count else [default] * count
    return tuple(_unit(value) for value in given[:count])


def _image(document: Document, reference: dict, owner: str, losses: Losses) -> CadImage | None:
    """The picture of a texture; what cannot be shown is noted under the material's name."""
    texture = document.entry("textures", reference.get("index"))
    extensions = texture.get("extensions", {})
    source = extensions.get("EXT_texture_webp", {}).get("source", texture.get("source"))
    if source is None:
        kind = next((name for name in UNSEEN_IMAGES if name in extensions), "no picture")
        losses.add(f"base colour texture{{s}} of a kind that is not read ({kind})", owner)
        return None
    image = document.entry("images", source)
    name = image.get("name") or unquote(str(image.get("uri", ""))[:200]).rpartition("/")[2] or f"Image {source}"
    uri, data = str(image.get("uri", "")), None
    if "bufferView" in image:
        data = bytes(document.view(image["bufferView"])[0])
    elif uri.startswith("data:"):
        name, data = image.get("name") or f"Image {source}", data_of(uri)
    if data is not None:
        if data.startswith(PICTURES):
            return CadImage(name, data=data)
        losses.add("picture{s} of a kind that is not read", name)
        return None
    path = companion(document.path, unquote(uri))
    if path is None:
        losses.add("picture{s} that are missing beside it", unquote(uri))
        return None
    note(path)
    return CadImage(name, path=str(path.absolute()))


def transformed_uvs(uvs: np.ndarray, reference: dict) -> np.ndarray:
    """(…, 2) float32 coordinates after KHR_texture_transform, v upwards as Blender has it."""
    change = reference.get("extensions", {}).get("KHR_texture_transform", {})
    u, v = uvs[..., 0], uvs[..., 1]
    if change:
        angle = float(change.get("rotation", 0.0))
        (sx, sy), (ox, oy) = change.get("scale", (1.0, 1.0)), change.get("offset", (0.0, 0.0))
        c, s = np.float32(np.cos(angle)), np.float32(np.sin(angle))
        u, v = u * np.float32(sx), v * np.float32(sy)
        u, v = c * u + s * v + np.float32(ox), c * v - s * u + np.float32(oy)
    return np.stack([u, np.float32(1.0) - v], axis=-1)


def lights_of(document: Document) -> list[CadLight]:
    """The lights of KHR_lights_punctual, in Blender's units.

    Writers for the web give a sun of 3 where the standard wants 100,000 lux: where no light of the file is above `FAINTEST_LUX`, its
    numbers are taken as watts, as their viewers show them.
    """
    lights = document.entries("extensions", "KHR_lights_punctual", "lights")
    brightest = max((float(light.get("intensity", 1.0)) for light in lights), default=0.0)
    return [_light(light, number, LUMENS_PER_WATT if brightest > FAINTEST_LUX else 1.0) for number, light in enumerate(lights)]


def _light(light: dict, number: int, per_watt: float) -> CadLight:
    kind = {"directional": "sun", "point": "point", "spot": "spot"}[light["type"]]
    energy = float(light.get("intensity", 1.0)) / per_watt * (1.0 if kind == "sun" else 4.0 * pi)  # candela are per steradian
    spot = light.get("spot", {})
    outer, inner = float(spot.get("outerConeAngle", pi / 4.0)), float(spot.get("innerConeAngle", 0.0))
    blend = (cos(inner) - cos(outer)) / (1.0 - cos(outer)) if kind == "spot" and outer > 0.0 else 0.0
    name = light.get("name") or f"Light {number}"
    return CadLight(name, kind, _channels(light.get("color"), 3, 1.0), energy, 2.0 * outer if kind == "spot" else 0.0, _unit(blend))


def cameras_of(document: Document) -> list[CadCamera]:
    """The document's cameras."""
    return [_camera(camera, number) for number, camera in enumerate(document.entries("cameras"))]


def _camera(camera: dict, number: int) -> CadCamera:
    name = camera.get("name") or f"Camera {number}"
    if camera["type"] == "orthographic":
        own = camera["orthographic"]
        return CadCamera(name, None, 2.0 * float(own["ymag"]), float(own["znear"]), float(own["zfar"]))
    own = camera["perspective"]
    return CadCamera(name, float(own["yfov"]), 0.0, float(own.get("znear", 0.1)), float(own["zfar"]) if "zfar" in own else None)
