"""The triangle-exact test (method §8). Its numbers by measurement (docs/shadow_tests.md)."""

from .row import TRIANGLES, ShadowTest

FAR_TEXELS = 3.0  # of ε_far where it is automatic
REACH = 1  # cells each way that are looked at
MOST_STEPS = 64  # from triangle to triangle

ROW = ShadowTest(
    name="triangle",
    place=20,
    label="Triangle-exact",
    text="Tests the light ray against the very triangles found near it in the map: the sharpest edges, no bias (method §8)",
    options=frozenset({"epsilon_far", "outlines", "smoothing", "casters", "caster_error"}),
    glsl="common_triangle_test.glsl",
    stored=TRIANGLES,
    defines={"FAR_TEXELS": FAR_TEXELS, "REACH": REACH, "MOST_STEPS": MOST_STEPS, "INSIDE_ITS_TRIANGLE": 1},
    walks_surfaces=True,
)
