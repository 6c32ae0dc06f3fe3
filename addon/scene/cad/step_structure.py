"""What a STEP file says of its products that OpenCASCADE's GLB does not carry: names, places, colours, what is hidden, documents.

Products and their occurrences are known by the numbers of their statements (PRODUCT, NEXT_ASSEMBLY_USAGE_OCCURRENCE). Source: ISO 10303-41
to -46 as the recommended practices of CAx-IF use them (product structure, styling, external references).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cached_property

import numpy as np

from ...images.srgb import linear_from_srgb
from .step_text import Statements, numbers_of, references, text_of

OCCURRENCE, INVISIBLE, COMPLEX = b"NEXT_ASSEMBLY_USAGE_OCCURRENCE", b"INVISIBILITY", b""
STYLED = (b"STYLED_ITEM", b"OVER_RIDING_STYLED_ITEM", b"CONTEXT_DEPENDENT_OVER_RIDING_STYLED_ITEM")
DEFINITIONS = (b"PRODUCT_DEFINITION", b"PRODUCT_DEFINITION_WITH_ASSOCIATED_DOCUMENTS")
FORMATIONS = (b"PRODUCT_DEFINITION_FORMATION", b"PRODUCT_DEFINITION_FORMATION_WITH_SPECIFIED_SOURCE")
FACES = (b"ADVANCED_FACE", b"FACE_SURFACE")
WANTED = frozenset(
    {
        OCCURRENCE, INVISIBLE, COMPLEX, *STYLED, *DEFINITIONS, *FORMATIONS, *FACES, b"PRODUCT", b"SHAPE_DEFINITION_REPRESENTATION",
        b"SHAPE_REPRESENTATION_RELATIONSHIP", b"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION", b"PRODUCT_DEFINITION_SHAPE",
        b"PRESENTATION_STYLE_BY_CONTEXT", b"PRESENTATION_LAYER_ASSIGNMENT", b"APPLIED_DOCUMENT_REFERENCE", b"DOCUMENT_PRODUCT_EQUIVALENCE",
        b"DOCUMENT_FILE", b"APPLIED_EXTERNAL_IDENTIFICATION_ASSIGNMENT",
    }
)  # fmt: skip
NAMELESS = re.compile(r"|NAUO\d*|=>.*|[\d\s:.#_-]*|COMPONENT \d+|next assembly (usage|relationship).*|none", re.IGNORECASE | re.DOTALL)
PREDEFINED = {
    "red": (1, 0, 0), "green": (0, 1, 0), "blue": (0, 0, 1), "yellow": (1, 1, 0), "magenta": (1, 0, 1), "cyan": (0, 1, 1),
    "black": (0, 0, 0), "white": (1, 1, 1),
}  # fmt: skip
PREFIXES = {
    b"EXA": 1e18, b"PETA": 1e15, b"TERA": 1e12, b"GIGA": 1e9, b"MEGA": 1e6, b"KILO": 1e3, b"HECTO": 1e2, b"DECA": 10.0, b"DECI": 0.1,
    b"CENTI": 1e-2, b"MILLI": 1e-3, b"MICRO": 1e-6, b"NANO": 1e-9, b"PICO": 1e-12,
}  # fmt: skip


class Structure:
    """The products of a file's statements; parts that are missing or broken are as if they were not written."""

    def __init__(self, statements: Statements) -> None:
        self._s = statements
        self._units: dict[int, float | None] = {}

    def _all(self, *kinds: bytes) -> Iterator[tuple[int, list[bytes]]]:
        """Number and arguments of all statements of these types."""
        for kind in kinds:
            for number in self._s.of_type[kind]:
                yield number, self._s.arguments(number)

    @cached_property
    def products(self) -> dict[int | None, str]:
        """The name of each product, else its identifier."""
        return {n: text_of(a[1]) or text_of(a[0]) or f"Product {n}" for n, a in self._all(b"PRODUCT") if len(a) > 1}

    @cached_property
    def _product_of_formation(self) -> dict[int | None, int | None]:
        return {n: found for n, a in self._all(*FORMATIONS) if len(a) > 2 and (found := _first(a[2])) in self.products}

    @cached_property
    def _product_of_definition(self) -> dict[int | None, int | None]:
        of = self._product_of_formation
        return {n: of[found] for n, a in self._all(*DEFINITIONS) if len(a) > 2 and (found := _first(a[2])) in of}

    @cached_property
    def occurrences(self) -> dict[int | None, tuple[str, int | None, int | None]]:
        """Of each occurrence its own name ('' where it has none worth showing), the product that holds it, and the product that occurs."""
        of = self._product_of_definition
        found: dict[int | None, tuple[str, int | None, int | None]] = {}
        for number, a in self._all(OCCURRENCE):
            if len(a) > 4:
                name = text_of(a[1])
                found[number] = ("" if NAMELESS.fullmatch(name) else name, of.get(_first(a[3])), of.get(_first(a[4])))
        return found

    def title(self, occurrence: int | None) -> str:
        """The occurrence's name, else its product's."""
        name, _, product = self.occurrences[occurrence]
        return name or self.products.get(product, f"Part {occurrence}")

    @cached_property
    def _defined(self) -> dict[int | None, int]:
        """What each PRODUCT_DEFINITION_SHAPE is the shape of: an occurrence or a definition."""
        return {n: found for n, a in self._all(b"PRODUCT_DEFINITION_SHAPE") if len(a) > 2 and (found := _first(a[2])) is not None}

    @cached_property
    def representations(self) -> dict[int | None, list[int]]:
        """The shape representations of each product, with those equated to them."""
        equal: dict[int | None, list[int]] = {}
        for _, a in self._all(b"SHAPE_REPRESENTATION_RELATIONSHIP"):
            one, other = (_first(a[2]), _first(a[3])) if len(a) > 3 else (None, None)
            if one is not None and other is not None:
                equal.setdefault(one, []).append(other)
                equal.setdefault(other, []).append(one)
        found: dict[int | None, list[int]] = {}
        for _, a in self._all(b"SHAPE_DEFINITION_REPRESENTATION"):
            product = self._product_of_definition.get(self._defined.get(_first(a[0]))) if len(a) > 1 else None
            left: list[int | None] = [] if product is None else [_first(a[1])]
            own = found.setdefault(product, []) if product is not None else []
            while left:
                one = left.pop()
                if one is not None and one not in own:
                    own.append(one)
                    left += equal.get(one, [])
        return found

    def items(self, representation: int) -> list[int]:
        """The geometry of a shape representation: what it lists but its axes."""
        a = self._s.arguments(representation)
        listed = references(a[1]) if len(a) > 1 else []
        return [item for item in listed if self._s.kind(item) != b"AXIS2_PLACEMENT_3D"]

    @cached_property
    def _occurrence_of_context(self) -> dict[int | None, int | None]:
        """The occurrence that a context of styles stands for."""
        pairs: list[tuple[int | None, int | None]] = [
            (n, _first(a[1])) for n, a in self._all(b"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION") if len(a) > 1
        ]
        pairs += [(_first(a[1]), _first(a[0])) for _, a in self._all(b"SHAPE_DEFINITION_REPRESENTATION") if len(a) > 1]
        found = ((context, self._defined.get(shape)) for context, shape in pairs)
        return {context: one for context, one in found if one in self.occurrences}

    def _styles(self) -> Iterator[tuple[int, int | None, int, list[int]]]:
        """(styled item, occurrence or None, what is styled, roots of its style) of all styles."""
        for number, a in self._all(*STYLED):
            if len(a) < 3:
                continue
            contexts = references(a[4]) if len(a) > 4 else []
            for style in references(a[1]):
                roots, own = [style], contexts
                if self._s.kind(style) == b"PRESENTATION_STYLE_BY_CONTEXT" and len(b := self._s.arguments(style)) > 1:
                    roots, own = references(b[0]), references(b[1])
                occurrence = next((self._occurrence_of_context[c] for c in own if c in self._occurrence_of_context), None)
                yield number, occurrence, _first(a[2]) or -1, roots

    @cached_property
    def occurrence_colors(self) -> dict[int | None, tuple[float, ...]]:
        """The linear RGBA of each occurrence that has a colour of its own."""
        found: dict[int | None, tuple[float, ...]] = {}
        for _, occurrence, item, roots in self._styles():
            if occurrence is not None and self._s.kind(item) not in FACES and (color := self._color(roots)) is not None:
                found[occurrence] = color
        return found

    @cached_property
    def styled_in_context(self) -> list[int]:
        """The styled items that hold in one occurrence only."""
        return sorted({number for number, occurrence, _, _ in self._styles() if occurrence is not None})

    def _color(self, roots: list[int]) -> tuple[float, ...] | None:
        reached, color, alpha = sorted(self._s.reached(roots, frozenset({b"CURVE_STYLE"}))), None, 1.0
        for number in reached:
            kind, a = self._s.kind(number), self._s.arguments(number)
            if kind == b"COLOUR_RGB" and len(a) > 3:
                color = tuple(float(c) for c in a[1:4])
            elif kind == b"DRAUGHTING_PRE_DEFINED_COLOUR" and a:
                color = PREDEFINED.get(text_of(a[0]), color)
            elif kind == b"SURFACE_STYLE_TRANSPARENT" and a:
                alpha = 1.0 - float(a[0])
        if color is None:
            return None
        return (*(float(c) for c in linear_from_srgb(np.clip(np.array(color, float), 0.0, 1.0))), min(max(alpha, 0.0), 1.0))

    @cached_property
    def hidden(self) -> tuple[set[int | None], set[int | None], dict[int, set[int]]]:
        """The products that are hidden as a whole, the occurrences, and by representation the hidden geometry of other products."""
        named = {item for _, a in self._all(INVISIBLE) if a for item in references(a[0])}
        layers = {n: references(a[2]) for n, a in self._all(b"PRESENTATION_LAYER_ASSIGNMENT") if len(a) > 2}
        named |= {item for layer in named & layers.keys() for item in layers[layer]}
        items = set(named)
        occurrences: set[int | None] = set()
        for number, occurrence, item, _ in self._styles():
            if number in named:
                items.add(item) if occurrence is None else occurrences.add(occurrence)
        occurrences |= named & self.occurrences.keys()
        whole, partly = set(), {}
        for product, representations in self.representations.items() if items else ():
            geometry = {r: self.items(r) for r in representations}
            own = {r: set(g) & items for r, g in geometry.items()}
            if any(geometry.values()) and all(set(g) <= items or r in items for r, g in geometry.items()):
                whole.add(product)
            else:
                partly.update({r: pieces for r, pieces in own.items() if pieces})
        return whole, occurrences, partly

    @cached_property
    def documents(self) -> dict[int | None, str]:
        """The file that holds each product which is described elsewhere."""
        files: dict[int | None, str] = {n: text_of(a[0]) for n, a in self._all(b"DOCUMENT_FILE") if a}
        for _, a in self._all(b"APPLIED_EXTERNAL_IDENTIFICATION_ASSIGNMENT"):
            for n in references(a[3]) if len(a) > 3 else ():
                files[n] = files.get(n) or text_of(a[0])
        equivalent = {_first(a[2]): _first(a[3]) for _, a in self._all(b"DOCUMENT_PRODUCT_EQUIVALENCE") if len(a) > 3}
        held = {_first(a[2]): references(a[4]) for _, a in self._all(DEFINITIONS[1]) if len(a) > 4}
        found: dict[int | None, str] = {}
        for _, a in self._all(b"APPLIED_DOCUMENT_REFERENCE"):
            if len(a) > 2:
                document = _first(a[0])
                names = [files[n] for n in [document, *held.get(equivalent.get(document), [])] if files.get(n)]
                for n in references(a[2]) if names else ():
                    if n in self._product_of_definition:
                        found[self._product_of_definition[n]] = names[0]
        return found

    def unit(self, representation: int) -> float | None:
        """Metres per unit of length of a representation; None where it says none."""
        if representation not in self._units:
            self._units[representation] = self._unit_of(representation)
        return self._units[representation]

    def _unit_of(self, representation: int) -> float | None:
        a = self._s.arguments(representation)
        context = self._s.body(_first(a[2]) or -1) if len(a) > 2 else b""
        units = re.search(rb"GLOBAL_UNIT_ASSIGNED_CONTEXT\s*\(\s*\(([^)]*)\)", context)
        lengths = (self._length(n, 0) for n in (references(units[1]) if units else ()))
        return next((length for length in lengths if length is not None), None)

    def _length(self, number: int, depth: int) -> float | None:
        text = self._s.body(number)
        if b"LENGTH_UNIT" not in text or depth > 4:
            return None
        if plain := re.search(rb"SI_UNIT\s*\(\s*(?:\$|\.([A-Z]+)\.)\s*,\s*\.METRE\.", text):
            return PREFIXES.get(plain[1], 1.0) if plain[1] else 1.0
        converted = re.search(rb"CONVERSION_BASED_UNIT\s*\(\s*'[^']*'\s*,\s*#(\d+)", text)
        measure = self._s.body(int(converted[1])) if converted else b""
        value = re.search(rb"(?:MEASURE)\s*\(\s*([-+0-9.Ee]+)\s*\)\s*,\s*#(\d+)", measure)
        base = self._length(int(value[2]), depth + 1) if value else None
        return None if value is None or base is None else float(value[1]) * base

    @cached_property
    def places(self) -> dict[int | None, np.ndarray]:
        """(4, 4) where each occurrence stands in the product that holds it, metres."""
        found: dict[int | None, np.ndarray] = {}
        for _, a in self._all(b"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION"):
            occurrence = self._defined.get(_first(a[1])) if len(a) > 1 else None
            if occurrence in self.occurrences:
                place = self._place(_first(a[0]) or -1, occurrence)
                if place is not None:
                    found[occurrence] = place
        return found

    def _place(self, relation: int, occurrence: int | None) -> np.ndarray | None:
        text = self._s.body(relation)
        ends = re.search(rb"REPRESENTATION_RELATIONSHIP\s*\(\s*(?:'[^']*'|\$)\s*,\s*(?:'[^']*'|\$)\s*,\s*#(\d+)\s*,\s*#(\d+)", text)
        transformation = re.search(rb"WITH_TRANSFORMATION\s*\(\s*#(\d+)", text)
        if not ends or not transformation:
            return None
        a = self._s.arguments(int(transformation[1]))
        frames = [frame for one in a[2:4] if (frame := self._frame(_first(one))) is not None]
        unit = self.unit(int(ends[2])) or self.unit(int(ends[1]))
        if len(frames) < 2 or unit is None:
            return None
        holder = self.occurrences[occurrence][1]
        if int(ends[1]) in self.representations.get(holder, ()) and int(ends[2]) not in self.representations.get(holder, ()):
            frames.reverse()
        place = frames[1] @ np.linalg.inv(frames[0])
        place[:3, 3] *= unit
        return place

    def _frame(self, number: int | None) -> np.ndarray | None:
        """(4, 4) of an AXIS2_PLACEMENT_3D (ISO 10303-42, 4.4.15)."""
        a = self._s.arguments(number) if number is not None and self._s.kind(number) == b"AXIS2_PLACEMENT_3D" else []
        if len(a) < 4:
            return None
        given = [self._triple(_first(one)) for one in a[1:4]]
        z = np.array((0.0, 0.0, 1.0)) if given[1] is None else given[1]
        x = np.array((1.0, 0.0, 0.0)) if given[2] is None else given[2]
        length = float(np.linalg.norm(z))
        x = x - z * float(x @ z) / (length * length) if length > 0.0 else x
        if given[0] is None or length == 0.0 or float(np.linalg.norm(x)) < 1e-9:
            return None
        z, x = z / length, x / np.linalg.norm(x)
        frame = np.eye(4)
        frame[:3, :4] = np.stack([x, np.cross(z, x), z, given[0]], axis=1)
        return frame

    def _triple(self, number: int | None) -> np.ndarray | None:
        a = self._s.arguments(number) if number is not None else []
        values = numbers_of(a[1]) if len(a) > 1 else []
        return np.array(values) if len(values) == 3 else None


def _first(argument: bytes) -> int | None:
    found = references(argument)
    return found[0] if found else None
