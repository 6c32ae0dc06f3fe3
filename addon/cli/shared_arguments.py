"""The arguments that several commands take: inputs, view, light, method, results, batches. No bpy; nothing is done here.

Options about the method are made from `options.OPTIONS`; those not given are absent from the parsed namespace, so that a settings file or
the scene can speak.
"""

from __future__ import annotations

import argparse

from ..pipeline.render_passes import PASSES, USUAL_PASSES
from ..scene.cad.formats import SUFFIXES
from ..scene.cad.units import metres_per_unit, z_up_from
from ..scene.platform_deck.layout import FEWEST, MOST
from ..scene.reading.limits import Limits
from ..settings.impostor_options import IMPOSTOR_OPTIONS
from ..settings.light_options import LIGHT_OPTIONS
from ..settings.looks import LOOKS
from ..settings.option import Option
from ..settings.options import FROM_SCENE, OPTIONS
from ..settings.sky_options import SKY_OPTIONS
from ..settings.stage import MOST_PLANES
from ..settings.stage_options import STAGE_OPTIONS
from .argument_types import (
    between,
    checked_by,
    degrees_between,
    direction,
    finite,
    ground_word,
    number_of,
    numbers_of,
    pass_list,
    picture_size,
    positive,
    section_plane,
    vector,
)

VIEWS = ("iso", "front", "back", "left", "right", "top", "bottom")
FORMATS = ("png", "exr", "npz")
GIVEN = argparse.SUPPRESS
NO_BATCH = {"recursive": False, "resume": False, "jobs": 1, "contact_sheet": False, "worker": False}


def add_option(group: argparse._ArgumentGroup, option: Option) -> None:
    """One option of the method."""
    text = option.text.replace("%", "%%") + ("" if option.default is None else f" (default {_shown(option.default)})")
    common = {"dest": f"option_{option.name}", "help": text, "default": GIVEN}
    if option.name == "ground":
        group.add_argument(option.flag, type=ground_word, metavar="auto|off|HEIGHT", **common)
    elif option.kind == "choice":
        words = {str(identifier): identifier for identifier, _, _ in option.items}
        group.add_argument(option.flag, choices=words, **common)
    elif option.kind == "switch":
        group.add_argument(option.flag, action=argparse.BooleanOptionalAction, **common)
    elif option.kind == "numbers":
        group.add_argument(option.flag, type=numbers_of(option), metavar="A[,A…]", **common)
    elif option.kind == "color":
        group.add_argument(option.flag, type=numbers_of(option), metavar=_metavar(option), **common)
    else:
        group.add_argument(option.flag, type=number_of(option), metavar={"m": "METRES", "texel": "N"}.get(option.unit, "N"), **common)


def _metavar(option: Option) -> str:
    """A colour's numbers, and the word that leaves it to the scene."""
    return ("R,G,B,A" if option.width == 4 else "R,G,B") + ("|" + FROM_SCENE if option.is_optional else "")


def _shown(default: object) -> str:
    return ",".join(f"{v:g}" for v in default) if isinstance(default, tuple) else str(default)


STAGE = "edges, ground, sections"
SECTIONS = {
    "warp": ("warp", "eta", "warp_parameter", "pseudo_near", "convergence", "log_bend"),
    "partition": ("partition", "partitions", "cut", "split_weight", "alpha"),
    "map": ("map_size", "fit", "margin"),
    "shadow test": ("test", "depths", "bias_strategy", "bias", "epsilon", "epsilon_far", "id_per_material", "outlines"),
    "coarser casters": ("casters", "caster_error"),
    "filter": ("smoothing", "pcf", "filter_unit", "filter_width"),
    "picture": (
        "display",
        "samples",
        "light_strength",
        "own_sun",
        "exposure",
        "ambient_sky",
        "ambient_ground",
        "use_object_colors",
        "clay",
        "background",
    ),
    "lights and soft shadows": tuple(option.name for option in LIGHT_OPTIONS),
    "sky": tuple(option.name for option in SKY_OPTIONS),
    STAGE: tuple(option.name for option in STAGE_OPTIONS),
    "impostors": tuple(option.name for option in IMPOSTOR_OPTIONS),
}


