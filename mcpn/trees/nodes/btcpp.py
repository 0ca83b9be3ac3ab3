"""Rows of the nodes of BehaviorTree.CPP, from 3.0 to 4.10: ports, and which outcomes each node has."""

from __future__ import annotations

from mcpn.trees.nodes.row import ANY, NodeRows
from mcpn.trees.nodes.versions import BTCPP as _LIBRARY

_rows = NodeRows(_LIBRARY)
_add = _rows.add
_add("Sequence", "3.0", "Control", "", "sequence", "children in turn, up to the first that fails")
_add("Fallback", "3.0", "Control", "", "fallback", "children in turn, up to the first that succeeds")
_add("AsyncSequence", "4.2", "Control", "", "async_sequence", "as Sequence, returning between children")
_add("AsyncFallback", "4.2", "Control", "", "async_fallback", "as Fallback, returning between children")
_add(
    "SequenceStar",
    "3.0-3.5",
    "Control",
    "",
    "with_memory_unhalted",
    "a sequence that goes on with the child that failed; halted, it begins anew",
    "more runs where it may be halted: it may go on or begin anew",
)
_add(
    "SequenceStar",
    "3.6",
    "Control",
    "",
    "with_memory",
    "a sequence that goes on with the child that failed or was halted (3.6.1); the old name in version 4",
)
_add(
    "SequenceWithMemory",
    "4.0",
    "Control",
    "",
    "with_memory",
    "a sequence that goes on with the child that failed or was halted",
)
_add(
    "ReactiveSequence",
    "3.0",
    "Control",
    "",
    "reactive_sequence",
    "earlier children are ticked again each time; up to the first that fails",
)
_add(
    "ReactiveFallback",
    "3.0",
    "Control",
    "",
    "reactive_fallback",
    "earlier children are ticked again each time; up to the first that succeeds",
)
_add(
    "Parallel",
    "3.0-3.5",
    "Control",
    "threshold:unsigned",
    "parallel",
    "succeeds with threshold successes, fails when these can no more be reached (until 3.5.1)",
)
_add(
    "Parallel",
    "3.5-3.7",
    "Control",
    "success_threshold:unsigned failure_threshold:unsigned",
    "parallel",
    "succeeds with so many successes, fails with so many failures or when it cannot succeed (since 3.5.2)",
)
_add(
    "Parallel",
    "3.8-3.8",
    "Control",
    "success_threshold:int failure_threshold:int=1",
    "parallel",
    "as before; negative numbers count from the number of children",
)
_add(
    "Parallel",
    "4.0",
    "Control",
    "success_count:int=-1 failure_count:int=1",
    "parallel",
    "as before; since 4.3 a skipped child counts as a success where success_count is negative",
    "exact; more runs where a child may be skipped",
)
_add(
    "ParallelAll",
    "4.3",
    "Control",
    "max_failures:int=1",
    "parallel_all",
    "waits for all children, and fails with so many failures",
    "exact with max_failures 1; else more runs",
)
_add(
    "IfThenElse",
    "3.5",
    "Control",
    "",
    "if_then_else",
    "the condition once, then the second child or the third",
    children=(2, 3),
)
_add(
    "WhileDoElse",
    "3.5",
    "Control",
    "",
    "while_do_else",
    "the condition at each tick, with the second child or the third",
    children=(2, 3),
)
_add(
    "TryCatch",
    "4.9",
    "Control",
    "catch_on_halt:bool=false",
    "try_catch",
    "a sequence; when it fails the last child is run, and then it has failed",
    children=(2, ANY),
)
for _n in range(2, 7):
    _add(
        f"Switch{_n}",
        "3.0",
        "Control",
        " ".join(["variable:text?", *(f"case_{i}:text?" for i in range(1, _n + 1))]),
        "switch",
        "the child of the case that fits a variable, else the last",
        "more runs: the variable is free",
        (_n + 1, _n + 1),
    )
