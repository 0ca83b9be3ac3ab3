"""Key by key, what a controller, a monitor, a snapshot and a journal are: files that are read again."""

from __future__ import annotations

from typing import Any

from mcpn.robot.runtime.shapes import (
    Anything,
    Boolean,
    Document,
    Either,
    Integer,
    JsonShape,
    ListOf,
    MapOf,
    Misfit,
    Nullable,
    Number,
    ObjectOf,
    OneOf,
    Shared,
    String,
)

FORMAT, VERSION = "mcpn-controller", 1
MONITORS, MONITORS_VERSION = "mcpn-monitors", 2
SNAPSHOT, SNAPSHOT_VERSION = "mcpn-controller-snapshot", 2
FORMS = ("flat", "hierarchical", "modular")
"""Of a controller: machines with states, or in the last one rules."""
ENDS = {"succeed": "success", "fail": "failure", "abort": "abort"}
BEFORE, RUNNING = "before", "running"
"""Phases of a controller; the others are its :data:`ENDS`."""
VERBS = {
    "disarm": {"objective"},
    "stop": {"activity"},
    "release": {"hardware"},
    "select": {"activity", "alternative"},
    "start": {"activity"},
    "arm": {"objective"},
}
"""By verb of an action, what it must name."""
LISTS, MODES = ("objectives", "pending", "done", "refused"), ("mode", "waiting")
"""What a state shows: names, and alternatives by activity."""
KINDS = ("objectives", "activities", "alternatives", "hardware", "once", "facts")
"""Kinds of names in a section that may differ from those in its type."""


class _Action(ObjectOf):
    """An action names what its verb is about."""

    def _check(self, value: Any) -> None:
        super()._check(value)
        named = VERBS[value["do"]]
        if not named <= value.keys() <= named | {"do", "objective"}:
            raise Misfit(value, f"an action that names {', '.join(sorted(named))}")


def texts(meaning: str) -> ListOf:
    """Any texts."""
    return ListOf(meaning, String())


def names(meaning: str) -> ListOf:
    """Texts that differ."""
    return ListOf(meaning, String(), differ=True)


def numbers(meaning: str) -> ListOf:
    """Indices, or what is counted."""
    return ListOf(meaning, Integer())


ACTION = Shared(
    "action",
    _Action(
        "One order to the robot.",
        {
            "do": OneOf("What to do.", *VERBS),
            "activity?": String("The activity."),
            "alternative?": String("Of select: the alternative."),
            "hardware?": String("Of release: the resource."),
            "objective?": String("The objective that the activity is of; of a timer the objective or block."),
        },
    ),
)
PARAMETERS = Shared(
    "parameters",
    MapOf(
        "Parameters of the control laws by name.",
        ObjectOf(
            "One parameter.",
            {"value": String("As the mission says."), "unit": Nullable(String("As the mission says."))},
        ),
    ),
)
REQUIREMENT = {
    "name": String("Its name, qualified by the use of its protocol."),
    "formula": String("The formula."),
    "sentence": Nullable(String("What its pattern says, in English; null where it is written as a formula.")),
    "description": Nullable(String("Its author's words.")),
    "expected": OneOf("What the formula is to do.", "holds", "fails"),
    "severity": OneOf("Whether the mission fails where it is not met.", "required", "advice"),
}
FLAGS = {
    "gained": names("What becomes true of facts."),
    "lost": names("What is no longer true of them."),
}
STATE = {
    "objectives": texts("Objectives that run."),
    "pending": texts("Objectives about to be entered."),
    "done": texts("Branches that have ended."),
    "mode": MapOf("Alternative by activity.", String()),
    "waiting": MapOf("By activity that waits for a resource: the alternative.", String()),
    "refused": texts("Activities without a possible alternative."),
    "out_of_service": texts("Hardware out of service."),
}
"""What a stable state shows."""
HANDLERS = names("Its handlers that happen once, by where they are written.")
ACTIONS = ListOf("Orders, in this order.", ACTION)

