"""Controllers as they are written, and monitors of requirements, as JSON."""

from __future__ import annotations

from mcpn.robot.runtime.documents import texts
from mcpn.robot.runtime.shapes import (
    Boolean,
    Document,
    Integer,
    ListOf,
    MapOf,
    Nullable,
    ObjectOf,
    OneOf,
    String,
)

CONTROLLER = Document(
    "controller",
    "mcpn controller MISSION -o DIR --json",
    ObjectOf(
        "What the command wrote.",
        {
            "mission": String("Its name."),
            "form": OneOf(
                "A machine for each type of section, rules for each, or one machine.",
                "hierarchical",
                "modular",
                "flat",
            ),
            "size": String("A sentence."),
            "files": texts("The files written."),
            "walked?": String("With --certificate what ctlcheck, or sectionctl, says of controller.json."),
        },
    ),
)


MONITOR = Document(
    "monitor",
    "mcpn monitor MISSION -o DIR --json",
    ObjectOf(
        "What the command made, and what a log says.",
        {
            "mission": String("Its name."),
            "states": MapOf("By requirement the number of states of its monitor.", Integer(least=None)),
            "within_mission": MapOf(
                "By requirement whether the mission's own continuations decide, or any do.", Boolean()
            ),
            "unwatched": texts("Requirements that speak of what may happen, and are not watched."),
            "files": texts("The files written."),
            "log": Nullable(
                ObjectOf(
                    "What the log says; null without --log.",
                    {
                        "events": Integer("How many events it has."),
                        "values": MapOf(
                            "By requirement what is known after the last event.",
                            OneOf("", "violated", "satisfied", "open"),
                        ),
                        "findings": ListOf(
                            "What events decided.",
                            ObjectOf(
                                "One decision.",
                                {
                                    "requirement": String("The requirement."),
                                    "value": OneOf("What it is.", "violated", "satisfied"),
                                    "number": Integer(
                                        "The number of the event, from 1; 0: before the first."
                                    ),
                                    "event": Nullable(String("The event; null before the first.")),
                                },
                            ),
                        ),
                    },
                )
            ),
        },
    ),
)
