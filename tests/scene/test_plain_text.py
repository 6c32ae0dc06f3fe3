"""Foreign text made fit to be shown: as a line, as lines, as JSON, the same characters are unfit."""

import json
import unicodedata

from addon.scene.plain_text import shown, shown_json, shown_lines
from addon.studies.outputs import json_text

CHARACTERS = [chr(code) for code in (*range(0x3000), *range(0xD800, 0xE000), 0xFEFF, 0x1F600)]
MOVES_OR_TURNS = {"\u2028", "\u2029", *"\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069"}


def test_what_moves_a_cursor_or_turns_the_reading_is_unfit_and_letters_are_not():
    unfit = {char for char in CHARACTERS if shown(char) != char}
    assert unfit == {char for char in CHARACTERS if unicodedata.category(char) in ("Cc", "Cs")} | MOVES_OR_TURNS
    assert {char for char in CHARACTERS if shown_lines(char) != char} == unfit - {"\n"}


def test_json_says_the_same_in_characters_that_are_fit():
    told = json_text({f"a{char}b": char for char in CHARACTERS})
    assert json.loads(told) == {f"a{char}b": char for char in CHARACTERS}
    assert shown_lines(told) == told and told.encode()
    assert shown_json('"ü 配管"\n') == '"ü 配管"\n'
