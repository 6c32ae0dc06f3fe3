"""The settings stored with a scene: `scene.cad_shadow`. Declarations only, made from `options.OPTIONS`; no default is written here.

An optional number X has a switch `use_X` beside it: off means automatic. Every one has areas drawn again when it is set, also when a
script or an operator sets it; without an `update` Blender does so only for what is set in the window.
"""

from __future__ import annotations

from math import atan2, cos, hypot, pi, sin
from types import SimpleNamespace

import bpy
import numpy as np
from bpy.app.handlers import persistent
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty, PointerProperty

from ..maths.choices import PartitionChoice
from ..maths.shadow.slices import slice_count
from ..scene.cad_model import CREASED
from ..scene.mesh_prep import DEFAULT_CREASE_RAD
from ..settings.combinations import applies
from ..settings.groups import Settings
from ..settings.option import Option
from ..settings.options import OPTIONS, with_its_test, with_options
from ..settings.versions import LIGHTS_2, STRENGTH_1, TEST_1, light_since_1
from ..settings.versions import VERSION as SETTINGS_VERSION
from .animation import curves_of
from .redraw import on_change
from .section_properties import NAMES, CadShadowSection, planes_of
from .sun_properties import CadShadowSun

FLOAT_MAX = 3.4e38
MAX_SPLITS = 7

LIGHT_SOURCES = (
    (
        "AUTOMATIC",
        "Automatic",
        "The scene's strongest sun, else the lamp that lights most of what is seen, else a sun from the upper left that stands "
        "in the world",
    ),
    ("OBJECT", "Light Object", "The light object chosen below"),
    ("DIRECTION", "Direction", "A sun in the direction given below"),
    ("VIEW", "Follows the View", "A sun from the upper left of the view that turns with it, like a lamp on the camera"),
)


def _limits(option: Option, bound: float = FLOAT_MAX) -> dict[str, float]:
    low, high = max(option.low, -bound), min(option.high, bound)
    soft_low, soft_high = option.soft or (low, high)
    return {"min": low, "max": high, "soft_min": soft_low, "soft_max": soft_high}


def _number(option: Option, words: dict[str, str]) -> object:
    subtype = {"m": "DISTANCE", "texel": "PIXEL"}.get(option.unit, "NONE")
    if (option.low, option.high) == (0.0, 1.0):
        subtype = "FACTOR"
    default = option.start if option.is_optional else option.default
    return FloatProperty(**words, **_limits(option), default=default, subtype=subtype, precision=3)


def _choice(option: Option, words: dict[str, str]) -> object:
    return EnumProperty(**words, items=option.items, default=str(option.default))


def _count(option: Option, words: dict[str, str]) -> object:
    limits = {key: int(value) for key, value in _limits(option, 2**31 - 1).items()}
    return IntProperty(**words, **limits, default=option.default, subtype="PIXEL" if option.unit == "texel" else "NONE")


def _switch(option: Option, words: dict[str, str]) -> object:
    return BoolProperty(**words, default=option.default)


def _numbers(option: Option, words: dict[str, str]) -> object:
    return FloatVectorProperty(**words, **_limits(option), size=MAX_SPLITS, default=(option.start,) * MAX_SPLITS)


def _color(option: Option, words: dict[str, str]) -> object:
    default = option.start if option.is_optional else option.default
    return FloatVectorProperty(**words, **_limits(option), size=option.width, default=default, subtype="COLOR")


_MAKERS = {"number": _number, "choice": _choice, "count": _count, "switch": _switch, "numbers": _numbers, "color": _color}


def _annotations() -> dict[str, object]:
    """One Blender property per option, and the switch of each optional one."""
    made: dict[str, object] = {}
    for option in OPTIONS:
        options = {"ANIMATABLE"} if option.kind != "choice" else set()
        words = {"name": option.label, "description": option.text, "options": options, "update": on_change}
        made[option.name] = _MAKERS[option.kind](option, words)
        if option.is_optional:
            made["use_" + option.name] = BoolProperty(
                name=f"Set {option.label}",
                description=f"Set by hand instead of automatically: {option.text}",
                default=option.default is not None,
                options=set(),
                update=on_change,
            )
    return made


