"""What any command prints where the semantics allow no answer."""

from __future__ import annotations

from mcpn.robot.runtime.documents import texts
from mcpn.robot.runtime.shapes import (
    Document,
    ListOf,
    ObjectOf,
    OneOf,
    String,
)

ERROR = Document(
    "error",
    "mcpn --json, where the semantics allow no answer",
    ObjectOf(
        "The mission is not safe, not confluent, or an internal run does not end; or the net is unbounded. "
        "The exit code is 1.",
        {
            "error": OneOf(
                "What stands in the way.",
                "unsafe",
                "unbounded",
                "nonconfluent",
                "divergent",
                "disagreement",
                "semantics",
            ),
            "message": String("A sentence."),
            "runs": ListOf(
                "Runs that show it; two where the outcome depends on an order.", texts("Events or firings.")
            ),
        },
    ),
)
