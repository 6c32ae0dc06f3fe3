"""A range is written once: what an option offers, what the check takes and what the records below are made with is the same."""

from __future__ import annotations

import dataclasses
from math import inf, isinf, nan, nextafter

import pytest

from addon.errors import SettingsError
from addon.maths.domains import Interval, OneOf, domain_of, require_fields, same_as, within
from addon.maths.relief.settings import ImpostorSettings
from addon.settings.groups import Settings
from addon.settings.options import BY_NAME, OPTIONS, with_options
from addon.studies.impostors.asked import choice_for

# what else must be chosen for the ends of a range to be taken
NEEDS = {"map_size": {"margin": 0.0}, "margin": {"map_size": 16384}}
NUMBERS = [option.name for option in OPTIONS if option.kind in ("number", "count", "numbers", "color")]


def taken(name, value):
    """The settings with this value of an option, as many of it as the option has."""
    option = BY_NAME[name]
    many = {"numbers": 1, "color": option.width if option.kind == "color" else 0}.get(option.kind)
    return with_options(Settings(), NEEDS.get(name, {}) | {name: value if many is None else (value,) * many})


@pytest.mark.parametrize("name", NUMBERS)
def test_the_ends_of_an_options_range_are_taken_and_what_lies_beyond_is_refused_in_a_line_that_names_the_range(name):
    option = BY_NAME[name]
    for end, beyond in ((option.low, -inf), (option.high, inf)):
        if isinf(end):
            continue
        taken(name, end)
        with pytest.raises(SettingsError, match=r"must (lie between|be (finite and )?at least) [-\d.]+") as refused:
            taken(name, end + (1 if beyond > 0 else -1) if option.kind == "count" else nextafter(end, beyond))
        assert "\n" not in str(refused.value)
    if option.kind != "count":
        with pytest.raises(SettingsError):
            taken(name, nan)


def test_every_number_and_choice_has_a_domain_and_all_fields_of_an_option_have_the_same():
    for option in OPTIONS:
        domains = {domain_of(type(getattr(Settings(), group)), field) for group, field in option.targets}
        kind = {"switch": type(None), "choice": OneOf}.get(option.kind, Interval)
        assert [type(domain) for domain in domains] == [kind], option.name


OTHER_VALUES = {
    "projection": "orthographic", "back_layer": False, "warp": "forward", "predictor": "critical", "limit": 0.5, "texels_per_pixel": 3.0,
    "max_texels": 99, "max_tilt_deg": 33.0, "regenerations": 7, "memory_mib": 9, "sprite_px": 1.5, "ahead": 0.25, "fade_frames": 3,
    "break_even": False, "views": 3, "directions": 5, "fill": False, "casters": "impostor",
}  # fmt: skip


@pytest.mark.parametrize("name", [field.name for field in dataclasses.fields(ImpostorSettings) if field.name not in ("use", "fresh")])
def test_each_impostor_setting_reaches_what_the_renderer_is_asked(name):
    usual, changed = choice_for((), ImpostorSettings()), choice_for((), ImpostorSettings(**{name: OTHER_VALUES[name]}))
    met = {f.name for f in dataclasses.fields(ImpostorSettings) if getattr(usual.settings, f.name) != getattr(changed.settings, f.name)}
    assert met == {name}


@dataclasses.dataclass(frozen=True)
class Measured:
    """For these tests."""

    near: float | None = within(None, "Near", 0.5)
    far: float = within(2.0, "Far", 1, 1 << 20, has_infinity=False)
    end: float = within(inf, "End", 0, has_infinity=True)
    next: float = dataclasses.field(default=2.0)

    __post_init__ = require_fields


@dataclasses.dataclass(frozen=True)
class Other:
    """Takes a field of another."""

    far: float = same_as(Measured, "far")
    shorter: float = same_as(Measured, "far", default=1.5)

    __post_init__ = require_fields


@pytest.mark.parametrize(
    ("values", "line"),
    [
        ({"near": 0.25}, "Near must be finite and at least 0.5, not 0.25."),
        ({"near": inf}, "Near must be finite and at least 0.5, not inf."),
        ({"far": nan}, "Far must lie between 1 and 1048576, not nan."),
        ({"end": -1.0}, "End must be at least 0, not -1.0."),
        ({"far": "2"}, "far is '2', not a number."),
    ],
)
def test_a_refusal_names_the_setting_its_range_and_the_value(values, line):
    with pytest.raises(SettingsError) as refused:
        Measured(**values)
    assert str(refused.value) == line


def test_a_field_as_in_another_record_has_its_default_and_its_domain():
    assert (Other().far, Other().shorter) == (2.0, 1.5)
    for name in ("far", "shorter"):
        with pytest.raises(SettingsError, match="Far must lie between 1 and 1048576, not 0"):
            Other(**{name: 0.0})
