"""What commands print and write as JSON: each format declared once.

The writers stand beside what they write; tests hold what they write against the declarations. What mcpn reads
again is declared in :mod:`mcpn.robot.runtime.documents`, for the runtime imports nothing else.
"""

from __future__ import annotations

from typing import Any

from mcpn.report.documents import (
    answers,
    asked,
    bench,
    controllers,
    errors,
    files,
    graphs,
    nets,
    tests,
    versions,
)
from mcpn.robot.runtime.documents import READ_AGAIN
from mcpn.robot.runtime.shapes import (
    Boolean,
    Document,
    Either,
    Integer,
    JsonShape,
    ListOf,
    MapOf,
    Nullable,
    Number,
    ObjectOf,
    OneOf,
    Shared,
    String,
)

IN_ORDER = (answers, asked, graphs, nets, controllers, tests, bench, files, errors, versions)

FORMATS: dict[str, Document] = {
    document.name: document
    for document in (
        *READ_AGAIN,
        *(each for module in IN_ORDER for each in vars(module).values()),
    )
    if isinstance(document, Document)
}
"""Every format, by its name."""


def json_schema(document: Document) -> dict[str, Any]:
    """The JSON Schema of a format, draft 2020-12.

    Args:
        document: The format.

    >>> json_schema(FORMATS["schema"])["title"]
    'mcpn schema --json'
    """
    parts: dict[str, Any] = {}
    schema = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": f"urn:mcpn:schema:{document.name}",
        "title": document.title,
        **_schema(document.shape, parts),
    }
    return schema | {"$defs": parts} if parts else schema


def _schema(shape: JsonShape, parts: dict[str, Any]) -> dict[str, Any]:
    """The schema of a value; those of named parts are added to ``parts``."""
    found = {"description": shape.meaning} if shape.meaning else {}
    if isinstance(shape, Nullable):
        schema = _schema(shape.shape, parts)
        return {**schema, "type": [schema["type"], "null"]}
    if isinstance(shape, Shared):
        if shape.name not in parts:
            parts[shape.name] = {}  # its place among the others is before those in it
            parts[shape.name] = _schema(shape.shape, parts)
        return {"$ref": f"#/$defs/{shape.name}", **found}
    match shape:
        case String():
            return {"type": "string", **found}
        case Boolean():
            return {"type": "boolean", **found}
        case Integer():
            return {"type": "integer", **found, **_given(minimum=shape.least)}
        case Number():
            return {"type": "number", **found, **_given(minimum=shape.least, exclusiveMinimum=shape.above)}
        case OneOf(values=[only]):
            return {**found, "const": only}
        case OneOf():
            return {**found, "enum": list(shape.values)}
        case Either():
            return {**found, "anyOf": [_schema(one, parts) for one in shape.shapes]}
        case ListOf():
            differ = {"uniqueItems": True} if shape.differ else {}
            return {"type": "array", **found, "items": _schema(shape.item, parts), **differ}
        case MapOf():
            return {"type": "object", **found, "additionalProperties": _schema(shape.value, parts)}
        case ObjectOf():
            return {
                "type": "object",
                **found,
                "properties": {key: _schema(value, parts) for key, value in shape.keys.items()},
                "required": shape.required,
                **({} if shape.others else {"additionalProperties": False}),
            }
    return found


def _given(**limits: float | None) -> dict[str, float]:
    return {key: limit for key, limit in limits.items() if limit is not None}