def _is_light(_settings: object, candidate: bpy.types.Object) -> bool:
    return candidate.type == "LIGHT" and candidate.data.type != "AREA"


def _turn_light(props: CadShadowSettings, azimuth_rad: float, elevation_rad: float) -> None:
    """Set the light's direction by its angles. Straight up there is a little left of the azimuth, so that it is kept."""
    across = max(cos(elevation_rad), 1e-4)
    props.light_direction = (across * cos(azimuth_rad), across * sin(azimuth_rad), sin(elevation_rad))


class CadShadowSettings(bpy.types.PropertyGroup):
    """Everything CAD Shadow Preview needs to know beside the scene's objects; `settings_from` turns it into checked `Settings`."""

    __annotations__ = _annotations() | {
        "settings_version": IntProperty(name="Settings Version", description="Version of these settings in the file", options={"HIDDEN"}),
        "crease_angle": FloatProperty(
            name="Crease Angle",
            description="Of models from CAD files without normals: edges sharper than this look sharp, softer ones are shaded smoothly",
            subtype="ANGLE",
            default=DEFAULT_CREASE_RAD,
            min=0.0,
            max=pi,
            options=set(),
            update=on_change,
        ),
        "light_source": EnumProperty(
            name="Light", description="Which light casts the shadows", items=LIGHT_SOURCES, options=set(), update=on_change
        ),
        "light": PointerProperty(
            name="Light Object",
            description="The sun, spot or point light that casts the shadows",
            type=bpy.types.Object,
            poll=_is_light,
            update=on_change,
        ),
        "light_direction": FloatVectorProperty(
            name="Light Direction",
            description="Where the light comes from: the direction towards it, in world axes",
            size=3,
            subtype="XYZ",
            default=(-1.0, -1.0, 2.0),
            soft_min=-1.0,
            soft_max=1.0,
            update=on_change,
        ),
        "light_azimuth": FloatProperty(
            name="Azimuth",
            description="Where the light comes from round the model: 0 from the right (X), 90 from behind (Y)",
            subtype="ANGLE",
            min=-2.0 * pi,
            max=2.0 * pi,
            options=set(),
            get=lambda self: atan2(self.light_direction[1], self.light_direction[0]),
            set=lambda self, value: _turn_light(self, value, self.light_elevation),
        ),
        "light_elevation": FloatProperty(
            name="Elevation",
            description="How high the light stands over the horizon",
            subtype="ANGLE",
            min=-pi / 2.0,
            max=pi / 2.0,
            options=set(),
            get=lambda self: atan2(self.light_direction[2], hypot(*self.light_direction[:2])),
            set=lambda self, value: _turn_light(self, self.light_azimuth, value),
        ),
        **{name: PointerProperty(name="Section", description="A section plane", type=CadShadowSection) for name in NAMES},
        "sun": PointerProperty(name="Sun", description="Place and time of the scene's sun", type=CadShadowSun),
    }

    @classmethod
    def register(cls) -> None:
        """Blender calls this when the class is registered."""
        bpy.types.Scene.cad_shadow = PointerProperty(type=cls, name="CAD Shadow Preview", description="Settings of the CAD shadow preview")

    @classmethod
    def unregister(cls) -> None:
        """Blender calls this when the class is unregistered."""
        del bpy.types.Scene.cad_shadow


def shortest(value: float) -> float:
    """The shortest decimal number that Blender would store as the same 32-bit float: 0.85 comes back as 0.85, not as 0.8500000238."""
    return float(str(np.float32(value)))


def seam_count(props: CadShadowSettings) -> int:
    """How many seams along the view the partitioning has (at least one): one less than slices, of which two halves share one."""
    choice = PartitionChoice(count=props.partitions, cut=props.cut)
    return max(slice_count(choice) - 1, 1)


def _value(props: CadShadowSettings, option: Option) -> object:
    if option.is_optional and not getattr(props, "use_" + option.name):
        return None
    value = getattr(props, option.name)
    if option.kind == "choice":
        return value
    if option.kind == "number":
        return shortest(value)
    if option.kind == "numbers":
        return tuple(shortest(v) for v in value)[: seam_count(props)]
    return tuple(shortest(v) for v in value) if option.kind == "color" else value


