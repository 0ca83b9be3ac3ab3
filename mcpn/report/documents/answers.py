"""What is asked of a mission: verdicts, requirements, causes."""

from __future__ import annotations

from mcpn.report.documents.graphs import ANSWERED
from mcpn.robot.runtime.documents import REQUIREMENT, texts
from mcpn.robot.runtime.shapes import (
    Boolean,
    Document,
    Integer,
    ListOf,
    MapOf,
    Nullable,
    Number,
    ObjectOf,
    Shared,
    String,
)

RUN = Nullable(
    ObjectOf(
        "A run that shows it.",
        {
            "events": texts("Events of the run."),
            "firings": texts("All firings of the run."),
            "cycle": Nullable(
                Integer("Where the part begins that is repeated for ever; null where nothing is.")
            ),
            "notes": texts("What holds where along the run."),
        },
    )
)
"""A run that shows an answer, or null."""

CLAIM = ObjectOf(
    "A claim: what is said, with the formula that shows it.",
    {
        "key": String("The same in all versions of a mission: its kind, its subject, what helps."),
        "kind": String("Its kind: the table of claims says what it means."),
        "subject": texts("What it is about, by name."),
        "holds": Nullable(Boolean("Whether it is so; null where it is not known.")),
        "severity": String("required, advice or informative."),
        "reason": String("Why it is not known; else empty."),
        "assumes": ObjectOf(
            "What the runs may contain that it speaks of.",
            {
                "help": String("declared: declared events may happen and times be over; none: neither."),
                "repairs": String("all, or others: what it names is not repaired."),
                "failures": String("any: objectives may fail by themselves; forced: where they must."),
                "moment": String("start, some or every."),
                "given": texts("What else it takes, in words."),
            },
        ),
        "formula": Nullable(String("Holds on the stable states where it does; null where none says it.")),
        "refers_to": texts("Of a claim without help: the events with whose help it would be otherwise."),
        "during": texts("Objectives that run at moments of which it speaks; '': before the start."),
        "evidence": String("What shows it."),
        "sentence": String("The claim in words."),
    },
)
"""A claim as an object."""

