"""Models made at random, written by an independent writer, and read back equal: the formats that hold one mesh."""

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from addon.images.srgb import linear_from_srgb
from addon.scene import cad
from tests.cad.measured import colors, names, world_triangles
from tests.test_ply import FORMATS, faces, ply, vertices

NAMES = st.text(
    st.characters(exclude_categories=["Cs", "Cc", "Zl", "Zp"], exclude_characters='/\\:*?"<>|'), min_size=1, max_size=20
).filter(lambda name: name.strip(" .") == name and len(name.encode()) < 100)
PLACES = st.lists(st.integers(-(10**5), 10**5), min_size=3, max_size=3)
BYTES = st.lists(st.integers(0, 255), min_size=3, max_size=3)
POLYGONS = st.lists(st.tuples(PLACES, st.integers(3, 7), BYTES), min_size=1, max_size=8)


def ring(place, count):
    """A regular polygon of radius 1 about a place, and its area."""
    turn = np.arange(count) * 2.0 * math.pi / count
    points = np.stack([np.cos(turn), np.sin(turn), np.zeros(count)], axis=1) + place
    return np.round(points, 6), count / 2.0 * math.sin(2.0 * math.pi / count)


def is_covered(model, polygons):
    """Whether a model of one part is these polygons, in order, each in its colour."""
    p, shades = world_triangles(model, 0), colors(model, 0)
    first = 0
    for place, count, color in polygons:
        own = slice(first, first + count - 2)
        first += count - 2
        points, size = ring(place, count)
        areas = np.linalg.norm(np.cross(p[own, 1] - p[own, 0], p[own, 2] - p[own, 0]), axis=1) / 2.0
        assert math.isclose(areas.sum(), size, rel_tol=0.05), "float32 holds 1/100 this far away"
        assert np.allclose(p[own].reshape(-1, 3).mean(axis=0), points.mean(axis=0), atol=1.0)
        assert np.allclose(shades[own, :, :3], linear_from_srgb(np.array(color) / 255.0), atol=2e-3)
    assert first == len(p)


@settings(max_examples=15)
@given(name=NAMES, polygons=POLYGONS, scale=st.sampled_from([1, 255]), comment=st.booleans())
def test_off_of_any_polygons_and_colours_is_read_back_equal(tmp_path_factory, name, polygons, scale, comment):
    rings = [ring(place, count)[0] for place, count, _ in polygons]
    lines, first = [], 0
    for _, count, color in polygons:
        shade = " ".join(str(c) if scale == 255 else f"{c / 255:.6f}" for c in color)
        lines.append(f"{count} {' '.join(str(first + k) for k in range(count))} {shade}" + (" # a face" if comment else ""))
        first += count
    text = f"OFF\n{first} {len(rings)} 0\n" + "".join(f"{x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in np.concatenate(rings))
    path = tmp_path_factory.mktemp("off") / f"{name}.off"
    path.write_text(text + "\n".join(lines) + "\n", encoding="utf-8")
    model = cad.read(path)
    assert names(model) == [name]
    is_covered(model, polygons)


@settings(max_examples=15)
@given(name=NAMES, polygons=POLYGONS, form=st.sampled_from(FORMATS), of_vertices=st.booleans())
def test_ply_of_any_order_polygons_and_colours_is_read_back_equal(tmp_path_factory, name, polygons, form, of_vertices):
    rings = [ring(place, count)[0] for place, count, _ in polygons]
    firsts = np.cumsum([0, *(len(r) for r in rings)])
    lists = [list(range(firsts[i], firsts[i + 1])) for i in range(len(rings))]
    shades = ["uchar red", "uchar green", "uchar blue"]
    each = [color for (_, _, color), points in zip(polygons, rings, strict=True) for _ in points]
    points = [tuple(p.tolist()) for p in np.concatenate(rings)]
    if of_vertices:
        elements = [vertices(points, shades, each), faces(*lists)]
    else:
        elements = [vertices(points), faces(*lists, more=shades, rows=[color for _, _, color in polygons])]
    path = tmp_path_factory.mktemp("ply") / f"{name}.ply"
    path.write_bytes(ply(form, elements))
    model = cad.read(path)
    assert names(model) == [name]
    is_covered(model, polygons)
