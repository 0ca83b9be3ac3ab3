"""What leads to a robot: controllers, monitors, benches, reports; and what every command may print."""

from __future__ import annotations

from mcpn.robot.runtime.documents import texts
from mcpn.robot.runtime.shapes import (
    Boolean,
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
from mcpn.spaces.engine_names import EXPLICIT, LOCAL, PYEDA, SYMBOLIC

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

LEFT_OUT = ListOf(
    "What could be no test.",
    ObjectOf("One of them.", {"name": String("What would happen in it."), "why": String("A sentence.")}),
)

TESTS = Document(
    "tests",
    "mcpn tests MISSION -o DIR --json",
    ObjectOf(
        "Sequences of events that take every edge of the controller.",
        {
            "mission": String("Its name."),
            "edges": Integer("Edges of sections that they take: all that some run takes."),
            "sequences": Integer("How many."),
            "events": Integer("Of all of them."),
            "files": texts("The files written."),
        },
    ),
)

MOCKS = Document(
    "mocks",
    "mcpn tests MISSION --btcpp FILE --tree TREE",
    ObjectOf(
        "Tests of the behaviour tree that a mission was made of.",
        {
            "mission": String("Its name."),
            "tree": String("The file of the tree."),
            "step": String("The entry of the root's blackboard that counts answers; 0 at the start."),
            "scenarios": ListOf(
                "The tests.",
                ObjectOf(
                    "One test.",
                    {
                        "name": String("What happens in it."),
                        "returns": OneOf(
                            "What the tree returns; null where that is not said.", "SUCCESS", "FAILURE", None
                        ),
                        "never": OneOf(
                            "What the tree never returns; null where that is not said.", "SUCCESS", None
                        ),
                        "answers": ListOf(
                            "What leaves answer, in order; empty where each always answers the same.",
                            ObjectOf(
                                "One answer.",
                                {
                                    "leaf": String("Its path in the tree."),
                                    "line": Nullable(Integer("Its line in the file of the tree.")),
                                    "answer": OneOf("What it answers.", "SUCCESS", "FAILURE"),
                                    "event": String("The event of the mission that this is."),
                                },
                            ),
                        ),
                        "rules": ObjectOf(
                            "What BehaviorTree.CPP loads: loadSubstitutionRuleFromJSON.",
                            {
                                "TestNodeConfigs": MapOf(
                                    "By name, how a node that replaces a leaf answers.",
                                    ObjectOf("As the library reads it.", {}, others=True),
                                ),
                                "SubstitutionRules": MapOf(
                                    "By path of a leaf, the name of what replaces it.", String("")
                                ),
                            },
                        ),
                    },
                ),
            ),
            "left_out": LEFT_OUT,
        },
    ),
)

MOCKS_TOLD = Document(
    "mocks-told",
    "mcpn tests MISSION --btcpp FILE --tree TREE --json",
    ObjectOf(
        "What the command wrote.",
        {
            "mission": String("Its name."),
            "tree": String("The file of the tree."),
            "scenarios": Integer("How many tests."),
            "left_out": LEFT_OUT,
            "files": texts("The file written."),
        },
    ),
)

ESTIMATED = {
    "mean": Number("Its share of the runs, or its mean."),
    "low": Number("The interval of the confidence that was asked for begins here."),
    "high": Number("It ends here."),
    "risk": Nullable(Number("The number of risk; null where there is none.")),
    "agrees": Nullable(Boolean("Whether it lies in the interval.")),
}
"""What runs estimate, beside the number of risk."""
ENDED = ObjectOf("Runs that ended so.", {"count": Integer("How many runs."), **ESTIMATED})
BENCH = Document(
    "bench",
    "mcpn bench MISSION --json",
    ObjectOf(
        "Many runs of the controller in virtual time.",
        {
            "mission": String("Its name."),
            "form": OneOf("Of its controller.", "hierarchical", "modular"),
            "runs": Integer("How many.", least=1),
            "seed": Integer("Of what happens in them.", least=None),
            "confidence": Number("Of the intervals."),
            "nominal": ObjectOf(
                "The run on which nothing fails.",
                {
                    "outcome": Nullable(String("How it ends; null where it does not.")),
                    "events": ListOf(
                        "Its events, up to its end, or to where it goes on for ever or nothing can succeed.",
                        String("An event."),
                    ),
                },
            ),
            "outcomes": ObjectOf(
                "How the runs ended.",
                {
                    "success": ENDED.meant("Runs that ended in success."),
                    "failure": ENDED.meant("In failure."),
                    "abort": ENDED.meant("In abort."),
                    "unfinished": ENDED.meant(
                        "Runs in which nothing more could happen, or more than 10,000 events did."
                    ),
                },
            ),
            "degraded_modes": ObjectOf("How often a run came into a degraded functioning mode.", ESTIMATED),
            "hours": Nullable(
                Number(
                    "Mean length of a run, in virtual time; null where objectives have no duration.", least=0
                )
            ),
            "no_risk": Nullable(String("Why no numbers of risk stand beside.")),
            "coverage": ObjectOf(
                "What the runs have seen of the controller.",
                {
                    "modes": Integer("Functioning modes.", least=None),
                    "of_modes": Nullable(Integer("Of so many; null of rules, which list none.", least=None)),
                    "edges": Integer("Edges of sections: each event in each state.", least=None),
                    "of_edges": Nullable(Integer("Of so many.", least=None)),
                },
            ),
            "against": Nullable(
                ObjectOf(
                    "Generated code beside the runtime, where it was asked for.",
                    {
                        "target": OneOf("Which.", "c", "python", "scxml"),
                        "agrees": Boolean("Whether it does the same on every event of every run."),
                        "events": texts("Else the events up to the first difference."),
                        "expected": Nullable(String("What the runtime does on the last of them.")),
                        "found": Nullable(String("What the program printed.")),
                    },
                )
            ),
            "monitors": Nullable(
                MapOf(
                    "By requirement, in how many runs it was violated, satisfied or left open; null where "
                    "nothing watched.",
                    ObjectOf(
                        "Of one requirement.",
                        {
                            "violated": Integer("Runs that violated it."),
                            "satisfied": Integer("Runs that satisfied it whatever might have come."),
                            "open": Integer("Runs that left it open."),
                        },
                    ),
                )
            ),
            "traces": texts("Journals of the first runs that did not end in success."),
            "events": Integer("Events that were taken."),
            "seconds": Number("How long the runs took.", least=0),
        },
    ),
)

REPORT = Document(
    "report",
    "mcpn report MISSION -o FILE.html --json",
    ObjectOf(
        "What the command wrote.",
        {
            "file": String("The page."),
            "bytes": Integer("Its size."),
            "engine": OneOf("The engine that answered.", "auto", EXPLICIT, SYMBOLIC, LOCAL, PYEDA),
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