CHECK = Document(
    "check",
    "mcpn check MISSION --json",
    ObjectOf(
        "Verdicts of a mission.",
        {
            "mission": String("Its name."),
            "places": Integer("Places of its net."),
            "transitions": Integer("Transitions of its net."),
            "markings": ObjectOf(
                "The markings graph; null where the check has not made it.",
                {
                    "states": Nullable(Integer("Markings.")),
                    "edges": Nullable(Integer("Firings between them.")),
                },
            ),
            "alternatives": ObjectOf(
                "The graph of stable states; null where it does not exist.",
                {
                    "states": Nullable(Integer("Stable states.")),
                    "edges": Nullable(Integer("Events between them.")),
                },
            ),
            "requirements?": ListOf(
                "What the mission says that it must satisfy; left out where it says nothing.",
                ObjectOf(
                    "",
                    {
                        **REQUIREMENT,
                        "holds": Nullable(
                            Boolean("Whether the formula holds; null where there are no states to ask.")
                        ),
                        "met": Nullable(Boolean("Whether the requirement is met.")),
                        "ignored": ListOf(
                            "Events that it names and that change nothing in some state: it holds of handled "
                            "ones.",
                            String("An event."),
                        ),
                        "vacuous": texts(
                            "Parts of a formula that holds of which it says nothing: it holds whatever they "
                            "are."
                        ),
                        "witness": RUN,
                    },
                ),
            ),
            "verdicts": ObjectOf(
                "By name: whether it holds, or null for not known.",
                {
                    "nominal_success": Nullable(
                        Boolean(
                            "Every run on which nothing fails succeeds, and they leave nothing out that is "
                            "meant to be entered."
                        )
                    ),
                    "safe": Nullable(Boolean("No place ever holds a second token.")),
                    "bounded": Nullable(Boolean("Finitely many markings.")),
                    "confluent": Nullable(
                        Boolean("The reaction to an event depends on no order of internal firings, and ends.")
                    ),
                    "events_handled?": Nullable(
                        Boolean(
                            "No event that must be handled is ignored; of missions that declare some with "
                            "required."
                        )
                    ),
                    "deadlock_free": Nullable(Boolean("No marking but the mission's ends allows no event.")),
                    "success_reachable": Nullable(Boolean("Some run succeeds.")),
                    "can_always_finish": Nullable(
                        Boolean("Whatever has happened, some run still ends the mission.")
                    ),
                    "can_always_end_safely?": Nullable(
                        Boolean(
                            "Whatever has happened, some run still ends the mission in success, or in an "
                            "abort that no failure of a safing objective leads to; of missions "
                            "that can abort."
                        )
                    ),
                    "abort_by_failure?": Nullable(
                        Boolean(
                            "Some run is aborted by the failure of an objective by whose success it aborts, "
                            "too (informative); of missions that can abort."
                        )
                    ),
                    "abort_reachable?": Nullable(
                        Boolean("Some run is aborted (informative); of missions that can abort.")
                    ),
                    "failure_reachable": Nullable(Boolean("Some run fails (informative).")),
                    "unselectable": Nullable(
                        Boolean("Something can never be selected, entered or used (informative).")
                    ),
                },
            ),
            "translated?": ListOf(
                "Where the mission was made of a behaviour tree: how much of that is exact.",
                ObjectOf(
                    "",
                    {
                        "from": String("The file of the tree."),
                        "library?": String("The libraries and versions as which it was read."),
                        "exact": Integer("How many of its nodes are exact.", least=None),
                        "approximations": ListOf(
                            "The other nodes.",
                            ObjectOf(
                                "",
                                {
                                    "node": String("The node."),
                                    "line": Nullable(
                                        Integer("Its line in the file of the tree.", least=None)
                                    ),
                                    "kind": String("time, more or left_out."),
                                    "why": String("What differs."),
                                },
                            ),
                        ),
                        "survives": String("Which answers hold of the tree."),
                    },
                ),
            ),
            "undecided": MapOf("By verdict that is null: why.", String()),
            "certificate?": MapOf("With --certificate: why a claim has no evidence, by claim.", String()),
            "checked?": MapOf(
                "With --certificate: of each other claim what certcheck says: proved, refuted, not checked.",
                String(),
            ),
            "claims": ListOf("All that is said of the mission, but for losses of hardware.", CLAIM),
            "runs": MapOf(
                "By key of a claim that the terminal tells unasked: a short run that shows it.",
                ObjectOf(
                    "A run.",
                    {
                        "events": texts("Its events in order."),
                        "repeats": Nullable(
                            Integer("So many events come before those that repeat for ever; null: none do.")
                        ),
                    },
                ),
            ),
            "warnings": ListOf(
                "What is suspicious in the mission, by its text and by its states.",
                ObjectOf(
                    "",
                    {
                        "file": Nullable(String("The file.")),
                        "line": Nullable(Integer("The line.", least=None)),
                        "message": String("What is suspicious, and why."),
                    },
                ),
            ),
            "witnesses": MapOf(
                "By verdict: runs that show it, the shortest first.",
                ListOf("Runs.", texts("A run: its events in order, and with --internal its firings.")),
            ),
            "ignored": ListOf(
                "Declared events that change nothing in some state.",
                ObjectOf(
                    "",
                    {
                        "event": String("Its name."),
                        "objectives": texts(
                            "What runs in states in which it is ignored, empty where there are none."
                        ),
                        "answering": texts(
                            "What runs, of what its handlers lead to, where it is answered already."
                        ),
                        "required": Boolean("Whether its declaration says that it must always be handled."),
                    },
                ),
            ),
            "late": ListOf(
                "Hardware whose loss is noticed late, and the consequences.",
                ObjectOf(
                    "",
                    {
                        "hardware": String("Its name."),
                        "unnoticed": ListOf(
                            "Objectives that go on after its loss, and can only fail, while nothing that "
                            "runs can tell.",
                            String("An objective."),
                        ),
                        "unnoticed_later": ListOf(
                            "Other objectives of which the same is so once other hardware has failed too.",
                            String("An objective."),
                        ),
                        "in_time": ListOf(
                            "Objectives that can succeed after its loss only if it is found out while they "
                            "run.",
                            String("An objective."),
                        ),
                    },
                ),
            ),
            "nominal": ObjectOf(
                "What runs do on which nothing fails.",
                {
                    "left_out": ListOf(
                        "Objectives that none of them enters, and that are meant to be entered.",
                        String("An objective."),
                    ),
                    "cycle": Nullable(
                        Integer(
                            "Index of the event of the run of nominal_success with which the part begins "
                            "that goes on for ever; null where it does not."
                        )
                    ),
                },
            ),
            "skipped?": ListOf(
                "Objectives that begin on the run that shows success, and never succeed on it; left out "
                "where there are none.",
                String("An objective; all its tries are one."),
            ),
            **ANSWERED,
        },
    ),
)

