"""Which choices mean something together, and that whoever asks for what does not is told so in one line."""

import tomllib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from addon.cli.parser import build_parser
from addon.cli.settings_file import chosen_settings, idle_options
from addon.maths.choices import PARTITIONS, WARPS, PartitionChoice, WarpChoice, unsuited
from addon.maths.shadow.fit import plan_shadows
from addon.maths.view import Light
from addon.settings.combinations import applies, idle, named
from addon.settings.groups import Settings
from addon.settings.options import OPTIONS, with_options
from tests import scenes

LIGHTS = {
    "sun": scenes.sun(50.0, 100.0),
    "spot": Light("spot", np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 8.0]), cone_rad=0.6),
    "point": Light("point", None, np.array([0.0, 0.0, 8.0])),
}
CAMERA = scenes.look_at((0.5, -9.0, 1.7), (0.0, 10.0, 0.5), fov_y_deg=50.0, near=0.2, far=60.0)


def parsed(*words, file=""):
    """Namespace of a `theory` command line with a settings file's text."""
    args = build_parser().parse_args(["theory", "--near", "1", "--far", "100", *words])
    args.from_file = tomllib.loads(file)
    return args


@given(warp=st.sampled_from(WARPS), partition=st.sampled_from(PARTITIONS), count=st.integers(1, 8))
def test_an_option_is_reported_idle_exactly_when_panels_hide_it(warp, partition, count):
    settings = Settings().replaced(warp={"kind": warp}, partition={"kind": partition, "count": count})
    values = type("Values", (), {o.name: getattr(getattr(settings, o.targets[0][0]), o.targets[0][1]) for o in OPTIONS})
    for option in OPTIONS:
        assert bool(idle([option.name], settings)) != applies(option.name, values)


def test_the_line_names_the_option_and_what_makes_it_idle():
    (line,) = idle(["split_weight"], with_options(Settings(), {"partition": "z-log"}))
    assert line.startswith("'split_weight' changes nothing with partition = z-log:")
    (line,) = idle(["pseudo_near"], with_options(Settings(), {"warp": "uniform", "partition": "none"}))
    assert "warp = uniform, partition = none" in line


@pytest.mark.parametrize(
    ("words", "file", "told"),
    [
        (("--warp", "uniform", "--eta", "0.5"), "", ["eta"]),
        (("--warp", "uniform"), "eta = 0.5", ["eta"]),
        (("--eta", "0.5"), "warp = 'uniform'", ["eta"]),
        ((), "[partition]\nkind = 'z-log'\nsplit_weight = 0.25", ["split_weight"]),
        ((), "[partition]\nkind = 'z-log'\nsplit_weight = 0.5\nalpha = [3.0]", ["alpha"]),
        ((), "[partition]\nkind = 'z-log'\nsplit_weight = 0.5", []),
        (("--partition", "z-pssm", "--split-weight", "0.25"), "", []),
    ],
)
def test_command_line_and_settings_files_are_told(words, file, told):
    args = parsed(*words, file=file)
    lines = idle_options(chosen_settings(Settings(), args), args)
    assert [line.split("'")[1] for line in lines] == told
    assert sorted(named(args.from_file)) == sorted(dict.fromkeys(named(args.from_file)))


@pytest.mark.parametrize("kind", LIGHTS)
@pytest.mark.parametrize("warp", WARPS)
@pytest.mark.parametrize("partition", ["none", "z-log", "faces", "z-adaptive"])
def test_a_plan_says_what_means_nothing_under_its_light(kind, warp, partition):
    points = np.random.default_rng(1).uniform([-4.0, -4.0, 0.0], [4.0, 4.0, 3.0], (50, 3))
    bounds = np.array([points.min(axis=0), points.max(axis=0)])
    plan = plan_shadows(
        CAMERA,
        LIGHTS[kind],
        WarpChoice(warp),
        PartitionChoice(partition),
        Settings().fit,
        receivers_ws=points,
        scene_bounds_ws=bounds,
        caster_bounds_ws=bounds[None],
        image_size=(64, 48),
    )
    asked = (("warp", warp, WarpChoice().kind), ("partition", partition, PartitionChoice().kind))
    expected = [reason for name, value, default in asked if value != default and (reason := unsuited(name, value, kind))]
    assert len(plan.warnings) == len(expected)
    for line, reason in zip(plan.warnings, expected, strict=True):
        assert reason in line and "\n" not in line


@pytest.mark.parametrize(
    ("words", "file", "kind"),
    [
        ((), "", "triangle"),
        (("--depths", "4"), "", "depth"),
        (("--bias", "0.01"), "", "depth"),
        (("--bias-strategy", "slope-scaled"), "", "depth"),
        ((), "depths = 2", "depth"),
        ((), "[test]\ndepths = 2", "depth"),
        ((), "[test]\nkind = 'id-depth'\ndepths = 2", "id-depth"),
        (("--depths", "2"), "test = 'id-depth'", "id-depth"),
        (("--pcf", "9", "--outlines"), "", "triangle"),
        (("--depths", "1"), "", "triangle"),
    ],
)
def test_what_only_the_depth_test_has_asks_for_it_where_no_test_is_chosen(words, file, kind):
    args = build_parser().parse_args(["preview", "model.obj", *words])
    args.from_file = tomllib.loads(file)
    assert chosen_settings(Settings(), args).test.kind == kind
