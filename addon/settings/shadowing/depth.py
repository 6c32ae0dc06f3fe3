"""The depth test: the map's depth against the surface's, with a bias (Williams 1978; the bias: docs/shadow_tests.md)."""

from .row import ShadowTest

ROW = ShadowTest(
    name="depth",
    place=0,
    label="Depth",
    text="Compares depths, with a bias against self-shadowing",
    options=frozenset({"depths", "bias_strategy", "bias"}),
    glsl="common_depth_test.glsl",
)
