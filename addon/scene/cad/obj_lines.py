"""The lines of a Wavefront OBJ file sorted by kind, in runs of lines that begin alike, which numpy reads at once."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

BOM = b"\xef\xbb\xbf"
RUN = re.compile(
    rb"(?P<v>(?:[ \t]*+v[ \t][^\n]*+\n)++)|(?P<f>(?:[ \t]*+f[ \t][^\n]*+\n)++)|(?P<n>(?:[ \t]*+vn[ \t][^\n]*+\n)++)"
    rb"|(?P<t>(?:[ \t]*+vt[ \t][^\n]*+\n)++)|(?P<other>[^\n]*+\n)"
)
COMMENT = re.compile(rb"#[^\n]*")
INLINE = re.compile(rb"(?:^|\s)#.*")
LOST = {b"l": "line{s}", b"p": "point{s}", b"curv": "curve{s}", b"curv2": "curve{s}", b"surf": "free-form surface{s}"}


@dataclass(eq=False)
class Faces:
    """The face lines of one part and material, in `chunks`, and how many vertices, texture coordinates and normals stood before each."""

    part: int
    material: bytes | None
    chunks: list[bytes] = field(default_factory=list)
    before: list[tuple[int, int, int]] = field(default_factory=list)


@dataclass(eq=False)
class ObjLines:
    """`vertices`, `texture`, `normals`: their lines; `parts` the names in order; `lost` (kind, part) of what is not drawn."""

    vertices: list[bytes] = field(default_factory=list)
    texture: list[bytes] = field(default_factory=list)
    normals: list[bytes] = field(default_factory=list)
    faces: dict[tuple[int, bytes | None], Faces] = field(default_factory=dict)
    parts: list[bytes | None] = field(default_factory=lambda: [None])
    libraries: list[bytes] = field(default_factory=list)
    lost: list[tuple[str, int]] = field(default_factory=list)


def obj_lines(data: bytes) -> ObjLines:
    """The lines of a file. A part begins with every `o`, or with every `g` of another name in a file without any `o`."""
    data = data.removeprefix(BOM)
    if b"\\" in data:
        data = data.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ")
    data = (data if b"\n" in data else data.replace(b"\r", b"\n")) + b"\n"
    sorter = _Sorter(re.search(rb"(?m)^[ \t]*o[ \t]", data) is not None)
    for match in RUN.finditer(data):
        getattr(sorter, f"take_{match.lastgroup}")(match[0])
    return sorter.lines


class _Sorter:
    """Takes runs in the order of the file, and knows the part and material that faces belong to."""

    def __init__(self, by_object: bool) -> None:
        self.lines, self._by_object = ObjLines(), by_object
        self._part, self._counts = 0, [0, 0, 0]
        self._material: bytes | None = None
        self._groups: dict[bytes, int] = {}

    def take_v(self, run: bytes) -> None:
        """Vertices."""
        self.lines.vertices.append(run)
        self._counts[0] += run.count(b"\n")

    def take_t(self, run: bytes) -> None:
        """Texture coordinates."""
        self.lines.texture.append(run)
        self._counts[1] += run.count(b"\n")

    def take_n(self, run: bytes) -> None:
        """Normals."""
        self.lines.normals.append(run)
        self._counts[2] += run.count(b"\n")

    def take_f(self, run: bytes) -> None:
        """Faces."""
        key = (self._part, self._material)
        faces = self.lines.faces.get(key)
        if faces is None:
            faces = self.lines.faces[key] = Faces(*key)
        faces.chunks.append(run)
        faces.before.append((self._counts[0], self._counts[1], self._counts[2]))

    def take_other(self, run: bytes) -> None:
        """A line of any other kind."""
        words = run.split(None, 1)
        if len(words) < 2 or words[0].startswith(b"#"):
            return
        word, rest = words[0], INLINE.sub(b"", words[1]).strip()
        if word == b"usemtl":
            self._material = rest
        elif word == (b"o" if self._by_object else b"g"):
            self._begin(rest)
        elif word == b"mtllib":
            self.lines.libraries.append(rest)
        elif word in LOST:
            self.lines.lost.append((LOST[word], self._part))

    def _begin(self, name: bytes) -> None:
        """Another part; a group that was there before goes on."""
        if not self._by_object and name in self._groups:
            self._part = self._groups[name]
            return
        self._part = self._groups[name] = len(self.lines.parts)
        self.lines.parts.append(name)
