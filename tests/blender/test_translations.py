"""The tab in other languages: every word that it shows at first sight has one, and Blender is given all of them."""

import pytest

from addon.settings.looks import LOOKS


@pytest.mark.parametrize("language", ["de_DE", "de"])
def test_every_word_of_the_tab_at_first_sight_is_there(room, language):
    sections, table = room("blender.panels.settings").SECTIONS, room("blender.translations").TABLES[language]
    sources = room("blender.properties").LIGHT_SOURCES
    shown = {section.label for section in sections} | {label for _, label, _ in sources} | {look.label for look in LOOKS.values()}
    shown |= {"Preview", "Live View", "Look", "Quality", "Custom", "Light", "Strength", "Azimuth", "Elevation", "Advice"}
    assert not shown - table.keys()
    assert all(word.strip() for word in table.values())


def test_what_is_translated_is_said_somewhere(room, blend):
    """No word of the table stands alone: each is a label of a panel, an operator or a property, a choice, or a text of a panel."""
    from pathlib import Path

    source = "".join(path.read_text(encoding="utf-8") for path in Path("addon").rglob("*.py") if path.name != "translations.py")
    assert not [text for text in room("blender.translations").GERMAN if f'"{text}"' not in source]


def test_blender_is_given_every_word_for_buttons_and_for_labels(room):
    given = room("blender.translations").words()["de_DE"]
    assert given["Operator", "Live View"] == given["*", "Live View"] == "Live-Ansicht"