def settings_from(props: CadShadowSettings) -> Settings:
    """The scene's settings as a checked, frozen `Settings`. What does not apply, and so is not shown, is left at its default.

    Where both η and n' are set by hand, n' counts.
    """
    values = {option.name: _value(props, option) for option in OPTIONS}
    if not props.is_property_set("test"):
        values |= with_its_test({name: value for name, value in values.items() if name != "test"}, "test", Settings())
    shown = SimpleNamespace(**values)
    values = {option.name: values[option.name] if applies(option.name, shown) else option.default for option in OPTIONS}
    if values["alpha"] is not None and len(set(values["alpha"])) == 1:
        values["alpha"] = values["alpha"][:1]
    if values["warp_parameter"] is not None:
        values["eta"] = None
    return with_options(Settings(), values).replaced(section={"planes": planes_of(props)})


def store(props: CadShadowSettings, values: dict[str, object]) -> None:
    """Write option values (checked ones, by option name; None = automatic) into a scene's settings."""
    by_name = {option.name: option for option in OPTIONS}
    for name, value in values.items():
        option = by_name[name]
        if option.is_optional:
            setattr(props, "use_" + name, value is not None)
        if value is None:
            continue
        if option.kind == "choice":
            value = str(value)
        elif option.kind == "numbers":
            value = (*value, *(value[-1],) * MAX_SPLITS)[:MAX_SPLITS]
        setattr(props, name, value)


@persistent
def stamp_version(*_unused: object) -> None:
    """Before a file is saved, note the settings' version in every scene, so that later versions can migrate them."""
    for scene in bpy.data.scenes:
        scene.cad_shadow.settings_version = SETTINGS_VERSION


@persistent
def migrate(*_unused: object) -> None:
    """After a file is loaded, turn the settings of older versions into what they mean now. What no version ever saved is new."""
    for scene in bpy.data.scenes:
        if 0 < scene.cad_shadow.settings_version < SETTINGS_VERSION and scene.library is None:
            if scene.cad_shadow.settings_version == 1:
                _mark_creased(scene)
                _migrate_from_1(scene)
            store(scene.cad_shadow, {"lights": LIGHTS_2})
            scene.cad_shadow.settings_version = SETTINGS_VERSION


def _migrate_from_1(scene: bpy.types.Scene) -> None:
    """The scene keeps its look: its lights' brightness, the sky and background of the settings instead of the world, its shadow test."""
    props = scene.cad_shadow
    if not props.is_property_set("test"):
        store(props, {"test": TEST_1})
    strength = shortest(props.light_strength) if props.is_property_set("light_strength") else STRENGTH_1
    store(props, light_since_1(strength) | {name: tuple(getattr(props, name)) for name in ("ambient_sky", "ambient_ground", "background")})
    action = scene.animation_data.action if scene.animation_data else None
    for curve in curves_of(action) if action else ():
        if curve.data_path == "cad_shadow.light_strength":
            for key in curve.keyframe_points:
                for point in (key.co, key.handle_left, key.handle_right):
                    point[1] *= pi


def _mark_creased(scene: bpy.types.Scene) -> None:
    """Meshes that version 1 imported from CAD files keep the crease angle."""
    for collection in scene.collection.children_recursive:
        if "cad_units" in collection:
            for ob in collection.all_objects:
                if ob.type == "MESH" and ob.data.library is None and ob.data.normals_domain == "FACE":
                    ob.data[CREASED] = True


def register() -> None:
    """Attach the settings to scenes."""
    bpy.utils.register_class(CadShadowSettings)
    bpy.app.handlers.save_pre.append(stamp_version)
    bpy.app.handlers.load_post.append(migrate)


def unregister() -> None:
    """Detach the settings from scenes."""
    bpy.app.handlers.save_pre.remove(stamp_version)
    bpy.app.handlers.load_post.remove(migrate)
    bpy.utils.unregister_class(CadShadowSettings)
