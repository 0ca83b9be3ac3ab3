"""What is said of files that are written: a report, a new mission, a schema."""

from __future__ import annotations

from mcpn.robot.runtime.documents import texts
from mcpn.robot.runtime.shapes import (
    Boolean,
    Document,
    Integer,
    MapOf,
    ObjectOf,
    OneOf,
    String,
)
from mcpn.spaces.engine_names import PYEDA, SPACE_ENGINES

REPORT = Document(
    "report",
    "mcpn report MISSION -o FILE.html --json",
    ObjectOf(
        "What the command wrote.",
        {
            "file": String("The page."),
            "bytes": Integer("Its size."),
            "engine": OneOf("The engine that answered.", "auto", *SPACE_ENGINES, PYEDA),
            "passed": Boolean("All required verdicts hold."),
        },
    ),
)


INIT = Document(
    "init",
    "mcpn init NAME --json",
    ObjectOf(
        "What the command wrote.",
        {
            "files": texts("The files."),
            "ledger?": ObjectOf(
                "With --from: what the nodes of the behaviour tree became.",
                {
                    "counts": MapOf(
                        "How many nodes of each kind: exact, time, more, left_out.", Integer(least=None)
                    ),
                    "survives": String("Which answers about the mission hold of the tree."),
                    "read_as": String("The libraries and versions as which it was read."),
                },
            ),
        },
    ),
)


SCHEMA = Document(
    "schema",
    "mcpn schema --json",
    ObjectOf(
        "A schema.",
        {
            "format": OneOf("Its language.", "RELAX NG", "JSON Schema"),
            "schema": String("Its text."),
        },
    ),
)
