"""Errors go from process to process: engines and local spaces may run in others."""

from __future__ import annotations

import pickle
import pkgutil
from importlib import import_module

import pytest

import mcpn
from mcpn.answers.compare import Disagreement
from mcpn.certificates.entries import EvidenceError
from mcpn.errors import (
    ConfluenceError,
    DivergenceError,
    InputError,
    LimitError,
    McpnError,
    PremiseError,
    Problem,
    Source,
    UnboundedError,
    UnsafeError,
    WorkersError,
)
from mcpn.files import OutsideError
from mcpn.mission.xml import InvalidMission


def kinds(kind: type[McpnError]) -> set[type[McpnError]]:
    """A kind of errors with all below it that are imported."""
    return {kind}.union(*(kinds(below) for below in kind.__subclasses__()))


ERRORS = [
    InvalidMission([Problem(Source("m.xml", 3), "no such activity")], None),
    InputError([Problem(Source("m.xml", 3), "no such activity"), Problem(None, "no robot")]),
    OutsideError([Problem(None, "other.xml is in another directory")]),
    LimitError("more than 5 states"),
    WorkersError("the last worker is gone"),
    UnsafeError("p", "t", ["q", "r"], ["u", "v"]),
    UnboundedError(["p"], ["t"], ["u", "v"], (-1, 2)),
    ConfluenceError("not confluent", [["a"], ["b", "c"]]),
    DivergenceError("divergent", [["a", "a"]]),
    PremiseError("o", "p", ["MISSION_EV_START"]),
    Disagreement("on states"),
    EvidenceError("The mission can end well.", "no run"),
]


@pytest.mark.parametrize("error", ERRORS, ids=lambda error: type(error).__name__)
def test_an_error_is_the_same_in_another_process(error: McpnError) -> None:
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert str(again) == str(error)
    assert vars(again) == vars(error)


def test_no_kind_of_error_is_left_out() -> None:
    for module in pkgutil.walk_packages(mcpn.__path__, "mcpn."):
        if not module.name.endswith("__main__"):
            import_module(module.name)
    abstract = {"McpnError", "SemanticsError"}
    assert {kind.__name__ for kind in kinds(McpnError)} - abstract == {
        type(error).__name__ for error in ERRORS
    }