CUT_SETS = Shared("cut_sets", ListOf("Minimal cut sets, each a sorted list of hardware.", texts("Hardware.")))
CRITICAL = Shared(
    "critical",
    ListOf(
        "Critical events.",
        ObjectOf(
            "One event, by where it decides.",
            {
                "event": String("The event."),
                "objectives": texts("Objectives that run."),
                "mode": MapOf("Alternative by activity.", String()),
                "edges": Integer("Edges of the alternatives graph that it stands for."),
            },
        ),
    ),
)
GOAL = Shared(
    "goal",
    ObjectOf(
        "Why one goal fails.",
        {
            "cut_sets": CUT_SETS.meant("Of the mission at its start, of an objective at its entry."),
            "critical_events": texts("Events after which, in some states, only a repair helps, or nothing."),
            "condition": String("The cut sets as a sentence."),
            "moments": MapOf("Cut sets by moment: start, entry, whenever, sometime.", CUT_SETS),
            "critical": ObjectOf(
                "Critical events, where nothing is repaired and where something may be.",
                {
                    "without_repairs": CRITICAL,
                    "with_repairs": CRITICAL,
                },
            ),
            "runs?": ListOf(
                "For each cut set a shortest run to failure.",
                ObjectOf(
                    "One run.",
                    {
                        "cut_set": texts("Hardware."),
                        "events": Nullable(texts("The run.")),
                    },
                ),
            ),
            "unaided?": ObjectOf(
                "Of the mission: lost before the start where no declared event happens and no time is over.",
                {
                    "cut_sets": ListOf("Minimal cut sets.", texts("Hardware.")),
                    "helpers": texts("What makes up for those that are none with it."),
                },
            ),
            "monotone": Boolean("More losses are never better."),
        },
    ),
)
CAUSES = Document(
    "causes",
    "mcpn causes MISSION --json",
    ObjectOf(
        "What makes a mission fail.",
        {
            "mission": GOAL.meant("The mission."),
            "safety?": GOAL.meant("Of missions that can abort: ending in neither success nor a safe abort."),
            "unsafe_aborts?": ListOf(
                "Objectives that should make the robot safe: an abort by their failure is no safe end.",
                String("An objective."),
            ),
            "objectives": MapOf("By elementary objective.", GOAL),
            "claims": ListOf("What is said of losses of hardware.", CLAIM),
            "survival": ListOf(
                "The start, then each section.",
                ObjectOf(
                    "One moment.",
                    {
                        "section": Nullable(String("The section entered; null for the start.")),
                        "cut_sets": CUT_SETS.meant("Of the mission, from here."),
                        "always": Nullable(
                            Integer(
                                "So many losses are survived whichever they are; null where success is out "
                                "of reach."
                            )
                        ),
                        "at_most": Nullable(
                            Integer("So many may be survived; null where success is out of reach.")
                        ),
                        "run?": Nullable(texts("A run to success with the most losses.")),
                        "safety?": ObjectOf(
                            "Of missions that can abort: the same of a safe end, success or abort.",
                            {
                                "cut_sets": CUT_SETS.meant("Of a safe end, from here."),
                                "always": Nullable(
                                    Integer(
                                        "So many losses are survived whichever they are; null where a safe "
                                        "end is out of reach."
                                    )
                                ),
                                "at_most": Nullable(
                                    Integer("So many may be survived; null where a safe end is out of reach.")
                                ),
                                "run?": Nullable(texts("A run to a safe end with the most losses.")),
                            },
                        ),
                    },
                ),
            ),
            "certificate?": MapOf("With --certificate: why a claim has no evidence, by claim.", String()),
            "left_out": ListOf(
                "What the answer on a mission of more than 50 objectives does not hold.",
                ObjectOf(
                    "",
                    {
                        "what": String("What it is."),
                        "objectives": Integer("Objectives that were asked."),
                        "ask": String("The options that ask for it."),
                    },
                ),
            ),
            "checked?": MapOf(
                "With --certificate: of each other claim what certcheck says: proved, refuted, not checked.",
                String(),
            ),
            "no_risk?": String("With --rates: why there are no numbers of risk; the exit code is 2."),
            "risk?": ObjectOf(
                "With --rates: numbers of risk.",
                {
                    "success": Number("Probability of mission success."),
                    "failure": Number("Probability of mission failure."),
                    "abort?": Number("Probability of mission abort; of missions that can abort."),
                    "safety_importance?": MapOf(
                        "Birnbaum importance by hardware for a safe end, success or abort; of missions that "
                        "can abort.",
                        Number(),
                    ),
                    "degraded_modes": Nullable(
                        Number(
                            "Expected number of times that it comes into a degraded mode; null: without end."
                        )
                    ),
                    "importance": MapOf("Birnbaum importance by hardware.", Number()),
                    "unrated": ListOf(
                        "Declared events that interrupt something, and detections of what is lost, that have "
                        "no rate: they never happen in the numbers.",
                        String("An event."),
                    ),
                },
            ),
            "slopes?": MapOf(
                "With --rates: the derivative of the probability of success by the failure rate of hardware "
                "that has one; left out of missions of more than 100000 stable states.",
                Number(),
            ),
            "bounds?": MapOf(
                "With --rates, of a mission that has rates in intervals: by end a lower and an upper bound "
                "on its probability that hold for all rates in their intervals.",
                ListOf("", Number()),
            ),
            "within?": ObjectOf(
                "With --within: how probable each end is by a time.",
                {
                    "hours": Number("The time, in hours since the start of the mission."),
                    "success": Number("Probability that the mission has ended in success."),
                    "failure": Number("The same of failure."),
                    "abort?": Number("The same of abort; of missions that can abort."),
                    "error": Number("No probability is off by more."),
                    "steps": Integer("Steps of the uniformised chain that were done.", least=None),
                },
            ),
            **ANSWERED,
        },
    ),
)

FMECA = Document(
    "fmeca",
    "mcpn causes MISSION --fmeca FILE.json",
    ListOf(
        "The FMECA table of a mission.",
        ObjectOf(
            "One resource that fails during one objective.",
            {
                "hardware": String("The resource that fails."),
                "objective": String("The objective that runs."),
                "section": String("The section that it is in."),
                "local_effect": String("What the activities do."),
                "objective_effect": String("What that does to the objective."),
                "mission_effect": String("And to the mission."),
                "detection": String("How it is noticed."),
                "compensation": String("What goes on instead."),
                "recovery": String("What the return of the resource does."),
                "severity": String("The class of severity."),
                "with_others": String("The smallest company in which it is worse."),
                "claims": MapOf(
                    "By column the keys of the claims in its cell, which causes --json lists.",
                    ListOf("Of one cell.", String()),
                ),
            },
        ),
    ),
)
