"""The only translator from bpy to frozen arrays.

See `reader` (scene), `cameras`, `lights`, `meshes`, `materials`, `world`, `instances`, `marks`."""

from .cameras import camera_from_object, camera_from_region
from .lights import choose_light, light_from_object, reaches
from .marks import PROPERTY as IMPOSTOR_PROPERTY
from .marks import mark_of_id, marked
from .reader import Collected, SceneReader
from .world import world_of

__all__ = [
    "IMPOSTOR_PROPERTY",
    "Collected",
    "SceneReader",
    "camera_from_object",
    "camera_from_region",
    "choose_light",
    "light_from_object",
    "mark_of_id",
    "marked",
    "reaches",
    "world_of",
]
