"""The parts of the documentation that repeat what the program says, made from it: option tables and the command line reference.

Sources: `addon.settings.options` (names, ranges, tooltips) and the parser of `addon.cli.parser`. A page asks for tables with marker lines,

    <!-- options: warp eta -->  …  <!-- end -->      one row per option
    <!-- choices: warp -->  …  <!-- end -->          one row per choice of an option
    <!-- presets: all -->  …  <!-- end -->           one row per preset that is shipped
    <!-- passes: all -->  …  <!-- end -->            one row per pass
    <!-- looks: all -->  …  <!-- end -->             one row per look
    <!-- formats: all -->  …  <!-- end -->           one row per format of CAD files

and what stands between is replaced. `docs/command_line.md` is made whole. Not here: any word about what an option does.
"""

import argparse
import ast
import re
import sys
from collections.abc import Iterator
from math import isinf
from pathlib import Path

from addon.blender.support import SUPPORT
from addon.cli.parser import build_parser
from addon.pipeline.render_passes import RENDER_PASSES
from addon.scene.cad.formats import FORMATS
from addon.settings.looks import LOOKS
from addon.settings.option import Option
from addon.settings.options import BY_NAME

ROOT = Path(__file__).resolve().parents[1]
DOCS, PRESETS = ROOT / "docs", ROOT / "addon" / "blender" / "presets" / "cad_shadow_preview"
COMMAND_LINE = DOCS / "command_line.md"
BLENDER_SUPPORT = DOCS / "blender_support.md"
MARKED = re.compile(r"(<!-- (options|choices|presets|passes|formats|looks): ([a-z_ ]+) -->\n).*?(<!-- end -->)", re.DOTALL)
UNITS = {"m": " m", "texel": " texels"}

COMMAND_LINE_HEAD = """# Command line

Made by `python -m tools.docs_tables` from the program's own parser; do not edit.

Inside Blender: `blender --command cad_shadow COMMAND …` (Blender 4.2.13 and newer, the extension enabled). From a checkout:
`./dev preview …`, `./dev analyse …` and so on, or `python -m addon COMMAND …` with any Python that has the `bpy` module.

Exit code 0: all done. 1: some input failed; the others are done, and the report says which failed and why. 2: the command line was not
understood, whatever is drawn: a value out of its range, arguments that contradict each other, a `--report` that would take the place of an
input or of another result. Reports and pictures appear whole or not at all, and never in the place of an input.

Ctrl-C and SIGTERM stop a run: the picture at hand is given up, what is done stays, `--report` names what is not, the exit code is 1, and
`--resume` goes on from there.

What is not given on the command line comes from the settings file (`--settings`), else from the scene, else from the default.
"""


def table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """A Markdown table; bars inside cells are escaped."""
    lines = [head, tuple("---" for _ in head), *rows]
    return "".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |\n" for line in lines)


def number(value: float) -> str:
    """As short as it can be said."""
    return f"{value:g}"


def range_of(option: Option) -> str:
    """The hard limits, as a user reads them."""
    if option.kind in ("choice", "switch"):
        return "on, off" if option.kind == "switch" else ", ".join(f"`{identifier}`" for identifier, _, _ in option.items)
    unit = UNITS.get(option.unit, "")
    if isinf(option.high):
        return f"{number(option.low)}{unit} or more"
    return f"{number(option.low)} … {number(option.high)}{unit}"


def default_of(option: Option) -> str:
    """The default in the words of the interface."""
    default = option.default
    if default is None:
        return "automatic"
    if option.kind == "switch":
        return "on" if default else "off"
    if option.kind == "choice":
        return next(label for identifier, label, _ in option.items if identifier == str(default))
    if isinstance(default, tuple):
        return ", ".join(number(v) for v in default)
    return number(default)


def option_table(names: list[str]) -> str:
    """The options, one per row: label, flag, default, range, tooltip."""
    rows = [
        (o.label, f"`{o.flag}`", default_of(o), "see below" if o.kind == "choice" else range_of(o), o.text)
        for o in (BY_NAME[name] for name in names)
    ]
    return table(("Option", "Command line", "Default", "Range", "What it does"), rows)


def choice_table(names: list[str]) -> str:
    """The choices of options, one per row: label, identifier, tooltip."""
    rows = [(label, f"`{identifier}`", text) for name in names for identifier, label, text in BY_NAME[name].items]
    return table((BY_NAME[names[0]].label, "Command line, Python", "What it does"), rows)


def preset_table(_names: list[str]) -> str:
    """The presets that are shipped: name, purpose (the file's docstring) and the values it sets. Read, not run: they need Blender."""
    rows = []
    for path in sorted(PRESETS.glob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        values = [
            f"`{node.targets[0].attr} = {ast.unparse(node.value)}`"
            for node in tree.body
            if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Attribute)
        ]
        rows.append((f"**{path.stem.replace('_', ' ')}**", " ".join((ast.get_docstring(tree) or "").split()), ", ".join(values)))
    return table(("Preset", "For", "Sets"), rows)


def look_table(_names: list[str]) -> str:
    """What one sees with each look, and the options that it sets."""
    rows = []
    for look in LOOKS.values():
        values = ", ".join(f"`{name} = {value!r}`" for name, value in look.values.items())
        rows.append((f"**{look.label}**", look.text, values or "the defaults"))
    return table(("Look", "What one sees", "Sets"), rows)


