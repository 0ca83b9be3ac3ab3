"""No changed certificate, and no certificate of a changed net, proves a claim that is false."""

from __future__ import annotations

import copy
import importlib.util
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from types import ModuleType
from typing import Any

import pytest

from experiments.faults import both_checkers, core_mutants, further_mutants
from mcpn.certificates import certcheck, corecheck, ctlcheck, diagcheck
from mcpn.robot.runtime.actions import Action
from tests.conftest import ROOT


@pytest.fixture(scope="module")
def script() -> ModuleType:
    """The script that changes certificates."""
    folder = ROOT / "experiments" / "faults"
    spec = importlib.util.spec_from_file_location("certificate_mutants", folder / "certificates.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.path.insert(0, str(folder))
    try:
        spec.loader.exec_module(module)
    finally:
        sys.path.remove(str(folder))
    return module


def test_no_false_claim_is_proved(script: ModuleType) -> None:
    found, wrong = script.campaign(80, 3)
    assert wrong == []
    assert sum(times for how, times in found.items() if "no claim proved" in how) > 15
    assert sum(times for how, times in found.items() if "claim proved" not in how) > 15


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_no_false_claim_is_proved_of_many(script: ModuleType) -> None:
    assert script.campaign(10_000, 4)[1] == []


def test_a_checker_that_believes_everything_is_found_out(
    script: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(certcheck, "judge", lambda graph, claim: None)
    assert len(script.campaign(25, 3)[1]) > 2


@pytest.mark.parametrize("of", ["further", "diagrams"])
def test_no_false_claim_of_the_other_entries_is_proved(of: str) -> None:
    found, wrong = further_mutants.campaign(of, 6, 3)
    assert wrong == []
    assert sum(found.values()) == 6


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("of", ["further", "diagrams"])
def test_no_false_claim_of_the_other_entries_is_proved_of_many(of: str) -> None:
    assert further_mutants.campaign(of, 2_000, 5)[1] == []


def test_a_checker_of_diagrams_that_believes_everything_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(diagcheck, "judge", lambda of, claim: None)
    assert further_mutants.campaign("diagrams", 12, 2)[1]


@pytest.mark.parametrize("of", ["core", "controller"])
def test_nothing_else_is_accepted_beside_a_net(of: str) -> None:
    found, wrong = core_mutants.campaign(of, 8, 3)
    assert wrong == []
    assert sum(found.values()) == 8


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("of", ["core", "controller"])
def test_nothing_else_is_accepted_beside_a_net_of_many(of: str) -> None:
    assert core_mutants.campaign(of, 2_000, 5)[1] == []


@pytest.mark.parametrize(("of", "program"), [("core", corecheck), ("controller", ctlcheck)])
def test_a_walk_that_believes_everything_is_found_out(
    monkeypatch: pytest.MonkeyPatch, of: str, program: ModuleType
) -> None:
    monkeypatch.setattr(program, "walked", lambda graph, other: (1, 1))
    assert core_mutants.campaign(of, 10, 4)[1]


def without(controller: dict[str, Any], activities: set[str]) -> Iterator[dict[str, Any]]:
    """A flat controller in which, at one edge, these activities are told nothing, where they began anew."""
    for number, edge in enumerate(controller["types"][0]["edges"]):
        told = Counter((each.get("activity"), each["do"]) for each in edge["actions"])
        if all(told[name, verb] for name in activities for verb in ("stop", "start")):
            changed = copy.deepcopy(controller)
            actions = [each for each in edge["actions"] if each.get("activity") not in activities]
            changed["types"][0]["edges"][number]["actions"] = actions
            yield changed


def test_what_goes_on_instead_of_beginning_anew_is_not_false() -> None:
    """docs/certificates.md does not claim it, so ctlcheck proves it, and the campaign agrees."""
    original = core_mutants.original(core_mutants.HOME, ("flat",))
    (flat,) = original.controllers
    proved = [each for each in without(flat, {"rest"}) if both_checkers.accepted(original.net, each)[0]]
    assert proved
    assert not any(core_mutants._as_before(flat, each, "")[2] for each in proved)


CONSUMED = {"drive.mapped": "map wheels", "drive.blind": "wheels", "look.up": "eye wheels"}
AGAIN = (Action("stop", "drive"), Action("select", "drive", "mapped"), Action("start", "drive"))
TIMERS = (Action("disarm", objective="go"), Action("arm", objective="go"))


@pytest.mark.parametrize(
    ("orders", "before", "after", "left"),
    [
        ((*AGAIN, Action("release", hardware="map")), {"drive": "mapped"}, {"drive": "mapped"}, []),
        (AGAIN[:2], {"drive": "blind"}, {"drive": "mapped"}, ["stop drive", "select drive mapped"]),
        (AGAIN[:1], {"drive": "mapped"}, {}, ["stop drive"]),
        (
            (Action("stop", "look"), Action("release", hardware="wheels")),
            {"drive": "mapped", "look": "up"},
            {"drive": "mapped"},
            ["stop look", "release wheels"],
        ),
        (TIMERS, {}, {}, ["disarm go", "arm go"]),
        ((Action("disarm", objective="back"), Action("arm", objective="back")), {}, {}, []),
    ],
)
def test_what_is_asked_of_orders(
    orders: Sequence[Action], before: core_mutants.Runs, after: core_mutants.Runs, left: list[str]
) -> None:
    """All but what begins anew and may go on: the timer of what ends, and what another one held, is asked."""
    assert core_mutants.claimed("OBJ_go_EV_OK", orders, before, after, CONSUMED) == left
