"""The command line's words: one parser for `blender --command cad_shadow` and `python -m addon`. No bpy; nothing is done here.

Options about the method are made from `options.OPTIONS`; those not given are absent from the parsed namespace, so that a settings file or
the scene can speak.
"""

from __future__ import annotations

import argparse
import re
from math import radians

from ..pipeline.render_passes import PASSES, USUAL_PASSES
from ..scene.cad.formats import SUFFIXES
from ..scene.cad.units import metres_per_unit, z_up_from
from ..scene.platform_deck.layout import FEWEST, MOST
from ..scene.reading.limits import Limits
from ..settings.impostor_options import IMPOSTOR_OPTIONS
from ..settings.option import Option
from ..settings.options import OPTIONS
from ..studies.advice.goal import MOST_FRAMES, picked_frames
from .argument_types import (
    between,
    checked_by,
    degrees_between,
    direction,
    finite,
    number_of,
    numbers_of,
    pass_list,
    picture_size,
    positive_number,
    size,
    vector,
)
from .parser_batch import NO_BATCH, add_batch, add_preset, add_sun, positive
from .parser_impostors import add_capture, add_objects, add_path

VIEWS = ("iso", "front", "back", "left", "right", "top", "bottom")
FORMATS = ("png", "exr", "npz")
RIVALS = ("workbench", "cycles", "eevee")
GIVEN = argparse.SUPPRESS


def add_option(group: argparse._ArgumentGroup, option: Option) -> None:
    """One option of the method."""
    text = option.text.replace("%", "%%") + ("" if option.default is None else f" (default {_shown(option.default)})")
    common = {"dest": f"option_{option.name}", "help": text, "default": GIVEN}
    if option.kind == "choice":
        words = {str(identifier): identifier for identifier, _, _ in option.items}
        group.add_argument(option.flag, choices=words, **common)
    elif option.kind == "switch":
        group.add_argument(option.flag, action=argparse.BooleanOptionalAction, **common)
    elif option.kind == "numbers":
        group.add_argument(option.flag, type=numbers_of(option), metavar="A[,A…]", **common)
    elif option.kind == "color":
        group.add_argument(option.flag, type=numbers_of(option), metavar="R,G,B,A" if len(option.default) == 4 else "R,G,B", **common)
    else:
        group.add_argument(option.flag, type=number_of(option), metavar={"m": "METRES", "texel": "N"}.get(option.unit, "N"), **common)


def _shown(default: object) -> str:
    return ",".join(f"{v:g}" for v in default) if isinstance(default, tuple) else str(default)


SECTIONS = {
    "warp": ("warp", "eta", "warp_parameter", "pseudo_near", "convergence", "log_bend"),
    "partition": ("partition", "partitions", "cut", "split_weight", "alpha"),
    "map": ("map_size", "fit", "margin"),
    "shadow test": ("test", "depths", "bias_strategy", "bias", "epsilon", "epsilon_far", "id_per_material", "outlines"),
    "filter": ("pcf", "filter_unit", "filter_width"),
    "picture": ("display", "samples", "light_strength", "ambient_sky", "ambient_ground", "use_object_colors", "clay", "background"),
    "impostors": tuple(option.name for option in IMPOSTOR_OPTIONS),
}


