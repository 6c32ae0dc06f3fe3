"""JSON Schema, as far as the shipped schema of reports uses it: `faults` lists what a value does not hold to; an unknown word is an error.

Source: JSON Schema, draft 2020-12: `type`, `required`, `properties`, `additionalProperties`, `items`, `$ref` within the document.
"""

import json
from collections.abc import Iterator

from tests.conftest import ROOT

REPORT = json.loads((ROOT / "addon" / "studies" / "report_schema.json").read_text(encoding="utf-8"))
WORDS = {"type", "required", "properties", "additionalProperties", "items", "$ref", "$defs", "$schema", "title", "description"}
KINDS = {"object": dict, "array": list, "string": str, "integer": int, "number": (int, float), "null": type(None), "boolean": bool}


def is_of(value: object, kind: str) -> bool:
    """Whether a value is of a JSON type; true and false are no numbers."""
    return isinstance(value, KINDS[kind]) and isinstance(value, bool) == (kind == "boolean")


def faults(value: object, schema: dict, root: dict = REPORT, at: str = "report") -> Iterator[str]:
    """What does not hold, and where."""
    if unknown := set(schema) - WORDS:
        raise ValueError(f"the schema says {unknown}, which is not checked")
    if "$ref" in schema:
        yield from faults(value, root["$defs"][schema["$ref"].removeprefix("#/$defs/")], root, at)
        return
    kinds = schema.get("type", list(KINDS))
    if not any(is_of(value, kind) for kind in ([kinds] if isinstance(kinds, str) else kinds)):
        yield f"{at} is {value!r}, not {kinds}"
        return
    if isinstance(value, dict):
        yield from (f"{at} has no {name}" for name in schema.get("required", ()) if name not in value)
        for name, one in value.items():
            inner = schema.get("properties", {}).get(name, schema.get("additionalProperties", {}))
            yield from faults(one, inner, root, f"{at}.{name}")
    if isinstance(value, list):
        for number, one in enumerate(value):
            yield from faults(one, schema.get("items", {}), root, f"{at}[{number}]")
