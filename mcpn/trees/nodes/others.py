"""Rows of the nodes of Nav2, PlanSys2 and py_trees."""

from __future__ import annotations

from mcpn.trees.nodes.row import NodeRows
from mcpn.trees.nodes.versions import NAV2, PLANSYS2, PY_TREES

_nav2 = NodeRows(NAV2)
_add = _nav2.add
_add(
    "RecoveryNode",
    "1.1",
    "Control",
    "number_of_retries:unsigned=1",
    "recovery",
    "the first child; when it fails the second, then the first again, so many times",
    "exact; more runs above 1,000 retries, or where the second child may be skipped",
    (2, 2),
)
_add(
    "PipelineSequence",
    "1.1",
    "Control",
    "",
    "pipeline",
    "a sequence whose earlier children go on being ticked",
)
_add(
    "RoundRobin",
    "1.1-1.4",
    "Control",
    "",
    "round_robin",
    "the next child in turn, up to the first that succeeds, the last one included; then the first is next",
)
_add(
    "RoundRobin",
    "1.5",
    "Control",
    "wrap_around:bool=false",
    "round_robin_wraps_or_not",
    "the next child in turn; without wrap_around it fails once its last child has ended, even by success",
)
_add(
    "NonblockingSequence",
    "1.4",
    "Control",
    "",
    "it ticks later children while earlier ones still run",
    "a sequence that does not wait",
    "refused",
)
_add(
    "PersistentSequence",
    "1.4",
    "Control",
    None,
    "its index is data on the blackboard",
    "a sequence with its index on the blackboard",
    "refused",
)
_add(
    "PauseResumeController", "1.4", "Control", None, "services of ROS pause it", "as services say", "refused"
)
_add(
    "RateController",
    "1.1",
    "Decorator",
    "hz:number=10.0",
    "waiting_rate",
    "its child at most so often",
    "exact but for time",
)
_add(
    "SpeedController",
    "1.1",
    "Decorator",
    "min_rate:number=0.1 max_rate:number=1.0 min_speed:number=0.0 max_speed:number=0.5 "
    "filter_duration:number=0.3 goal:text? goals:text?",
    "waiting_speed",
    "its child as often as the speed asks",
    "exact but for time",
)
_add(
    "DistanceController",
    "1.1",
    "Decorator",
    "distance:number=1.0 global_frame:text? robot_base_frame:text?",
    "waiting_distance",
    "its child after each stretch of way; fails where the robot has no pose",
    "exact but for time",
)
_add(
    "GoalUpdatedController",
    "1.1",
    "Decorator",
    "goal:text? goals:text?",
    "waiting_goal",
    "its child after each new goal",
    "exact but for time",
)
_add(
    "GoalUpdater",
    "1.1",
    "Decorator",
    "input_goal:text? input_goals:text? output_goal:text? output_goals:text?",
    "transparent",
    "as its child",
)
_add(
    "SingleTrigger",
    "1.1",
    "Decorator",
    "",
    "trigger",
    "its child the first time, and later failure",
    "exact where it is entered once; else more runs",
)
_add(
    "PathLongerOnApproach",
    "1.1",
    "Decorator",
    "path:text? prox_len:number=3.0 length_factor:number=2.0",
    "on_approach",
    "its child while the path has become longer near the goal, else success",
    "more runs: the path is free",
)
_add(
    "GoalReached IsStuck TransformAvailable GoalUpdated GlobalUpdatedGoal IsBatteryLow IsBatteryCharging "
    "DistanceTraveled TimeExpired PathExpiringTimer InitialPoseReceived WouldAControllerRecoveryHelp "
    "WouldAPlannerRecoveryHelp WouldASmootherRecoveryHelp WouldARouteRecoveryHelp AreErrorCodesPresent "
    "ArePosesNear IsGoalNearby IsWithinPathTrackingBounds IsStopped IsPoseOccupied IsPathValid",
    "1.1",
    "Condition",
    None,
    "asked",
    "answers at once, either way",
    "exact: what it answers is free",
)
_add(
    "TruncatePath TruncatePathLocal PlannerSelector ControllerSelector SmootherSelector GoalCheckerSelector "
    "ProgressCheckerSelector PathHandlerSelector RemovePassedGoals GetPoseFromPath GetCurrentPose "
    "ConcatenatePaths AppendGoalPoseToGoals ExtractRouteNodesAsGoals GetNextFewGoals",
    "1.1",
    "Action",
    None,
    "asked",
    "answers at once, either way",
    "exact: what it answers is free",
)

