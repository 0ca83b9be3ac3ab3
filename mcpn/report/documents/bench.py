"""Many runs of a controller in virtual time, as JSON."""

from __future__ import annotations

from mcpn.robot.bench import AGAINST
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
                        "target": OneOf("Which.", *AGAINST),
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
