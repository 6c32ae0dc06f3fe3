"""Any settings, any camera, any light: a sound picture (no NaN, finite maps, no OpenGL error), or one line.

Values come from the fields' own domains, so that what is added to the settings is tried as well.
"""

from dataclasses import fields, is_dataclass
from types import NoneType, UnionType
from typing import get_args, get_type_hints

import numpy as np
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from addon.errors import UserError
from addon.maths.domains import Interval, OneOf, domain_of
from addon.maths.view import Light
from addon.pipeline.job import Job
from addon.pipeline.renderer import Renderer
from addon.settings.groups import Settings
from tests import scenes

SIZE = (40, 30)
PASSES = ("combined", "shadow", "depth", "normal", "object", "partition", "aliasing")
MOST = {"size": 256, "count": 8, "log_bend": 100.0, "margin_texels": 6.0, "max_texels": 256, "memory_mib": 64, "directions": 4, "views": 2}
SCENES = {name: getattr(scenes, name)() for name in ("railing", "chair", "open_sheet", "coincident_boxes")}


def numbers(domain, is_whole, most):
    """Of an interval: its ends, small and large ones."""
    high = min(domain.high, most)
    if is_whole:
        return st.integers(int(domain.low), int(min(high, 1e6)))
    ends = [domain.low, high] if np.isfinite(high) else [domain.low]
    ends += [np.inf] if domain.has_infinity else []
    return st.one_of(
        st.sampled_from(ends),
        st.floats(domain.low, min(high, 1e6), allow_nan=False),
        st.floats(0.01, 10.0).filter(lambda x: domain.low <= x <= high),
    )


def values(kind, name, hint):
    """What a field may hold."""
    domain = domain_of(kind, name)
    kinds = get_args(hint) if isinstance(hint, UnionType) else (hint,)
    inner = next(one for one in kinds if one is not NoneType)
    if inner is bool:
        found = st.booleans()
    elif isinstance(domain, OneOf):
        found = st.sampled_from([value for value in domain.values if not isinstance(value, int) or value <= 9])
    elif isinstance(domain, Interval):
        is_tuple = getattr(inner, "__origin__", None) is tuple
        one = numbers(domain, inner is int, MOST.get(name, np.inf))
        if is_tuple:
            arguments = get_args(inner)
            count = (1, 3) if arguments[-1] is Ellipsis else (len(arguments), len(arguments))
            found = st.lists(one, min_size=count[0], max_size=count[1]).map(tuple)
        else:
            found = one
    else:
        found = st.just(kind.__dataclass_fields__[name].default)
    return st.one_of(st.none(), found) if NoneType in kinds else found


def groups(kind):
    """A choice with any values in a few of its fields, or what refuses them."""
    hints = get_type_hints(kind)
    return st.fixed_dictionaries({}, optional={field.name: values(kind, field.name, hints[field.name]) for field in fields(kind)})


whole = st.fixed_dictionaries(
    {field.name: groups(field.default_factory) for field in fields(Settings) if is_dataclass(field.default_factory)}
)
places = st.tuples(*[st.integers(-20_000, 20_000).map(lambda mm: mm / 1000)] * 2, st.integers(50, 20_000).map(lambda mm: mm / 1000))
degrees = st.integers(0, 36_000).map(lambda hundredths: hundredths / 100)


@st.composite
def cameras(draw):
    eye = draw(places)
    near = draw(st.floats(1e-3, 2.0))
    return scenes.look_at(eye, (0.1, 0.2, 0.3), draw(st.floats(2.0, 120.0)), near, near * draw(st.floats(10.0, 1e5)))


@st.composite
def lights(draw):
    kind = draw(st.sampled_from(["sun", "sun", "spot", "point"]))
    if kind == "sun":
        return scenes.sun(draw(degrees) / 4.0, draw(degrees))
    place = np.array(draw(places))
    if kind == "point":
        return Light("point", None, place)
    return Light("spot", place / np.linalg.norm(place), place, cone_rad=draw(st.floats(0.05, 1.2)))


def chosen(asked):
    """The settings, with the fields that refuse each other left at their defaults, group by group."""
    result = Settings().replaced(fit={"size": 128}, shading={"samples": 1})
    for group, fields_asked in asked.items():
        try:
            result = result.replaced(**{group: fields_asked})
        except UserError as error:
            assert str(error).isprintable()
    return result if result.fit.size <= MOST["size"] else result.replaced(fit={"size": MOST["size"]})


def faults(frame):
    """What must not be in a frame."""
    for name in PASSES:
        image = frame.passes[name]
        if name != "aliasing" and image.dtype.kind == "f" and np.isnan(image).any():  # that one is NaN where nothing is lit
            yield f"NaN in {name}"
    if not np.isfinite(frame.passes["combined"]).all():
        yield "a pixel without bound"
    if frame.plan is None:
        return
    for projection in frame.plan.projections:
        if not np.isfinite(projection.clip_from_world).all():
            yield "a matrix that is not finite"
    seen = np.isfinite(frame.passes["depth"])
    if (frame.passes["partition"][seen] >= len(frame.plan.projections)).any():
        yield "a pixel of a map that there is not"


@settings(max_examples=80, suppress_health_check=list(HealthCheck), deadline=None, phases=(Phase.explicit, Phase.generate))
@given(asked=whole, camera=cameras(), light=lights(), name=st.sampled_from(sorted(SCENES)))
def test_any_settings_give_a_sound_picture_or_one_line(worker, asked, camera, light, name):
    try:
        job = Job(SCENES[name], camera, light, chosen(asked), SIZE, PASSES)
        frame = Renderer(worker).submit(job)[0].result(120.0)
    except UserError as error:
        assert str(error).isprintable() and len(str(error)) < 400
        return
    assert not list(faults(frame))
    assert worker.call(lambda context: context.error) == "GL_NO_ERROR"