MACHINE = ObjectOf(
    "One machine.",
    {
        "hardware": names("Its hardware."),
        "events": names("Its events."),
        "states": ListOf("Its states.", ObjectOf("What runs.", STATE)),
        "entries": ListOf(
            "One for each number whose bit i says that hardware i is out of service.",
            Nullable(
                ObjectOf(
                    "Where it is entered, or null.", {"to": Integer("A state."), "actions": ACTIONS, **FLAGS}
                )
            ),
        ),
        "edges": ListOf(
            "Its edges.",
            ObjectOf(
                "One reaction.",
                {
                    "from": Integer("A state."),
                    "event": Integer("An index in events."),
                    "to": Either(
                        "A state, or the outcome with which the section is left.", Integer(), String()
                    ),
                    "actions": ACTIONS,
                    "open": names("Handlers that must not have happened yet, and then have."),
                    "happened": names("Handlers that must have happened."),
                    **FLAGS,
                },
            ),
        ),
        "once": HANDLERS,
        "facts": names("What may be true of its facts."),
        "entering": Integer("How many of these have bits in the numbers of entries."),
    },
)
RULES = ObjectOf(
    "The rules of one type.",
    {
        "hardware": names("Its hardware."),
        "once": HANDLERS,
        "events": names("Its events."),
        "bits": Integer(
            "How many bits a state has. A literal 2 i asks that bit i is not set, 2 i + 1 that it is."
        ),
        "idle": numbers("The bits that are set before the entry, with all hardware in service."),
        "status": ListOf(
            "One for each of hardware, then of once, then of facts.",
            ObjectOf(
                "What says that it is out of service, has happened, or is true.",
                {
                    "changes": numbers("The bits that then change before the entry."),
                    "when": Integer("The literal that is then true inside."),
                },
            ),
        ),
        "shown": ListOf(
            "What a state says, in the mission's order.",
            ObjectOf(
                "One thing that may be so.",
                {
                    "kind": OneOf("What is said, as of a state of controller-document.", *LISTS, *MODES),
                    "name": String("Of what; in mode and waiting activity.alternative."),
                    "when": Integer("The literal that is true where it is so."),
                },
            ),
        ),
        "effects": ListOf(
            "What rules do.",
            ObjectOf(
                "One effect.",
                {
                    "changes": numbers("The bits that change."),
                    "actions": ACTIONS,
                    "to": Nullable(
                        String("The outcome with which the section is left; null where it goes on.")
                    ),
                    "then": numbers("The parts with which the event goes on, in order: indices in parts."),
                },
            ),
        ),
        "entries": ListOf(
            "How a section is entered: those that fit do the same.",
            ObjectOf(
                "One rule.",
                {"if": numbers("The literals that are true."), "do": Integer("An index in effects.")},
            ),
        ),
        "rules": ListOf(
            "What events do: those of one event that fit a state do the same.",
            ObjectOf(
                "One rule.",
                {
                    "event": Integer("An index in events."),
                    "if": numbers("The literals that are true."),
                    "do": Integer("An index in effects."),
                },
            ),
        ),
        "parts": ListOf(
            "What effects go on with: each decides some of what an event does.",
            ListOf(
                "The first of them that fits is taken; nothing is done where none does.",
                ObjectOf(
                    "One rule.",
                    {
                        "if": numbers(
                            "The literals that are true. For bits from the number of bits on they ask what "
                            "the effects so far have made of a state."
                        ),
                        "do": Integer("An index in effects, which goes on with no part."),
                    },
                ),
            ),
        ),
        "facts": names("What may be true of its facts."),
    },
)


