"""Small lettering for legends: a five by seven pixel face of this project's own, drawn into arrays.

It needs nothing and knows Latin letters without their marks. What Blender's own fonts write, which know every script, is in
`blender/lettering.py`.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Sequence

import numpy as np

HEIGHT, WIDTH = 7, 5

# seven rows per glyph, five bits each, the leftmost pixel is the highest bit
_ROWS = {
    "0": "0e11131519110e",
    "1": "040c040404040e",
    "2": "0e11010204081f",
    "3": "1f02040201110e",
    "4": "02060a121f0202",
    "5": "1f101e0101110e",
    "6": "0608101e11110e",
    "7": "1f010204080808",
    "8": "0e11110e11110e",
    "9": "0e11110f01020c",
    "/": "01010204081010",
    ".": "00000000000c0c",
    "-": "0000001f000000",
    "=": "00001f001f0000",
    ">": "08040201020408",
    "<": "02040810080402",
    "%": "18190204081303",
    "(": "02040808080402",
    ")": "08040202020408",
    ":": "000c0c000c0c00",
    " ": "00000000000000",
    ",": "00000000040408",
    "+": "0004041f040400",
    "_": "0000000000001f",
    "°": "0e0a0e00000000",
    "?": "0e110106040004",
    "a": "00000e010f110f",
    "b": "1010161911111e",
    "c": "00000e1010110e",
    "d": "01010d1311110f",
    "e": "00000e111f100e",
    "f": "0609081c080808",
    "g": "000f11110f010e",
    "h": "10101619111111",
    "i": "04000c0404040e",
    "j": "0200060202120c",
    "k": "10101214181412",
    "l": "0c04040404040e",
    "m": "00001a15151111",
    "n": "00001619111111",
    "o": "00000e1111110e",
    "p": "00001e111e1010",
    "q": "00000d130f0101",
    "r": "00001619101010",
    "s": "00000e100e011e",
    "t": "08081c08080906",
    "u": "0000111111130d",
    "v": "00001111110a04",
    "w": "0000111115150a",
    "x": "0000110a040a11",
    "y": "000011110f010e",
    "z": "00001f0204081f",
}
_GLYPHS = {
    char: (np.frombuffer(bytes.fromhex(rows), np.uint8)[:, None] >> np.arange(WIDTH - 1, -1, -1)) & 1 == 1 for char, rows in _ROWS.items()
}
_CYRILLIC = "a,b,v,g,d,e,zh,z,i,j,k,l,m,n,o,p,r,s,t,u,f,kh,ts,ch,sh,shch,,y,,e,yu,ya"  # from а to я
_GREEK = "a,b,g,d,e,z,i,th,i,k,l,m,n,x,o,p,r,s,s,t,y,f,ch,ps,o"  # from α to ω
_SPELT = {ord(first) + i: word for first, row in (("а", _CYRILLIC), ("α", _GREEK)) for i, word in enumerate(row.split(","))}
_SPELT |= str.maketrans({"ё": "e", "й": "j", "є": "ye", "і": "i", "ї": "yi", "ґ": "g"})
_SPELT |= str.maketrans({"ø": "o", "æ": "ae", "œ": "oe", "ł": "l", "đ": "d", "ð": "d", "þ": "th", "ı": "i", "×": "x", "÷": "/"})
_SPELT |= str.maketrans({"[": "(", "]": ")", "{": "(", "}": ")", ";": ",", "|": "/", "\\": "/", "–": "-", "—": "-", "−": "-"})


def lettered(text: str, scale: int = 1) -> np.ndarray:
    """(7·scale, 6·scale·len) bool image of a text in lower case, digits and /.,-+=_<>%°?(): ; raises KeyError for any other character."""
    mask = np.zeros((HEIGHT, (WIDTH + 1) * len(text)), dtype=bool)
    for i, char in enumerate(text):
        mask[:, i * (WIDTH + 1) : i * (WIDTH + 1) + WIDTH] = _GLYPHS[char]
    return mask.repeat(scale, axis=0).repeat(scale, axis=1)


def printable(text: str) -> str:
    """`text` in the characters there are: lower case, marks dropped, Greek and Cyrillic spelt in Latin letters; of all others the number
    in Unicode, so that names stay apart: <914d>."""
    plain = unicodedata.normalize("NFKD", text.casefold().translate(_SPELT)).translate(_SPELT)
    return "".join(char if char in _GLYPHS else f"<{ord(char):x}>" for char in plain if not unicodedata.combining(char))


def lines(texts: Sequence[str], width: int) -> list[np.ndarray]:
    """(h, w) coverage 0…1 of each text in the characters there are, cut where it is wider than `width` pixels."""
    return [lettered(printable(text)[: width // (WIDTH + 1)]).astype(np.float32) for text in texts]


def draw_text(image: np.ndarray, text: str, centre_x: int, top: int, color: tuple[float, ...], scale: int = 1) -> None:
    """Draw `text` into (h, w, c) `image`, centred at a column, its top at a row; what falls outside is cut off."""
    mask = lettered(text, scale)
    left = centre_x - mask.shape[1] // 2
    y0, x0 = max(top, 0), max(left, 0)
    y1, x1 = min(top + mask.shape[0], image.shape[0]), min(left + mask.shape[1], image.shape[1])
    if y0 < y1 and x0 < x1:
        image[y0:y1, x0:x1][mask[y0 - top : y1 - top, x0 - left : x1 - left]] = color