_add(
    "ManualSelector",
    "3.0",
    "Control",
    "repeat_last_selection:bool=false",
    "a person chooses its child",
    "as a person chooses",
    "refused",
)
_add("Inverter", "3.0", "Decorator", "", "inverter", "success is failure, failure is success")
_add("ForceSuccess", "3.0", "Decorator", "", "force_success", "succeeds when its child has ended")
_add("ForceFailure", "3.0", "Decorator", "", "force_failure", "fails when its child has ended")
_add(
    "RetryUntilSuccesful",
    "3.0-3.8",
    "Decorator",
    "num_attempts:int",
    "retry",
    "the child again while it fails, so many times; -1: for ever",
)
_add(
    "RetryUntilSuccessful",
    "3.6",
    "Decorator",
    "num_attempts:int",
    "retry",
    "the child again while it fails, so many times; -1: for ever",
)
_add(
    "Repeat",
    "3.0",
    "Decorator",
    "num_cycles:int",
    "repeat",
    "the child again while it succeeds, so many times; -1: for ever",
)
_add(
    "KeepRunningUntilFailure",
    "3.0",
    "Decorator",
    "",
    "keep_running",
    "the child again and again, until it fails",
)
_add(
    "Timeout",
    "3.0",
    "Decorator",
    "msec:unsigned",
    "timeout",
    "halts its child when the time is over, and fails",
    "exact but for time",
)
_add(
    "Delay",
    "3.5",
    "Decorator",
    "delay_msec:unsigned",
    "delay",
    "waits, then as its child",
    "exact but for time",
)
_add(
    "RunOnce",
    "4.2",
    "Decorator",
    "then_skip:bool=true",
    "once",
    "its child the first time; later it is skipped, or returns the same",
    "exact where it is entered once; else more runs",
)
_add(
    "Precondition",
    "4.0",
    "Decorator",
    "if:text else:status=FAILURE",
    "precondition",
    "its child if a script holds as it is begun, else what else says",
    "more runs: the script is free",
)
for _type, _kind in {"Int": "ints", "Bool": "bools", "Double": "numbers", "String": "text"}.items():
    _add(
        f"Loop{_type}",
        "4.2",
        "Decorator",
        f"queue:{_kind} if_empty:status=SUCCESS value:text?",
        "loop",
        "the child once for each value of a queue, while it succeeds or is skipped",
        "exact where the queue is written in the tree",
    )
_add(
    "SkipUnlessUpdated",
    "4.6",
    "Decorator",
    "entry:text",
    "skip_unless_updated",
    "its child if an entry of the blackboard has changed, else skipped",
    "more runs: the entry is free",
)
_add(
    "WaitValueUpdate",
    "4.6",
    "Decorator",
    "entry:text",
    "wait_value_update",
    "waits for a change of an entry of the blackboard, then as its child",
    "more runs: the entry is free",
)
_add(
    "BlackboardCheckInt BlackboardCheckDouble BlackboardCheckString BlackboardCheckBool",
    "3.0-3.8",
    "Decorator",
    "value_A:text value_B:text return_on_mismatch:status",
    "unknown",
    "its child while two values are equal",
    "more runs: the values are free",
)
_add(
    "ConsumeQueue",
    "3.0",
    "Decorator",
    None,
    "its queue is data on the blackboard",
    "its child once for each value of a queue",
    "refused",
)
_add("AlwaysSuccess", "3.0", "Action", "", "succeeds", "succeeds")
_add("AlwaysFailure", "3.0", "Action", "", "fails", "fails")
_add("Script", "4.0", "Action", "code:text", "succeeds", "writes the blackboard, and succeeds")
_add(
    "SetBlackboard",
    "3.0",
    "Action",
    "value:text output_key:text",
    "succeeds",
    "writes the blackboard, and succeeds",
)
_add("UnsetBlackboard", "4.3", "Action", "key:text", "succeeds", "writes the blackboard, and succeeds")
_add(
    "ScriptCondition",
    "4.3",
    "Condition",
    "code:text",
    "asked",
    "whether a script holds",
    "exact: what it answers is free",
)
_add(
    "WasEntryUpdated",
    "4.6",
    "Condition",
    "entry:text",
    "asked",
    "whether an entry has changed",
    "exact: what it answers is free",
)
_add("Sleep", "4.3", "Action", "msec:unsigned", "sleep", "waits, and succeeds", "exact but for time")

BTCPP_ROWS = tuple(_rows.rows)
"""All of them."""