def _controller(meaning: str, form: JsonShape, minimised: JsonShape, types: ListOf, what: str) -> ObjectOf:
    """A controller whose types are machines, or rules."""
    return ObjectOf(
        meaning,
        {
            "format": OneOf("Always this.", FORMAT),
            "version": OneOf("The format's version.", VERSION),
            "mission": String("Its name."),
            "form": form,
            "minimised": minimised,
            "unverified?": OneOf("Where `mcpn controller` wrote it with `--unverified`.", True),
            "hardware": names("Hardware that can fail."),
            "size?": String("How large it is, in words."),
            "all_hardware?": names("All hardware, what cannot fail too."),
            "common_causes?": names("Of these, what stands for a cause by which several resources fail."),
            "started?": names("Activities that some objective starts, itself or through resources."),
            "timers?": Integer("How many timers run at a time, at most."),
            "out_of_service": names("Hardware that is out of service at the start, where there is some."),
            "unrepairable": names("Hardware that is never repaired, where there is some."),
            "crashing": names(
                "Of the hardware that can fail, what stands for activities and alternatives that may crash: "
                "it fails only where a section says so."
            ),
            "late": MapOf(
                "By hardware that is detected late, what is true while it is out of service and the robot "
                "knows it: one of `facts` of types, though of no fact.",
                String(),
            ),
            "initial": String("The section entered at the start."),
            "sections": ListOf(
                "Sections of the mission.",
                ObjectOf(
                    "One section.",
                    {
                        "name": String("Its name."),
                        "type": Integer(f"Its {what}: an index in types."),
                        "routes": MapOf(
                            "By outcome: the section entered next, or succeed, fail or abort.",
                            String(),
                        ),
                        "events": names(f"Its own text of each event of the {what}."),
                        "names": ObjectOf(
                            f"By kind: its own names of those of the {what}; a name that is missing stays.",
                            {f"{kind}?": MapOf("Names.", String()) for kind in KINDS},
                        ),
                    },
                ),
            ),
            "types": types,
            "objectives": MapOf(
                "By objective: what control laws need.",
                ObjectOf(
                    "One.",
                    {
                        "activities": texts("Its activities."),
                        "parameters": PARAMETERS,
                        "timeout": Nullable(
                            Number("How long it may run, in seconds; null: any time.", above=0)
                        ),
                    },
                ),
            ),
            "blocks?": MapOf(
                "By block with a time of its own.",
                ObjectOf(
                    "One.",
                    {
                        "timeout": Number("How long it may run, in seconds.", above=0),
                        "objectives": texts("What it holds: it runs while one of them runs or is pending."),
                    },
                ),
            ),
            "activities": MapOf(
                "By activity: what control laws need.",
                ObjectOf(
                    "One.",
                    {
                        "produces": texts("Software resources."),
                        "parameters": PARAMETERS,
                        "alternatives": MapOf(
                            "By alternative.",
                            ObjectOf("One.", {"consumes": texts("Resources."), "parameters": PARAMETERS}),
                        ),
                    },
                ),
            ),
            "digest": String("SHA-256 of the object without it, as JSON with sorted keys and no spaces."),
            "facts": MapOf(
                "By fact and value, what is then true that was not at the start.", MapOf("", names(""))
            ),
            "changing": MapOf(
                "By event, what it makes true of facts and false, whatever runs.",
                ObjectOf("", {"true": names(""), "false": names("")}),
            ),
            "requirements": ListOf("What the mission says that it must satisfy.", ObjectOf("", REQUIREMENT)),
        },
    )


