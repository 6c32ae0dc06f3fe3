"""The only translator from bpy to frozen arrays. See `reader` (scene), `cameras`, `lights`, `meshes`, `materials`, `instances`."""

from .cameras import camera_from_object, camera_from_region
from .lights import choose_light, light_from_object, reaches
from .reader import SceneReader

__all__ = ["SceneReader", "camera_from_object", "camera_from_region", "choose_light", "light_from_object", "reaches"]