def pass_table(_names: list[str]) -> str:
    """The passes: name, the array in a result and in .npz, what it holds, and what Blender's render layers call it."""
    rows = []
    for row in RENDER_PASSES.values():
        text = row.text if row.is_usual else f"{row.text} (where asked for)"
        rows.append((f"`{row.name}`", f"`{row.array}` {row.shape}", text, row.blender.name if row.blender else ""))
    return table(("Pass", "Array", "What it holds", "In Blender"), rows)


def format_table(_names: list[str]) -> str:
    """The formats of CAD files: name, suffixes, and what a file means that says nothing of unit and axis."""
    guess = ", a guess: the file does not say"
    rows = [
        (row.name, " ".join(f"`{s}`" for s in row.suffixes), row.unit + guess * (not row.fixes_unit), row.up) for row in FORMATS.values()
    ]
    return table(("Format", "Files", "Unit, if the file names none", "Up"), rows)


def filled(text: str) -> str:
    """A page with every marked table made anew."""
    makers = {
        "options": option_table,
        "choices": choice_table,
        "presets": preset_table,
        "passes": pass_table,
        "formats": format_table,
        "looks": look_table,
    }
    return MARKED.sub(lambda m: f"{m[1]}\n{makers[m[2]](m[3].split())}\n{m[4]}", text)


def named_options(text: str) -> list[str]:
    """The options that have a row on a page."""
    return [name for m in MARKED.finditer(text) if m[2] == "options" for name in m[3].split()]


def commands() -> Iterator[tuple[str, str, argparse.ArgumentParser]]:
    """Each command's name, its one-line description and its parser."""
    parser = build_parser()
    actions = next(a for a in parser._actions if isinstance(a, argparse._SubParsersAction))  # argparse has no public way
    for name, command in actions.choices.items():
        yield name, command.description, command


def groups(command: argparse.ArgumentParser) -> Iterator[tuple[str, str]]:
    """Title and table of each group of arguments."""
    for group in command._action_groups:
        actions = [*group._group_actions, *(a for inner in group._action_groups for a in inner._group_actions)]
        rows = [(f"`{spelling(a)}`", help_of(a)) for a in actions if a.help != argparse.SUPPRESS and "--help" not in a.option_strings]
        if rows:
            yield group.title, table(("Option", "Meaning"), rows)


def spelling(action: argparse.Action) -> str:
    """Flags and value, as one types them."""
    if action.nargs == 0 or isinstance(action, argparse.BooleanOptionalAction):
        return ", ".join(action.option_strings)
    value = action.metavar or ("|".join(map(str, action.choices)) if action.choices else action.dest.upper())
    return f"{', '.join(action.option_strings)} {value}" if action.option_strings else f"{value} …"


def help_of(action: argparse.Action) -> str:
    """The help text as argparse would print it; 'required' said where it is."""
    text = action.help % {"default": action.default, "prog": "cad_shadow"}
    return f"{text} **(required)**" if action.required and action.option_strings else text


def command_page() -> str:
    """The whole command line reference: what a command has for itself stands with it, what several share once at the end."""
    shared: dict[tuple[str, str], list[str]] = {}
    described = list(commands())
    for name, _, command in described:
        for group in groups(command):
            shared.setdefault(group, []).append(name)
    text = COMMAND_LINE_HEAD
    for name, description, _ in described:
        text += f"\n## `{name}`\n{description}\n"
        text += "".join(f"\n**{title}**\n\n{rows}" for (title, rows), users in shared.items() if users == [name])
        common = [title for (title, _), users in shared.items() if name in users and len(users) > 1]
        text += "\nAlso: " + ", ".join(common) + " (below).\n" if common else ""
    for (title, rows), users in shared.items():
        if len(users) > 1:
            text += f"\n## {title.capitalize()}\nFor {', '.join(f'`{user}`' for user in users)}.\n\n{rows}"
    return text


SUPPORT_HEAD = """# What of Blender is honoured

Made by `python -m tools.docs_tables` from `addon/blender/support.py`; do not edit. A test compares it with the Blender it runs in: every
property of these types is here.

*Honoured*: it changes the picture as it does in Cycles. *Warned*: it is left out, and where it is set a line in the report's `warnings` and
in Blender's log says so. *No effect*: interface, editing, other engines' own, or light that bounces.
"""


def support_page() -> str:
    """What becomes of Blender's properties, type by type."""
    text = SUPPORT_HEAD
    for owner in dict.fromkeys(row.owner for row in SUPPORT):
        rows = [
            (", ".join(f"`{name}`" for name in row.names.split()), row.status, row.text.replace("{}", "…"))
            for row in SUPPORT
            if row.owner == owner
        ]
        text += f"\n## {owner}\n" + table(("Properties", "Status", "What becomes of them"), rows)
    return text


def pages() -> dict[Path, str]:
    """Every page with something made in it, as it should be."""
    marked = {path: path.read_text(encoding="utf-8") for path in sorted(DOCS.glob("*.md")) if path not in (COMMAND_LINE, BLENDER_SUPPORT)}
    made = {COMMAND_LINE: command_page(), BLENDER_SUPPORT: support_page()}
    return {path: filled(text) for path, text in marked.items() if MARKED.search(text)} | made


def main() -> int:
    """Write what is not current."""
    for path, text in pages().items():
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")
            print(f"{path.relative_to(ROOT)} made anew")
    return 0


if __name__ == "__main__":
    sys.exit(main())