def add_method(parser: argparse.ArgumentParser, *sections: str) -> None:
    """The options of these sections."""
    by_name = {option.name: option for option in OPTIONS}
    if sections == tuple(SECTIONS):
        add_preset(parser)
    for section in sections:
        group = parser.add_argument_group(section)
        for name in SECTIONS[section]:
            add_option(group, by_name[name])


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
    group.add_argument("--fov-y", type=degrees_between(0.0, 180.0), metavar="DEG", help="vertical field of view")
    group.add_argument("--near", type=finite, metavar="METRES", help="near distance of the view")
    group.add_argument("--far", type=finite, metavar="METRES", help="far distance of the view")
    group.add_argument(
        "--size", type=picture_size, metavar="WxH", help="picture size in pixels (default: the scene's, 1280x720 for CAD files)"
    )
    light = parser.add_argument_group("light").add_mutually_exclusive_group()
    light.add_argument(
        "--light", metavar="NAME", help="a sun, spot or point light of the scene (default: the strongest sun, else one from the upper left)"
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


def build_parser(prog: str = "cad_shadow") -> argparse.ArgumentParser:
    """The whole parser; `parse_args` gives a namespace with `command`, and one `option_NAME` per option of the method that was given."""
    parser = argparse.ArgumentParser(prog=prog, description="Anti-aliased shadow previews of CAD models, and their error.")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    preview = commands.add_parser("preview", help="render the inputs", description="Render each input and write its passes and its report.")
    analyse = commands.add_parser(
        "analyse", help="the error report without a picture", description="Measure the shadows' error; write no picture."
    )
    compare = commands.add_parser(
        "compare", help="against ray-traced truth", description="Count the pixels whose shadow differs from traced rays."
    )
    for command in (preview, analyse, compare):
        add_inputs(command)
        add_reporting(command)
        add_view(command)
        add_method(command, *SECTIONS)
    for command in (preview, analyse, compare):
        add_batch(command, makes_pictures=command is not analyse)
    for command in (preview, analyse):
        group = command.add_argument_group("output")
        group.add_argument(
            "--passes",
            type=pass_list(PASSES),
            metavar="PASS[,PASS…]",
            help=f"from {','.join(PASSES)} (default: combined; all but {', '.join(n for n in PASSES if n not in USUAL_PASSES)} for npz)",
        )
        group.add_argument(
            "--format", choices=FORMATS, default="png", help="png to look at, exr for exact values per pass, npz for all in one file"
        )
    preview.add_argument(
        "--light-view",
        action="store_true",
        help="also what the light sees: surfaces in the colour of their shadow map, outlines of maps and view",
    )
    add_sun_study(commands)
    add_impostors(commands)
    add_advise(commands)
    add_bench(commands)
    add_theory(commands)
    return parser


def add_impostors(commands: argparse._SubParsersAction) -> None:
    """`impostor` and `impostor-path`."""
    capture = commands.add_parser(
        "impostor",
        help="capture relief impostors",
        description="Capture objects from the view: colour, depth, normal, ids as images; critical points and how to draw them as JSON.",
    )
    path = commands.add_parser(
        "impostor-path",
        help="impostors along a camera path, against direct rendering",
        description="Run the life of impostors along a camera path: stages, predicted errors, measured errors; as CSV and in the report.",
    )
    add_path(path)
    for command in (capture, path):
        add_objects(command)
        add_inputs(command)
        add_reporting(command)
        add_view(command)
        add_method(command, *SECTIONS)
        command.set_defaults(**NO_BATCH)
    add_capture(capture, FORMATS)


def add_sun_study(commands: argparse._SubParsersAction) -> None:
    """`sun-study`: an input at several times of a day."""
    command = commands.add_parser(
        "sun-study", help="the shadows of a day", description="Render each input under the sun of several times of a day, on one sheet."
    )
    add_sun(command)
    add_inputs(command)
    add_reporting(command)
    add_view(command, has_light_direction=False)
    add_method(command, *SECTIONS)
    add_batch(command)


def frame_list(text: str) -> tuple[int, ...]:
    """A-B as `picked_frames` has it; a single frame as itself."""
    match = re.fullmatch(r"(-?\d+)(?:-(-?\d+))?", text)
    if not match:
        raise ValueError(text)
    first, last = int(match[1]), int(match[2] or match[1])
    if last < first:
        raise argparse.ArgumentTypeError(f"{text}: the last frame comes before the first")
    return picked_frames(first, last)


def add_advise(commands: argparse._SubParsersAction) -> None:
    """`advise`: the best combination for a budget, or the least budget for an error."""
    command = commands.add_parser(
        "advise",
        help="the best warp, partition, fit and map size",
        description="Try the combinations on each input, measure them, and propose the best for a budget of texels or a wanted error.",
    )
    group = command.add_argument_group("what is wanted").add_mutually_exclusive_group(required=True)
    group.add_argument("--texels", type=positive, metavar="N", help="the least error with this many texels in all maps together")
    group.add_argument(
        "--error", type=positive_number, metavar="M", help="the fewest texels with which 95 %% of the pixels have an error m below this"
    )
    search = command.add_argument_group("search")
    search.add_argument(
        "--frames",
        type=frame_list,
        default=(),
        metavar="A-B",
        help=f"frames of the animation, {MOST_FRAMES} of them are looked at (default: one)",
    )
    command.set_defaults(**NO_BATCH)
    search.add_argument(
        "--seconds", type=positive_number, default=120.0, metavar="S", help="decide after this time at the latest (default 120)"
    )
    add_inputs(command)
    add_reporting(command)
    add_view(command)
    add_method(command, *SECTIONS)


def add_bench(commands: argparse._SubParsersAction) -> None:
    """`bench`: frame times beside the bare passes and Blender's own engines."""
    bench = commands.add_parser(
        "bench",
        help="frame times, beside the bare passes and Blender's engines",
        description="Move the camera, time every frame, interleaved with the rivals; ratios of medians are what counts.",
    )
    bench.set_defaults(**NO_BATCH)
    add_inputs(bench)
    add_reporting(bench)
    add_view(bench)
    add_method(bench, *SECTIONS)
    group = bench.add_argument_group("benchmark")
    group.add_argument("--frames", type=positive, default=7, metavar="N", help="frames that count, one more warms up (default 7)")
    group.add_argument(
        "--rivals", type=rival_list, default=(), metavar="NAME[,NAME…]", help=f"Blender's engines to time too: {', '.join(RIVALS)}"
    )


def rival_list(text: str) -> tuple[str, ...]:
    """Comma-separated names of Blender's engines."""
    names = tuple(name.strip() for name in text.split(","))
    unknown = [name for name in names if name not in RIVALS]
    if unknown:
        raise argparse.ArgumentTypeError(f"unknown rival '{unknown[0]}': choose from {', '.join(RIVALS)}")
    return names


def add_theory(commands: argparse._SubParsersAction) -> None:
    """`theory`: what the texts predict, without a scene."""
    theory = commands.add_parser(
        "theory", help="what the texts predict, without a scene", description="Warp parameter, splits, M_x, M_z, S."
    )
    view = theory.add_argument_group("view")
    view.add_argument("--near", type=finite, required=True, metavar="N", help="near distance")
    view.add_argument("--far", type=finite, required=True, metavar="F", help="far distance")
    view.add_argument(
        "--fov-y", type=degrees_between(0.0, 180.0), default=radians(60.0), metavar="DEG", help="vertical field of view (default 60)"
    )
    view.add_argument(
        "--gamma",
        type=degrees_between(-1e-9, 90.0 + 1e-9),
        default=radians(90.0),
        metavar="DEG",
        help="angle between light and view direction (default 90)",
    )
    view.add_argument("--size", type=size, metavar="WxH", help="picture size; with --map-size the resolution terms are included")
    view.add_argument("--curve", choices=("z",), help="add the error along the view, m_x(z) and m_z(z)")
    view.add_argument("--points", type=between(2, 100_000, is_whole=True), default=65, metavar="N", help="points of the curve (default 65)")
    add_reporting(theory, folder=False)
    add_method(theory, "warp", "partition", "map")


def view_mistake(args: argparse.Namespace) -> str | None:
    """What is wrong with the arguments about the view together, whatever is looked at; None when nothing is."""
    if args.near is not None and args.far is not None and args.near >= args.far:
        return f"--near {args.near:g} must be smaller than --far {args.far:g}"
    if args.target is not None and args.eye is None:
        return "--target belongs to --eye X,Y,Z"
    if args.eye is not None and args.eye == args.target:
        return "--eye and --target are the same point: move one of them"
    given = vars(args)
    if given.get("option_eta") is not None and given.get("option_warp_parameter") is not None:
        return "--eta and --warp-parameter set the same thing: give one of them"
    return None


def joined(argv: list[str]) -> list[str]:
    """Arguments with `--eye -1,2,3` joined to `--eye=-1,2,3`: argparse would take the value for an option."""
    out: list[str] = []
    for argument in argv:
        if out and re.match(r"-[\d.]", argument) and re.fullmatch(r"--[a-z-]+", out[-1]):
            out[-1] += "=" + argument
        else:
            out.append(argument)
    return out
