"""The combined ID and depth test (IDD §5.4)."""

from .row import OBJECTS, ShadowTest

FAR_TEXELS = 1.0  # of ε_far where it is automatic, by measurement (docs/shadow_tests.md)

ROW = ShadowTest(
    name="id-depth",
    place=10,
    label="ID + depth",
    text="Compares object numbers and depths: an object shadows itself only beyond ε_far (IDD §5.4)",
    options=frozenset({"depths", "epsilon", "epsilon_far", "id_per_material"}),
    glsl="common_id_test.glsl",
    stored=OBJECTS,
    defines={"FAR_TEXELS": FAR_TEXELS},
)