CONTROLLER = Document(
    "controller-document",
    "controller.json",
    _controller(
        "The controller that mcpn.robot.runtime runs. How it is run: docs/controller.md.",
        OneOf("A machine for each type of section, or one.", *FORMS[1::-1]),
        Boolean("States that no run distinguishes are merged."),
        ListOf("Machines.", MACHINE),
        "machine",
    ),
)
CONTROLLER_RULES = Document(
    "controller-rules",
    "controller.json, modular",
    _controller(
        "The modular controller that mcpn.robot.runtime runs. How it is run: docs/controller.md.",
        OneOf("Always this.", FORMS[-1]),
        OneOf("Always this: there are no states to merge.", False),
        ListOf("Rules of types of sections.", RULES),
        "rules",
    ),
)
MONITOR = Document(
    "monitors",
    "monitors.json of mcpn monitor MISSION -o DIR",
    ObjectOf(
        "Monitors: machines over the events of a mission, one for each requirement.",
        {
            "format": OneOf("What it is.", MONITORS),
            "version": OneOf("Of the format.", MONITORS_VERSION),
            "mission": String("Its name."),
            "events": names("Events of the mission, by number from 0."),
            "monitors": ListOf(
                "The monitors.",
                ObjectOf(
                    "A machine that begins in state 0; an event without a move changes nothing.",
                    {
                        "name": String("The requirement."),
                        "words": String("What it says."),
                        "formula": String("The same, as a formula."),
                        "within_mission": Boolean(
                            "Whether the mission's own continuations decide; else any do."
                        ),
                        "values": ListOf(
                            "By state what is known: 0 violated, 1 satisfied, 2 open.", OneOf("", 0, 1, 2)
                        ),
                        "moves": ListOf(
                            "By state its moves: the number of the event, the state after it.",
                            ListOf("", numbers("")),
                        ),
                    },
                ),
            ),
            "unwatched": texts("Requirements that speak of what may happen."),
            "digest": String("SHA-256 of the rest, as of a controller."),
        },
    ),
)
SAVED = Document(
    "snapshot",
    "snapshot of mcpn run MISSION --snapshot FILE",
    ObjectOf(
        "The state of a controller: one line, what it goes on from.",
        {
            "format": OneOf("What it is.", SNAPSHOT),
            "version": OneOf("Of the format.", SNAPSHOT_VERSION),
            "controller": String("The digest of the controller."),
            "phase": OneOf(
                "Before the start, while it runs, or how it has ended.", BEFORE, RUNNING, *ENDS.values()
            ),
            "section": Nullable(String("The section that runs; null where none does.")),
            "state": Integer("Its state: an index, or a set of bits where it has rules."),
            "out_of_service": names("Hardware that is out of service."),
            "happened": names("Handlers that have happened, and what is true of facts."),
            "count": Integer("Events that it has taken."),
            "timers?": MapOf(
                "By objective or block that runs: seconds that its timeout has left.", Number(least=0)
            ),
            "beside?": MapOf("What its writer keeps with it: monitors, programs that run.", Anything()),
            "digest": String("SHA-256 of the line without it."),
        },
    ),
)
PLACE = {
    "phase": OneOf("As in a snapshot.", BEFORE, RUNNING, *ENDS.values()),
    "section": Nullable(String("The section that runs.")),
    "state": Integer("Its state."),
    "objectives": texts("Objectives that run."),
    "mode": MapOf("Alternative by activity.", String()),
}
_SIGNED = {
    "time?": Number("Seconds: since 1970, of a bench since its start."),
    "digest?": String("SHA-256 of the line without it."),
}
STEP = ObjectOf(
    "One event.",
    {
        "event": String("What happened."),
        "refused": Boolean("Whether the controller refused it."),
        "number?": Integer("Its number, from 1; a refused one has that of the one before."),
        "from?": ObjectOf("Where the controller was.", PLACE),
        "to?": ObjectOf("Where it is.", PLACE),
        "actions?": texts("What it ordered, in this order."),
        **_SIGNED,
    },
    others=True,  # a log of another program may say more
)
RESUMED = ObjectOf("A run goes on.", {"resumed": Integer("Behind this event."), **_SIGNED})
JOURNAL = Document(
    "journal",
    "a line of mcpn run MISSION --journal FILE",
    Either("A line of what a controller did: an event, or that a run was resumed.", STEP, RESUMED),
)
READ_AGAIN = (CONTROLLER, CONTROLLER_RULES, MONITOR, SAVED, JOURNAL)
"""All formats of files that mcpn reads again."""
