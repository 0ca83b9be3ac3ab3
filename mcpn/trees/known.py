"""What is known of nodes by their registered names: those of BehaviorTree.CPP 4 and of Nav2.

Source: BehaviorTree.CPP 4.10 (controls, decorators, actions) and the plugins of nav2_behavior_tree, read for
what they do when they are ticked; nothing of them is copied.
"""

from __future__ import annotations

import re
from types import MappingProxyType

_ANY = 200_000
CONTROLS = MappingProxyType(
    {
        "Sequence": (1, _ANY),
        "AsyncSequence": (1, _ANY),
        "SequenceWithMemory": (1, _ANY),
        "SequenceStar": (1, _ANY),
        "ReactiveSequence": (1, _ANY),
        "Fallback": (1, _ANY),
        "AsyncFallback": (1, _ANY),
        "ReactiveFallback": (1, _ANY),
        "Parallel": (1, _ANY),
        "ParallelAll": (1, _ANY),
        "IfThenElse": (2, 3),
        "WhileDoElse": (2, 3),
        "TryCatch": (2, _ANY),
        **{f"Switch{n}": (n + 1, n + 1) for n in range(2, 7)},
        "RecoveryNode": (2, 2),
        "PipelineSequence": (1, _ANY),
        "RoundRobin": (1, _ANY),
    }
)
"""Control nodes that are translated, with the least and the largest number of their children."""
WAITING = MappingProxyType(
    {
        "RateController": "the next period",
        "SpeedController": "the next period",
        "DistanceController": "the next stretch of way",
        "GoalUpdatedController": "a new goal",
    }
)
"""Decorators that tick their child as they are begun, and later only now and then: what they await."""
TRANSPARENT = frozenset({"GoalUpdater"})
"""Decorators that return what their child returns, and write the blackboard."""
DECORATORS = frozenset(
    {
        "Inverter",
        "ForceSuccess",
        "ForceFailure",
        "RetryUntilSuccessful",
        "RetryUntilSuccesful",
        "Repeat",
        "KeepRunningUntilFailure",
        "Timeout",
        "Delay",
        "RunOnce",
        "Precondition",
        "LoopInt",
        "LoopBool",
        "LoopDouble",
        "LoopString",
        "SingleTrigger",
        "PathLongerOnApproach",
        "SkipUnlessUpdated",
        "WaitValueUpdate",
        *WAITING,
        *TRANSPARENT,
    }
)
"""Decorators whose effect is known."""
SCRIPTS = frozenset({"Script", "SetBlackboard", "UnsetBlackboard", "AlwaysSuccess"})
"""Leaves that succeed at once and do nothing but write the blackboard."""
UNTRANSLATED = MappingProxyType(
    {
        "ManualSelector": "a person chooses its child",
        "PersistentSequence": "its index is data on the blackboard",
        "NonblockingSequence": "it ticks later children while earlier ones still run",
        "PauseResumeController": "services of ROS pause it",
        "ConsumeQueue": "its queue is data on the blackboard",
    }
)
"""Nodes that are known and not translated, and why."""
_CONDITIONS = """
GoalReached IsStuck TransformAvailable GoalUpdated GlobalUpdatedGoal IsBatteryLow IsBatteryCharging
DistanceTraveled TimeExpired PathExpiringTimer InitialPoseReceived WouldAControllerRecoveryHelp
WouldAPlannerRecoveryHelp WouldASmootherRecoveryHelp WouldARouteRecoveryHelp AreErrorCodesPresent
ArePosesNear IsGoalNearby IsWithinPathTrackingBounds IsStopped IsPoseOccupied ScriptCondition
WasEntryUpdated
"""
_AT_ONCE = """
TruncatePath TruncatePathLocal PlannerSelector ControllerSelector SmootherSelector
GoalCheckerSelector ProgressCheckerSelector PathHandlerSelector RemovePassedGoals GetPoseFromPath
GetCurrentPose ConcatenatePaths AppendGoalPoseToGoals ExtractRouteNodesAsGoals GetNextFewGoals
"""
CATEGORIES = MappingProxyType(
    dict.fromkeys(_CONDITIONS.split(), "Condition")
    | dict.fromkeys([*_AT_ONCE.split(), *SCRIPTS, "AlwaysFailure", "Sleep"], "Action")
)
"""What known leaves are."""
AT_ONCE = frozenset([*_CONDITIONS.split(), *_AT_ONCE.split(), *SCRIPTS, "AlwaysFailure"])
"""Known leaves that answer in the tick in which they are asked, and never run on."""
LOOKS_LIKE_CONDITION = re.compile(
    r"(Is|Are|Check|Has|Have|Would|Can|Was|is_|are_|has_|check_|can_)(?![a-z])|(is|has|are)[A-Z]"
)
"""Names that people give to conditions: IsBatteryFull, check_door."""
_SPELLED = {name.lower(): name for name in (*CONTROLS, *DECORATORS, *SCRIPTS, "AlwaysFailure")}
V3 = MappingProxyType({"RetryUntilSuccesful": "RetryUntilSuccessful", "SequenceStar": "SequenceWithMemory"})
"""Names of version 3 that version 4 spells otherwise."""


def spelled(tag: str) -> str:
    """The registered name that a tag means: some files write ``inverter``."""
    return tag if tag not in _SPELLED.values() and tag.lower() not in _SPELLED else _SPELLED[tag.lower()]
