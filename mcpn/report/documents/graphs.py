"""States of missions: graphs, listings, runs."""

from __future__ import annotations

from mcpn.robot.runtime.documents import ACTION, STATE, texts
from mcpn.robot.runtime.shapes import (
    Document,
    Integer,
    ListOf,
    MapOf,
    Nullable,
    Number,
    ObjectOf,
    OneOf,
    String,
)
from mcpn.spaces.engine_names import LOCAL, PYEDA, SPACE_ENGINES, SYMBOLIC

ANSWERED = {
    "engine": OneOf("The engine that answered.", "auto", *SPACE_ENGINES, PYEDA),
    "why": Nullable(String("Why it was chosen; null where it was named.")),
    "seconds": Number("How long it took.", least=0),
}
"""Which engine answered."""
OUTCOME = OneOf("How the mission has ended; null while it runs.", "success", "failure", "abort", None)

STATES = Document(
    "states",
    "mcpn states FILE --json",
    ObjectOf(
        "The markings graph of a mission or a net, counted.",
        {
            "places": Integer("Places of the net."),
            "transitions": Integer("Transitions of the net."),
            "states": Nullable(Integer("Markings, exactly; null where the engine does not count them.")),
            "edges": Nullable(Integer("Firings between them.")),
            "stable_states": Nullable(Integer("Markings that allow no internal transition.")),
            "dead_states": Nullable(Integer("Markings that allow no transition.")),
            "max_tokens": Nullable(Integer("The most tokens in a marking.")),
            "max_tokens_in_place": Nullable(
                Integer("The most tokens in a place: 1 where the net is 1-safe.")
            ),
            "nodes": Nullable(Integer("Nodes of the decision diagram.")),
            "peak_nodes": Nullable(Integer("The most nodes at once while it was made.")),
            **ANSWERED,
            "order": Nullable(
                String("The name of the order of places that won the race; null without a diagram.")
            ),
        },
    ),
)

ALTERNATIVES = Document(
    "alternatives",
    "mcpn alternatives MISSION --json",
    ObjectOf(
        "The graph of stable states, counted.",
        {
            "states": Integer("Stable states."),
            "edges": Integer("Events between them."),
            "events": Integer("Different events."),
            "method": OneOf("How it was made.", "direct", "reduction", SYMBOLIC, LOCAL),
            **ANSWERED,
        },
    ),
)

ALTERNATIVES_GRAPH = Document(
    "alternatives-graph",
    "mcpn alternatives MISSION -o FILE.json",
    ObjectOf(
        "The graph of stable states itself.",
        {
            "format": OneOf("Always this.", "mcpn-alternatives"),
            "version": OneOf("Always this.", 1),
            "initial": Integer("The state before the mission begins."),
            "states": ListOf(
                "States; edges name them by their index.",
                ObjectOf(
                    "One stable state.",
                    {
                        **STATE,
                        "outcome": OUTCOME,
                        "facts": MapOf("The value of each fact.", String()),
                        "unnoticed": texts("What of it the robot does not know yet."),
                    },
                ),
            ),
            "edges": ListOf(
                "Edges.",
                ObjectOf(
                    "One reaction of the robot.",
                    {
                        "from": Integer("A state."),
                        "event": String("What happens."),
                        "to": Integer("A state."),
                    },
                ),
            ),
        },
    ),
)

SIMULATE = Document(
    "simulate",
    "mcpn simulate MISSION --json",
    ObjectOf(
        "A mission played event by event.",
        {
            "steps": ListOf(
                "One for each event.",
                ObjectOf(
                    "What it changed.",
                    {
                        "event": String("What happened."),
                        "words": String("The same as a sentence."),
                        "actions": ListOf("Orders, in this order.", ACTION.shape),
                        "objectives": texts("Objectives that run now."),
                        "mode": MapOf("Alternative by activity that runs.", String()),
                        "out_of_service": texts("Hardware out of service."),
                        "outcome": OUTCOME,
                    },
                ),
            ),
            "possible": texts("Events that may happen next."),
            "outcome": OUTCOME,
        },
    ),
)
