"""What a second mission loses or gains over a first, as JSON."""

from __future__ import annotations

from mcpn.report.documents.answers import CLAIM
from mcpn.robot.runtime.documents import texts
from mcpn.robot.runtime.shapes import Boolean, Document, JsonShape, ListOf, MapOf, Nullable, ObjectOf, String


def _of_both(meaning: str, shape: JsonShape) -> ObjectOf:
    """What is so of two missions, or what each has alone."""
    return ObjectOf(meaning, {"first": shape, "second": shape})


def _changed(meaning: str) -> ListOf:
    """Claims with different answers."""
    keys: dict[str, JsonShape] = {"first": CLAIM, "second": CLAIM, "key": String("Its key, of both.")}
    return ListOf(meaning, ObjectOf("A claim, of each.", keys))


COMPARE_MISSIONS = Document(
    "compare-missions",
    "mcpn compare MISSION OTHER --json",
    ObjectOf(
        "What a second mission loses or gains over a first.",
        {
            "first": String("The file of the first."),
            "second": String("That of the second."),
            "same": Boolean("Whether nothing differs of what was compared."),
            "gained": _changed("Claims of which the second has the better answer."),
            "lost": _changed("Claims of which it has the worse one."),
            "changed": _changed("Claims that are neither good nor bad, or not known of one of them."),
            "claims": _of_both(
                "Claims that only one has: they are about what the other does not have.",
                ListOf("Of this mission alone.", CLAIM),
            ),
            "verdicts": MapOf(
                "By name, verdicts with different answers.",
                _of_both("Of each.", Nullable(Boolean("Whether it holds; null where it is not known."))),
            ),
            "cut_sets": MapOf(
                "By goal and moment, minimal cut sets that only one has.",
                _of_both("Of each.", ListOf("Only here.", texts("Hardware."))),
            ),
            "modes": MapOf(
                "By objective of both, functioning modes that only one has.",
                _of_both("Of each.", texts("Activities with the alternatives that run.")),
            ),
            "requirements": MapOf(
                "By name, requirements of both that do not ask the same.",
                _of_both("Of each.", String("What it asks: a formula, and how.")),
            ),
            "notes": texts("What was not compared, and why."),
        },
    ),
)
