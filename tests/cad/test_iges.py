"""IGES: surfaces in the file's unit, called after the file where they have no name."""

import pytest

from addon.errors import CadFileError
from addon.scene import cad
from tests.cad.iges_writer import UNITS, iges
from tests.cad.measured import area, names

pytest.importorskip("cascadio")
PATCHES = [[[0, 0, z], [100, 0, z], [0, 50, z], [100, 50, z]] for z in (0, 10)]


@pytest.mark.parametrize(("unit", "metres"), list(zip(UNITS, (0.0254, 0.001, 1.0), strict=True)))
@pytest.mark.parametrize("suffix", ["igs", "IGES"])
def test_surfaces_are_read_in_the_unit_of_the_file(tmp_path, unit, metres, suffix):
    (tmp_path / f"Deckel.{suffix}").write_text(iges(PATCHES, unit))
    model = cad.read(tmp_path / f"Deckel.{suffix}")
    assert area(model) == pytest.approx(2 * 100 * 50 * metres**2, rel=1e-5)
    assert set(names(model)) == {"Deckel"}
    assert not model.warnings


def test_a_surface_far_from_its_origin_says_that_it_is_coarse(tmp_path):
    far = [[[x + 4e8, y + 5e9, z] for x, y, z in patch] for patch in PATCHES]
    (tmp_path / "far.igs").write_text(iges(far))
    try:
        assert any("coarse" in line for line in cad.read(tmp_path / "far.igs").warnings)
    except CadFileError as error:
        assert "no face" in str(error)


def test_a_cut_file_is_one_line(tmp_path):
    (tmp_path / "cut.igs").write_text(iges(PATCHES)[:500])
    with pytest.raises(CadFileError) as caught:
        cad.read(tmp_path / "cut.igs")
    assert str(caught.value).isprintable()
