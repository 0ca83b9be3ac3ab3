"""What is asked of missions and nets by formulas and by name, and the words for it, as JSON."""

from __future__ import annotations

from mcpn.answers.safety import ASKED
from mcpn.report.documents.answers import RUN
from mcpn.robot.runtime.documents import texts
from mcpn.robot.runtime.shapes import Boolean, Document, Integer, ListOf, Nullable, ObjectOf, OneOf, String
from mcpn.spaces.engine_names import PYEDA, SPACE_ENGINES

ASK = Document(
    "ask",
    "mcpn ask FILE FORMULA... --json",
    ListOf(
        "Answers, in the order of the question.",
        ObjectOf(
            "One answer.",
            {
                "formula": String("What was asked, or the property's name."),
                "holds": Nullable(Boolean("The answer; null where it is a bound.")),
                "witness": RUN,
                "techniques?": texts("How it was answered."),
                "value?": Nullable(
                    Integer("Of a property that asks for a bound: the bound; null of none.", least=None)
                ),
                "unbounded?": Boolean("Of such a property: whether there is no bound."),
                "engine?": OneOf("The engine that answered.", "auto", *SPACE_ENGINES, "search", PYEDA),
                "why?": Nullable(String("Why it was chosen; null where it was named.")),
            },
        ),
    ),
)

ROBOT_SAFETY = Document(
    "robot-safety",
    "mcpn ask MISSION --robot-safety --json",
    ListOf(
        "The questions of a safety engineer, answered.",
        ObjectOf(
            "One question.",
            {
                "question": OneOf("Its name.", *ASKED),
                "sentence": String("What is asked, as a sentence that is to be true."),
                "holds": Nullable(Boolean("Whether it is; null where it does not apply, or is not known.")),
                "applies": Boolean("Whether it says something of this mission."),
                "why": texts("What stands against it, or why there is no answer."),
                "notes": texts("What the answer says, and what it leaves open."),
                "run": Nullable(texts("Events of a run that shows it.")),
            },
        ),
    ),
)

AUTOMATA = Document(
    "automata",
    "mcpn ask FILE FORMULA... --hoa --json",
    ListOf(
        "Automata, in the order of the formulas.",
        ObjectOf(
            "One of them.",
            {
                "formula": String("What was asked."),
                "classes": texts("Its classes, as far as its form shows them."),
                "hoa": String("The automaton, in the Hanoi format."),
            },
        ),
    ),
)

NAMED = {
    "name": String("The name; of rounds or tries the one that means all of them."),
    "copies": texts("Each of them by itself; empty where there is only one."),
    "description": Nullable(String("What the mission says of it.")),
}
"""What is said of each name that formulas may say."""
WORDS = Document(
    "words",
    "mcpn ask MISSION --json",
    ObjectOf(
        "The words of the mission that formulas are made of.",
        {
            "mission": String("Its name."),
            "objectives": ListOf(
                "For objective(x) and pending(x).",
                ObjectOf("", NAMED),
            ),
            "blocks": ListOf(
                "For block(x): those that hold objectives.",
                ObjectOf("", NAMED),
            ),
            "activities": ListOf(
                "For activity(x), alternative(x)=y, waiting(x) and refused(x).",
                ObjectOf(
                    "",
                    {
                        **NAMED,
                        "alternatives": texts("Its alternatives, in the order of preference."),
                    },
                ),
            ),
            "hardware": ListOf(
                "For oos(x) and available(x).",
                ObjectOf("", NAMED),
            ),
            "software": ListOf(
                "For available(x).",
                ObjectOf("", NAMED),
            ),
            "facts": ListOf(
                "For fact(x)=v.",
                ObjectOf(
                    "",
                    {
                        **NAMED,
                        "values": texts("Its values."),
                    },
                ),
            ),
            "events": ListOf(
                "For happens(x) and event(x).",
                ObjectOf("", NAMED),
            ),
            "ends": texts("How the mission may end: words by themselves."),
        },
    ),
)
