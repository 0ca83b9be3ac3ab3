"""State machines that drive one template alone, in the most general environment of its contract.

A property of whole missions sees a template where some mission brings it. A machine of hypothesis brings it
everywhere: it plays all others at once, does in any order whatever the contract (``docs/templates.md``)
allows them, and looks after each step at what the template promises. What breaks is shrunk to a short
series of steps.

Hardware is driven, shared or not, what stands for crashes and what is detected late, software whose producer
does not serve, an activity that an objective starts, facts, and the objectives graph. What waits for another
activity's release, serving producers, returns to better alternatives, and where routes lead are left to whole
missions.

>>> from mcpn.drawing.templates import PaperTemplates
>>> driven(PaperTemplates(), profile="dev") is None
True
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from hypothesis import Phase, settings
from hypothesis.stateful import run_state_machine_as_test

from mcpn.drawing.templates import TemplateSet
from mcpn.mission.model import FactRoute, Handler, Objective, Parallel, Recursive
from mcpn.testing.by_hand import activity, hw, mission, robot
from mcpn.testing.kit.activity_machine import ActivityMachine
from mcpn.testing.kit.alone import TemplateMachine
from mcpn.testing.kit.control import ControlMachine, FactMachine
from mcpn.testing.kit.corpus import MISSIONS, objective
from mcpn.testing.kit.late_machines import CrashMachine, LateMachine
from mcpn.testing.kit.resources import HardwareMachine, SoftwareMachine
from mcpn.testing.kit.running import PROFILES
from mcpn.testing.kit.subject import Violation

STEPS = 40
"""Steps of one series at most."""

_SHARED = replace(hw("h")[0], shared=True)
_HARDWARE = mission(robot(hw("h"), activity("a", ("h",), ())), objective("x", "a"))
_OF_TWO = mission(
    robot((_SHARED,), activity("a", ("h",), ()), activity("b", ("h",), ())),
    Parallel(
        name="both", blocks=(Objective(name="x", activities=("a",)), Objective(name="y", activities=("b",)))
    ),
)
_DRIVER = mission(
    robot(
        hw("h", "w", "v"), activity("p", ("h",), produces=("s",)), activity("a", ("s", "w"), ("w",), ("v",))
    ),
    objective("x", "a"),
)

_CONTROL = mission(
    robot(
        hw("h"),
        *(activity(name, ("h",)) for name in "abcd"),
        events=("leak", "rain"),
    ),
    replace(
        objective("x", "a", failure="y"),
        retries=1,
        timeout=5.0,
        timeout_goto="z",
        failures=("stuck",),
        routes=(FactRoute(on="failure", reason="stuck", goto="y"),),
    ),
    Parallel(
        name="y",
        success_when="any",
        failure_when="any",
        handlers=(Handler(event="leak", goto="z", once=True), Handler(event="rain", pause="d")),
        blocks=(objective("u", "a", "b"), objective("v", "c")),
    ),
    Parallel(
        name="z",
        failure="fail",
        handlers=(Handler(event="leak", goto="x"),),
        blocks=(
            Recursive(name="r", blocks=(objective("s", "a", failure="abort"),)),
            objective("w", "c"),
        ),
    ),
    objective("d", "d"),
)

MACHINES: Mapping[str, tuple[type[TemplateMachine], Mapping[str, object]]] = {
    "hardware": (HardwareMachine, {"mission": _HARDWARE, "element": ("hardware", "h")}),
    "shared hardware": (
        HardwareMachine,
        {"mission": _OF_TWO, "element": ("hardware", "h"), "owners": ("a", "b")},
    ),
    "software": (
        SoftwareMachine,
        {"mission": _DRIVER, "element": ("software", "s"), "producer": ("activity", "p")},
    ),
    "activity": (ActivityMachine, {"mission": _DRIVER, "element": ("activity", "a")}),
    "crash": (
        CrashMachine,
        {"mission": MISSIONS["crashes"], "element": ("hardware", "a"), "activity": ("activity", "a")},
    ),
    "late loss": (
        LateMachine,
        {"mission": MISSIONS["found late"], "element": ("hardware", "h"), "looking": ("activity", "look")},
    ),
    "fact": (FactMachine, {"mission": MISSIONS["facts"], "element": ("fact", "lit")}),
    "control": (ControlMachine, {"mission": _CONTROL, "element": ("control", "m")}),
}
"""By template, the machine that drives it, and of which mission the template is."""

CONTROL_RUNS = 3
"""How many times as often the control is driven: more happens on the way to what a template does wrong."""


def machine_of(templates: TemplateSet | None, name: str) -> type[TemplateMachine]:
    """The class of machines that drive one template of a set, for a test of one's own.

    Args:
        templates: The set.
        name: One of :data:`MACHINES`.
    """
    base, known = MACHINES[name]
    return type(base.__name__, (base,), {**known, "templates": templates})


def driven(
    templates: TemplateSet | None, *, profile: str = "dev", only: str | None = None, shrink: bool = True
) -> Violation | None:
    """Drives each template of a set alone.

    Args:
        templates: The set.
        profile: One of :data:`mcpn.testing.kit.running.PROFILES`; how many series of steps are tried.
        only: One of :data:`MACHINES`; all of them by default.
        shrink: Whether a shortest series is looked for, once one is found.

    Returns:
        What the first template that breaks a promise does, after a short series of steps.
    """
    phases = [Phase.generate, Phase.shrink] if shrink else [Phase.generate]
    within = settings(PROFILES[profile], stateful_step_count=STEPS, phases=phases)
    for name in [only] if only else MACHINES:
        machine: Any = machine_of(templates, name)
        runs = within.max_examples * (CONTROL_RUNS if issubclass(machine, ControlMachine) else 1)
        try:
            run_state_machine_as_test(machine, settings=settings(within, max_examples=runs))
        except Violation as violation:
            return violation
    return None
