"""Nets of no mission: their behaviour, their structure, engines side by side."""

from __future__ import annotations

from mcpn.nets.formats.json import SHAPE
from mcpn.robot.runtime.documents import texts
from mcpn.robot.runtime.shapes import (
    Anything,
    Boolean,
    Document,
    Either,
    Integer,
    ListOf,
    MapOf,
    Nullable,
    Number,
    ObjectOf,
    String,
)

_SIZES = ObjectOf(
    "Its counts; null where it gave up.",
    {
        "states": Nullable(Integer("Markings, exactly; null where the engine does not count them.")),
        "edges": Nullable(Integer("Firings between them.")),
        "stable_states": Nullable(Integer("Markings that allow no internal transition.")),
        "dead_states": Nullable(Integer("Markings that allow no transition.")),
        "max_tokens": Nullable(Integer("The most tokens in a marking.")),
        "nodes": Nullable(Integer("Nodes of the decision diagram.")),
        "peak_nodes": Nullable(Integer("The most nodes at once while it was made.")),
    },
)
ENGINE = ObjectOf(
    "What it found.",
    {
        "engine": String("Which."),
        "sizes": Nullable(_SIZES),
        "seconds": Number("Wall-clock time, imports apart: the least of all runs."),
        "megabytes": Nullable(Number("The most memory that its process held.")),
        "reason": String("Why it gave up, else empty."),
        "order": Nullable(String("The order of places that its diagram has.")),
        "cpu_seconds": Number("CPU time, imports apart: the least of all runs.", least=0),
        "median_seconds": Number("Wall-clock time, the median of all runs.", least=0),
        "median_cpu_seconds": Number("CPU time, the median of all runs.", least=0),
        "most_cpu_seconds": Number("CPU time, the most of all runs.", least=0),
        "repeats": Integer("How many runs there were.", least=1),
    },
)
_TRANSITION = ObjectOf(
    "A transition.",
    {
        "transition": String("Its name."),
        "event": Nullable(String("The event that fires it; null for an internal transition.")),
    },
)

CHECK_NET = Document(
    "check-net",
    "mcpn check NET --json",
    ObjectOf(
        "The behaviour of a net of no mission.",
        {
            "net": String("Its name."),
            "places": Integer("Its places."),
            "transitions": Integer("Its transitions."),
            "states": Nullable(Integer("Its markings, exactly.")),
            "safe": Nullable(Boolean("No place ever holds a second token.")),
            "bounded": Nullable(Boolean("Finitely many markings.")),
            "bound": Nullable(Integer("The most tokens in a place.")),
            "unbounded_by": Nullable(
                ObjectOf(
                    "A run, and what to repeat after it for ever.",
                    {
                        "run": texts("Firings."),
                        "repeat": texts("Firings."),
                    },
                )
            ),
            "deadlock_free": Nullable(Boolean("In each marking some transition may fire.")),
            "deadlock": Nullable(texts("Firings to a dead marking.")),
            "dead_marking": Nullable(MapOf("Its tokens by place.", Integer(least=None))),
            "bounds": Nullable(
                MapOf(
                    "The most tokens by place, null where there is no such number; null as a whole where it "
                    "is not computed.",
                    Nullable(Integer(least=None)),
                )
            ),
            "dead_transitions": Nullable(texts("Transitions that never fire.")),
            "live": Nullable(Boolean("Each transition can always fire again.")),
            "not_live": Nullable(texts("Transitions that may become impossible.")),
            "reversible": Nullable(Boolean("The initial marking can always be reached.")),
            "home_markings": Nullable(Integer("Markings that can always be reached.")),
        },
    ),
)

CHECK_STRUCTURE = Document(
    "check-structure",
    "mcpn check NET --structure --json",
    ObjectOf(
        "What the arcs of a net prove, without its markings.",
        {
            "net": String("Its name."),
            "classes": texts("Its classes."),
            "p_semiflows": Nullable(
                ListOf("Minimal invariants of places.", MapOf("Weights by name.", Integer(least=None)))
            ),
            "t_semiflows": Nullable(
                ListOf("Minimal invariants of transitions.", MapOf("Weights by name.", Integer(least=None)))
            ),
            "siphons": Nullable(ListOf("Minimal siphons.", texts("Places."))),
            "traps": Nullable(ListOf("Minimal traps.", texts("Places."))),
            "state_machine_components": Nullable(ListOf("State machines inside the net.", texts("Places."))),
            "conservative": Nullable(Boolean("An invariant of places covers all places.")),
            "covered_by_state_machines": Nullable(Boolean("State machines cover all places.")),
            "proves": texts("What follows for all markings: sentences."),
            "left_out": Anything("What was not computed, and which limit was hit."),
        },
    ),
)

NET = Document("net", "a net as .json", SHAPE)

CONVERT = Document(
    "convert",
    "mcpn convert SOURCE TARGET --json",
    ObjectOf(
        "What the command wrote.",
        {
            "file": String("The file."),
            "places?": Integer("Places of the net."),
            "transitions?": Integer("Transitions of the net."),
            "states?": Integer("With --rates: states of the chain."),
            "edges?": Integer("With --rates: edges of the chain, events with a rate."),
            "warnings": texts("What the format cannot say."),
        },
    ),
)

SIMULATE_TOKENS = Document(
    "simulate-tokens",
    "mcpn simulate FILE --tokens --json",
    ObjectOf(
        "A net played transition by transition.",
        {
            "fired": ListOf("The firings, in their order.", _TRANSITION),
            "marking": MapOf(
                "Tokens of the marked places.", Integer("How many the place holds.", least=None)
            ),
            "enabled": ListOf("What may fire now, priorities respected.", _TRANSITION),
        },
    ),
)

COMPARE = Document(
    "compare",
    "mcpn compare FILE --json",
    ObjectOf(
        "The engines side by side.",
        {
            "engines": ListOf(
                "One for each engine, of one subject; those of a family stand in its members.", ENGINE
            ),
            "members": ListOf(
                "The subject, or the members of the family.",
                ObjectOf(
                    "A subject.",
                    {
                        "name": String("Its name."),
                        "places": Integer("Of its net."),
                        "transitions": Integer("Of its net."),
                        "arcs": Integer("Of its net."),
                        "engines": ListOf("One for each engine.", ENGINE),
                        "size": Nullable(Integer("In its family; null of a subject of its own.")),
                    },
                ),
            ),
            "exponents": MapOf(
                "By engine, how what it takes grows with the size: slopes of lines through the logarithms, "
                "where three sizes are left to fit.",
                ObjectOf(
                    "Of one engine.",
                    {
                        "cpu_seconds?": Number(
                            "Of CPU time, the median; runs of less than a hundredth of a second are left out."
                        ),
                        "megabytes?": Number(
                            "Of memory; members on which the engine holds less than twice its least are left "
                            "out."
                        ),
                        "peak_nodes?": Number("Of the most nodes at once."),
                    },
                ),
            ),
            "machine": MapOf(
                "What the measurements depend on: the machine, its load, versions.",
                Either("", String(), Number()),
            ),
            "agree": Boolean("Whether counts are equal."),
            "message": Nullable(String("Where they are not.")),
        },
    ),
)