_plansys2 = NodeRows(PLANSYS2)
_add = _plansys2.add
_add(
    "CheckOverAllReq CheckAtEndReq CheckTimeout",
    "2.0",
    "Condition",
    "action:text",
    "asked",
    "whether a requirement of an action holds",
    "exact: what it answers is free",
)
_add(
    "ExecuteAction WaitAction WaitAtStartReq CheckAction",
    "2.0",
    "Action",
    "action:text",
    "leaf",
    "runs until an action has ended, or a requirement holds",
    "exact: what it answers is free",
)
_add(
    "ApplyAtStartEffect ApplyAtEndEffect",
    "2.0",
    "Action",
    "action:text",
    "asked",
    "applies an effect at once",
    "exact: what it answers is free",
)

_py_trees = NodeRows(PY_TREES)
_add = _py_trees.add
_add(
    "Sequence",
    "2.6",
    "Control",
    "memory:bool=true",
    "sequence_by_memory",
    "children in turn, up to the first that fails; without memory earlier ones are ticked again each time",
)
_add(
    "Selector Fallback",
    "2.6",
    "Control",
    "memory:bool=true",
    "selector_by_memory",
    "children in turn, up to the first that succeeds; without memory earlier ones are ticked again each time",
)
_add(
    "Parallel",
    "2.6",
    "Control",
    "policy:policy=success_on_one",
    "parallel_by_policy",
    "fails with the first failure; succeeds with the first success, or with that of all",
    "exact where all must succeed; else more runs",
)
_add("Inverter", "2.6", "Decorator", "", "inverter", "success is failure, failure is success")
_add("FailureIsSuccess", "2.6", "Decorator", "", "force_success", "succeeds when its child has ended")
_add("SuccessIsFailure", "2.6", "Decorator", "", "force_failure", "fails when its child has ended")
_add(
    "Retry",
    "2.6",
    "Decorator",
    "num_failures:int",
    "retry",
    "the child again while it fails, so many times; below 1: once",
)
_add(
    "Repeat",
    "2.6",
    "Decorator",
    "num_success:int",
    "repeat",
    "the child again while it succeeds, so many times; below 1: for ever",
)
_add("SuccessIsRunning", "2.6", "Decorator", "", "keep_running", "the child again and again, until it fails")
_add(
    "Timeout",
    "2.6",
    "Decorator",
    "duration:number=5.0",
    "timeout",
    "halts its child when the time is over, and fails",
    "exact but for time",
)
_add("PassThrough Count", "2.6", "Decorator", "", "transparent", "as its child")
_add("StatusToBlackboard", "2.6", "Decorator", "variable_name:text", "transparent", "as its child")
_add(
    "RunningIsFailure RunningIsSuccess FailureIsRunning",
    "2.6",
    "Decorator",
    "",
    "unknown",
    "turns what its child returns",
    "more runs",
)
_add(
    "OneShot",
    "2.6",
    "Decorator",
    "policy:text",
    "unknown",
    "its child once, later what that returned",
    "more runs",
)
_add(
    "ForEach",
    "2.6",
    "Decorator",
    "source_key:text target_key:text",
    "unknown",
    "the child once for each value of an entry, while it succeeds",
    "more runs",
)
_add(
    "EternalGuard",
    "2.6",
    "Decorator",
    None,
    "its condition is a function, which no attribute says",
    "its child while a condition holds",
    "refused",
)

OTHER_ROWS = (*_nav2.rows, *_plansys2.rows, *_py_trees.rows)
"""All of them."""
