"""Tests of a controller and of a behaviour tree, as JSON."""

from __future__ import annotations

from mcpn.robot.runtime.documents import texts
from mcpn.robot.runtime.shapes import (
    Document,
    Integer,
    ListOf,
    MapOf,
    Nullable,
    ObjectOf,
    OneOf,
    String,
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
