"""Shaders as strict drivers read them: a name in #if that nothing defines is an error there (GLSL 3.30, 3.3)."""

import re

import numpy as np
import pytest

from addon.maths.relief.life import LifeModel
from addon.maths.relief.settings import ImpostorSettings
from addon.pipeline.gl import programs
from addon.pipeline.impostors.records import ImpostorChoice, ImpostorGroup
from addon.pipeline.job import Job
from addon.settings.groups import TESTS, Settings
from addon.studies.run import run
from tests import scenes

CAMERA = scenes.look_at((14.0, -16.0, 9.0), (0.0, 0.0, 0.7), fov_y_deg=35.0, near=1.0, far=80.0)
HUGE = scenes.scene_of(scenes.floor(2e4), scenes.box((-1.0, -1.0, 0.0), (1.0, 1.0, 2.0)))  # its ground is cut, for the camera and for maps
BOX = ImpostorChoice((ImpostorGroup("box", (1,)),), ImpostorSettings(break_even=False), LifeModel(finest=np.inf))
CHOICES = [
    *({"test": {"kind": kind}, "warp": {"kind": warp}} for kind in TESTS for warp in ("lispsm", "logpsm")),
    {"test": {"kind": "triangle", "outlines": True}},
    {"test": {"kind": "id-depth", "depths": 4}},
]


def undefined(text: str) -> set[str]:
    """The names that the live #if and #elif lines of a shader use and nothing defines."""
    macros, live, found = {}, [[True, True]], set()  # live: whether lines count here, whether a branch has been taken
    for word, rest in re.findall(r"^\s*#\s*(\w+)[ \t]*(.*?)[ \t]*(?://.*)?$", text, re.MULTILINE):
        if word == "define" and live[-1][0]:
            name, _, value = rest.partition(" ")
            macros[name] = value.strip()
        elif word in ("if", "ifdef", "ifndef"):
            holds = live[-1][0] and (_holds(rest, macros, found) if word == "if" else (rest in macros) == (word == "ifdef"))
            live.append([holds, holds or not live[-1][0]])
        elif word in ("elif", "else"):
            holds = not live[-1][1] and (word == "else" or _holds(rest, macros, found))
            live[-1] = [holds, live[-1][1] or holds]
        elif word == "endif":
            live.pop()
    return found


def _holds(condition: str, macros: dict[str, str], found: set[str]) -> bool:
    """The value of a condition; names without a value go to `found`."""

    def value(match: re.Match[str]) -> str:
        name = match[0]
        while re.fullmatch(r"[A-Za-z_]\w*", name):
            found.update({name} - macros.keys())
            name = macros.get(name, "0")
        return name

    condition = re.sub(r"defined\s*\(\s*(\w+)\s*\)", lambda match: str(int(match[1] in macros)), condition)
    condition = re.sub(r"[A-Za-z_]\w*", value, condition).replace("&&", " and ").replace("||", " or ")
    return bool(eval(re.sub(r"!(?!=)", " not ", condition)))  # numbers and operators only


def test_the_reader_of_conditions_finds_what_is_not_defined():
    first = "#define A 1\n#if A == 1 && !defined(B)\n#elif C\n#endif\n"
    second = "#if D || !A\n#define E 2\n#else\n#if F\n#endif\n#endif\n#ifndef G\n#if H\n#endif\n#endif"
    assert undefined(first + second) == {"D", "F", "H"}


@pytest.mark.parametrize("choice", CHOICES, ids=str)
def test_every_name_in_a_condition_is_defined(renderer, monkeypatch, choice):
    got = []
    original = programs.Programs.get

    def noted(self, vertex, fragment, geometry=None, **defines):
        values = tuple(sorted((key, int(value) if isinstance(value, bool) else value) for key, value in defines.items()))
        got.extend((name, values) for name in (vertex, fragment, geometry) if name)
        return original(self, vertex, fragment, geometry, **defines)

    monkeypatch.setattr(programs.Programs, "get", noted)
    settings = Settings().replaced(fit={"size": 128}, **choice)
    for scene, impostors in ((HUGE, None), (scenes.closed_box(), None), (scenes.closed_box(), BOX)):
        job = Job(scene, CAMERA, scenes.sun(40.0), settings, (64, 48), ("combined", "shadow"), impostors=impostors)
        frame = run(job, on=renderer).frame
        assert np.isfinite(frame.passes["combined"]).all()
    assert {name for name, _ in got} >= {"gbuffer.vert", "gbuffer_cut.vert", "impostor.frag", "shade.frag"}
    assert {(name, word) for name, values in got for word in undefined(programs.source(name, values))} == set()
