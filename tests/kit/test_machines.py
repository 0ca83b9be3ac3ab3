"""Templates driven alone: mcpn's keep their promises, and each fault of such a template is found."""

from __future__ import annotations

import pytest
from hypothesis.stateful import run_state_machine_as_test

from experiments.faults.template_faults import BY_ELEMENT, FAULTS, HARMLESS, Faulty, Held
from mcpn.drawing.templates import PaperTemplates, TemplateSet
from mcpn.drawing.templates.compact import CompactTemplates
from mcpn.testing.kit.subject import Violation
from mcpn.testing.kit.units import MACHINES, driven, machine_of

DRIVEN = {"hardware": ("hardware", "shared hardware"), "software": ("software",), "activity": ("activity",)}
"""By kind of element, the machines."""

ELSEWHERE = {
    "it answers whether its producer runs or not": "serving producers",
    "it refuses whether its producer does or not": "serving producers",
    "it stops before anybody has decided: swapped ranks": "serving producers",
    "it is given back, and its producer asked for still": "serving producers",
    "it returns to what is not possible": "returns to better alternatives",
    "it never returns to what is better": "returns to better alternatives",
}
"""Faults that show where a template is of a form that no machine drives."""

ALONE = [
    name
    for element in ("hardware", "software", "activities")
    for name, (kind, *_) in BY_ELEMENT[element].items()
    if kind in DRIVEN and name not in ELSEWHERE
]
"""Faults of the forms that are driven."""

ONE_MACHINE = {
    "fact": (
        "an event changes nothing and ends what was",
        "an event leaves what was",
        "an event that changes facts never happens",
    ),
    "late loss": (
        *(name for name in BY_ELEMENT["late loss"] if name != "it is noticed, and suspected still"),
    ),
    "crash": (*BY_ELEMENT["crashes"],),
    "control": (
        "an objective succeeds and stops nothing",
        "an objective fails and runs still",
        "a block never ends",
        "a retry begins before what stops is idle",
        *BY_ELEMENT["timeout"],
        "a block is interrupted and halts no branch",
        "a branch is halted and nothing stops",
        "an interrupted block is never left",
        "a block aborts and halts no branch",
        "a block never aborts",
        "a block is decided and never left",
        "a block pauses and nothing stops",
        "what begins does not wait for what stops",
        "a gate never opens",
        "the mission starts, and may start again",
        "success is told as failure, and failure as success",
        "an objective succeeds whatever runs",
        "what runs during a pause never ends it",
    ),
}
"""Faults that one machine finds; what else is wrong with facts and control shows in whole missions."""


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize(
    "templates", [PaperTemplates(), CompactTemplates(at_once=0, combined=0)], ids=["paper", "compact"]
)
def test_our_templates_keep_their_promises(name: str, templates: TemplateSet) -> None:
    found = driven(templates, profile="dev", only=name)
    assert found is None, str(found)


@pytest.mark.parametrize("name", ALONE)
def test_each_fault_is_found(name: str) -> None:
    faulty = Faulty(*FAULTS[name])
    machines = DRIVEN[FAULTS[name][0]]
    assert any(driven(faulty, profile="ci", only=machine, shrink=False) for machine in machines)
    assert faulty.changed


@pytest.mark.parametrize(
    ("machine", "name"),
    [
        pytest.param(machine, name, marks=[pytest.mark.slow] * (machine == "control" and i >= 4))
        for machine, names in ONE_MACHINE.items()
        for i, name in enumerate(names)
    ],
)
def test_faults_of_facts_losses_and_control_are_found(machine: str, name: str) -> None:
    faulty = Faulty(*FAULTS[name])
    assert driven(faulty, profile="ci", only=machine, shrink=False)
    assert faulty.changed


@pytest.mark.slow
@pytest.mark.parametrize("name", [*ELSEWHERE, *(n for n, (kind, *_) in HARMLESS.items() if kind in DRIVEN)])
def test_other_faults_are_no_faults_here(name: str) -> None:
    fault = {**FAULTS, **HARMLESS}[name]
    for machine in DRIVEN[fault[0]]:
        assert driven(Faulty(*fault), profile="ci", only=machine, shrink=False) is None


@pytest.mark.parametrize("name", ["hardware", "shared hardware", "crash", "late loss"])
def test_hardware_of_other_names_is_driven_by_what_it_maps_them_to(name: str) -> None:
    found = driven(Held(), profile="dev", only=name)
    assert found is None, str(found)


def test_what_is_found_is_short() -> None:
    found = driven(Faulty(*FAULTS["it forgets its acknowledgement"]), profile="ci")
    assert isinstance(found, Violation)
    assert found.message == "an interface of h holds 0 tokens, after [asks] h_9"


def test_a_machine_is_one_of_hypothesis() -> None:
    """It can be run, and shown step by step, as any other."""
    machine = machine_of(Faulty(*FAULTS["it selects and does not ask"]), "activity")
    with pytest.raises(
        Violation, match=r"it runs or is refused in 0 ways, started: True, after \[starts\]"
    ) as caught:
        run_state_machine_as_test(machine)
    assert any("state.starts()" in note for note in caught.value.__notes__)