def add_section_planes(group: argparse._ArgumentGroup) -> None:
    """`--section`, once for every plane."""
    group.add_argument(
        "--section",
        type=section_plane,
        action="append",
        metavar="X,Y,Z,NX,NY,NZ",
        help=f"cut away what a plane's normal points to: a point in the plane, and the normal; up to {MOST_PLANES} times",
    )


def add_method(parser: argparse.ArgumentParser, *sections: str) -> None:
    """The options of these sections."""
    by_name = {option.name: option for option in OPTIONS}
    if sections == tuple(SECTIONS):
        add_preset(parser)
    for section in sections:
        group = parser.add_argument_group(section)
        for name in SECTIONS[section]:
            add_option(group, by_name[name])
        if section == STAGE:
            add_section_planes(group)


def add_reporting(parser: argparse.ArgumentParser, folder: bool = True) -> None:
    """Where results go and how much is said."""
    group = parser.add_argument_group("results")
    if folder:
        group.add_argument("-o", "--output", metavar="DIR", help="folder to write to, made if needed (default: the current one)")
    group.add_argument("--report", metavar="FILE.json", help="write the report there; with several inputs a list of reports")
    group.add_argument(
        "--settings", metavar="FILE.toml", help="options by their long names (map_size = 2048), or tables as in the report's settings"
    )
    group.add_argument("--quiet", action="store_true", help="say nothing but errors")
    group.add_argument("--json", action="store_true", help="the report as JSON on standard output, and nothing else there")


def add_view(parser: argparse.ArgumentParser, has_light_direction: bool = True) -> None:
    """What is looked at, under which light."""
    group = parser.add_argument_group("view")
    which = group.add_mutually_exclusive_group()
    which.add_argument("--camera", metavar="NAME", help="a camera of the scene (default: its active one, else an isometric view)")
    which.add_argument("--view", choices=VIEWS, help="a view that frames everything")
    which.add_argument("--eye", type=vector, metavar="X,Y,Z", help="look from here, in metres")
    group.add_argument("--target", type=vector, metavar="X,Y,Z", help="look at this point (with --eye)")
    group.add_argument(
        "--up", type=direction, metavar="X,Y,Z", default=(0.0, 0.0, 1.0), help="what is up in the picture (with --eye; default 0,0,1)"
    )
    group.add_argument("--ortho", action="store_true", help="a parallel projection (with --view or --eye)")
    group.add_argument("--fov-y", type=degrees_between(0.0, 180.0), metavar="DEG", help="vertical field of view")
    group.add_argument("--near", type=finite, metavar="METRES", help="near distance of the view")
    group.add_argument("--far", type=finite, metavar="METRES", help="far distance of the view")
    group.add_argument(
        "--size", type=picture_size, metavar="WxH", help="picture size in pixels (default: the scene's, 1280x720 for CAD files)"
    )
    group.add_argument(
        "--frame", type=between(-(10**6), 10**6, is_whole=True), metavar="N", help="frame of the animation (default: the file's)"
    )
    group.add_argument("--scene", metavar="NAME", help="a scene of the .blend file (default: its active one)")
    group.add_argument("--view-layer", metavar="NAME", help="only this view layer of the scene")
    light = parser.add_argument_group("light").add_mutually_exclusive_group()
    light.add_argument(
        "--light",
        metavar="NAME",
        action="append",
        help="a light of the scene, may be given several times (default: all that reach the model, else a sun from the upper left)",
    )
    if has_light_direction:
        light.add_argument("--light-direction", type=direction, metavar="X,Y,Z", help="a sun; the direction towards it")
    else:
        parser.set_defaults(light_direction=None)


