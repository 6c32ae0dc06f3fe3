"""The scenes that are measured: CAD files and the procedural deck, read as a user's are (file → Blender objects → frozen arrays)."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import bpy

from addon.blender.cad_import import to_blender
from addon.blender.snapshot import SceneReader
from addon.scene.cad import read
from addon.scene.platform_deck import build
from addon.scene.records import Scene

CAD_DEV = Path(__file__).resolve().parents[2] / "shared" / "cad" / "dev"
DECK = {"triangles": 500_000, "seed": 1, "length_m": 240.0}
DEV_MODELS = (
    "tower_crane.glb",
    "huldra_utilities.glb",
    "duplex_house.obj",
    "iea15_floating_turbine.stl",
    "industrial_ladder.obj",
    "robile_housing.obj",
    "hand_wheel_valve.ply",
    "featuretype.step",
    "cycloidal_drive_mm.glb",
    "amazing_hand.glb",
    "tray_bottom_mm.stl",
)


@cache
def load(name: str) -> Scene:
    """A scene by name: 'deck', or a file of the dev models. Blender's data is emptied before and after."""
    model = build(**DECK) if name == "deck" else read(CAD_DEV / name)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    to_blender(model, bpy.context.scene.collection)
    scene = SceneReader().read(bpy.context.evaluated_depsgraph_get())
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return scene


def available() -> tuple[str, ...]:
    """Names that can be loaded here: the deck, and the dev models where they lie beside the checkout."""
    return ("deck", *(name for name in DEV_MODELS if (CAD_DEV / name).is_file()))
