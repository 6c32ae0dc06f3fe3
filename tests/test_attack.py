"""Damaged files cost a line each: a subset of what `python -m benchmarks.attack` tries."""

import random

import pytest

pytest.importorskip("cascadio")

from benchmarks.attack import BAD, attack, damaged, mutants, unsound  # noqa: E402
from benchmarks.attack_seeds import seeds  # noqa: E402

EACH = {".step": 12}


@pytest.mark.parametrize("suffix", seeds())
def test_damaged_files_are_read_soundly_or_refused_in_a_line(suffix, tmp_path):
    said = []
    row = attack(suffix, seeds()[suffix], EACH.get(suffix, 60), 1, tmp_path, said.append)
    assert not any(row.get(kind) for kind in BAD), said


@pytest.mark.parametrize("suffix", seeds())
def test_the_whole_file_is_read(suffix, tmp_path):
    from addon.scene import cad

    path = tmp_path / f"whole{suffix}"
    path.write_bytes(seeds()[suffix].data)
    model = cad.read(path)
    assert model.triangle_count >= 12 and not unsound(model)


def test_damage_changes_most_files_and_is_the_same_again():
    seed = seeds()[".obj"]
    first, again = (list(mutants(seed, 50, "same")) for _ in range(2))
    assert first == again and sum(data != seed.data for data in first) > 40
    assert damaged(b"", random.Random(1)) is not None