def add_inputs(parser: argparse.ArgumentParser) -> None:
    """What is drawn."""
    group = parser.add_argument_group("input")
    group.add_argument(
        "inputs",
        nargs="*",
        metavar="INPUT",
        help=f".blend or CAD file: {' '.join(SUFFIXES)}; a folder of such; or a pattern: parts/*{SUFFIXES[0]}",
    )
    group.add_argument(
        "--deck",
        type=between(FEWEST, MOST, is_whole=True),
        metavar="TRIANGLES",
        help="draw the example too: a procedural oil-platform deck of about so many triangles",
    )
    group.add_argument(
        "--example", type=between(FEWEST, MOST, is_whole=True), metavar="TRIANGLES", help="the same, but only when no INPUT is named"
    )
    group.add_argument(
        "--units",
        type=checked_by(metres_per_unit, "unit"),
        metavar="UNIT",
        help="unit of CAD files that do not say or say wrong: mm, cm, m, in, ft, …",
    )
    group.add_argument(
        "--up-axis", type=checked_by(z_up_from, "axis"), metavar="AXIS", help="axis that points up in CAD files: X, Y, Z, -X, -Y, -Z"
    )
    group.add_argument(
        "--limit-seconds",
        type=between(0, 10**6, is_whole=True),
        metavar="S",
        help=f"time that reading one CAD file may take (default {Limits().seconds}; 0: as long as it takes)",
    )
    group.add_argument(
        "--limit-memory",
        type=between(0, 10**8, is_whole=True),
        metavar="MIB",
        help="memory that reading one CAD file may take (default: three quarters of what there is)",
    )
    group.add_argument(
        "--crease-angle", type=degrees_between(-1e-9, 180.0), metavar="DEG", help="edges sharper than this look sharp (default 30)"
    )


def add_passes(parser: argparse.ArgumentParser) -> None:
    """Which passes, in which files."""
    group = parser.add_argument_group("output")
    group.add_argument(
        "--passes",
        type=pass_list(PASSES),
        metavar="PASS[,PASS…]",
        help=f"from {','.join(PASSES)} (default: combined; all but {', '.join(n for n in PASSES if n not in USUAL_PASSES)} for npz)",
    )
    group.add_argument(
        "--format", choices=FORMATS, default="png", help="png to look at, exr for exact values per pass, npz for all in one file"
    )


def add_batch(parser: argparse.ArgumentParser, makes_pictures: bool = True) -> None:
    """Many inputs in one run."""
    group = parser.add_argument_group("batch")
    group.add_argument("--recursive", action="store_true", help="folders stand for all CAD and .blend files below them, not only in them")
    group.add_argument(
        "--resume", action="store_true", help="skip inputs that an earlier run did with these options, unchanged since, results still there"
    )
    group.add_argument(
        "--jobs", type=positive, metavar="N", help="work on N inputs at once, in processes of their own; a crash costs only its input"
    )
    if makes_pictures:
        group.add_argument("--contact-sheet", action="store_true", help="also contact_sheet.png: all inputs' pictures, small, side by side")
    group.add_argument("--worker", action="store_true", help=argparse.SUPPRESS)


def add_preset(parser: argparse.ArgumentParser) -> None:
    """A preset below all other options of the method."""
    parser.add_argument_group("preset").add_argument(
        "--preset",
        metavar="NAME",
        help="start from a preset, not from the scene's settings: fast, balanced, sharp, oil-platform, single-part, reference, or yours",
    )
    parser.add_argument_group("look").add_argument(
        "--look",
        choices=tuple(LOOKS),
        metavar="NAME",
        help=f"colors, ambient light, edges and ground at once, over the scene's: {', '.join(LOOKS)}",
    )


def limits_of(args: argparse.Namespace) -> Limits:
    """What reading a CAD file may cost, as the options say."""
    asked = {"seconds": args.limit_seconds, "memory_mib": args.limit_memory}
    return Limits(**{name: value for name, value in asked.items() if value is not None})
