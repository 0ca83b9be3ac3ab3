"""No argument of a function of the kernel ends the process."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from mcpn import _kernel as kernel
from tests.conftest import ROOT
from tests.kernel.arguments import LEFT_OUT, METHODS

NET = [([0], [0], [1], 0, False)]
PROGRAM = f"""
import runpy, sys
sys.path.append({str(ROOT)!r})  # behind the installed package, which is what is tested
runpy.run_module("tests.kernel.arguments", run_name="__main__", alter_sys=True)
"""


@pytest.mark.parametrize(
    "rounds", [20, pytest.param(10_000, marks=[pytest.mark.slow, pytest.mark.timeout(3600)])]
)
def test_drawn_arguments_are_answered_or_refused(rounds: int, fresh_seed: int) -> None:
    """Each round calls 150 functions on objects of its own, in its own process; the arguments fit mostly."""
    command = [sys.executable, "-P", "-c", PROGRAM, str(fresh_seed), str(rounds)]
    ran = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    lines = ran.stdout.splitlines()
    assert not [line for line in lines if not line.startswith("called")]
    times = {label: int(count) for _, count, label in map(str.split, lines)}
    assert METHODS.keys() <= times.keys()
    assert all(times.values())
    assert not LEFT_OUT & times.keys()


def test_markings_beyond_the_places_of_a_net_are_refused() -> None:
    beyond = np.array([[1 << 63]], dtype=np.uint64)
    net = kernel.SafeNet(2, NET, True)
    with pytest.raises(ValueError, match="no such place"):
        net.labels(beyond)
    offsets, none = np.array([0, 0]), np.array([], dtype=np.int64)
    with pytest.raises(ValueError, match="no such place"):
        net.passages(beyond, offsets, none, none.astype(np.uint32), [[]], [])
    full = kernel.SafeNet(64, NET, True)
    assert not full.labels(beyond).size


def test_big_steps_are_of_a_net_with_priorities() -> None:
    with pytest.raises(ValueError, match="a net with priorities"):
        kernel.BigSteps(kernel.SafeNet(2, NET, False), [0], [0, 1], [], 1 << 20, 100, 300)


def test_a_function_of_no_marking_is_refused() -> None:
    """It was encoded as the one that changes no marking."""
    net = kernel.SafeNet(2, [([0], [0], [1], 65535, False)], True)
    steps = kernel.BigSteps(net, [0], [0, 1], [], 4 << 20, 100, 300)
    store = kernel.Store(2)
    begun = steps.start(store)
    assert begun is not None
    found = steps.after(begun, 0)
    assert found is not None
    after, left, firings = found
    assert after == store.singleton([1])
    assert not left
    assert steps.function(begun, firings)
    for none in (store.empty(), after):
        for wide in (False, True):
            with pytest.raises(ValueError, match="a function of no marking"):
                steps.function(none, firings, wide)


def test_a_transition_is_no_rival_of_its_own() -> None:
    """One that puts back what it takes was looked for as what may crowd it, and read beyond all places."""
    drawn = [([1], [1], [2, 0, 1], 1, False), ([0], [0], [0], 1, False), ([], [], [1], 65535, False)]
    net = kernel.SafeNet(3, drawn, True)
    steps = kernel.BigSteps(net, [1, 2, 0], [0, 1, 2], [], 4 << 20, 100, 300)
    assert steps.start(kernel.Store(3)) is None  # its first firing is unsafe


def test_goals_are_those_of_the_net() -> None:
    """Those of fewer places were read beyond their end."""
    net = kernel.TokenNet(2, [([(0, 1)], [(0, -1), (1, 1)], 0)], False)
    other = kernel.Goals(1, [("at_most", [], [(0, 1)], 0)])
    with pytest.raises(ValueError, match="goals of another net"):
        net.seek([1, 0], other, 0, False)
    with pytest.raises(ValueError, match="goals of another net"):
        net.walk([1, 0], other, [0], 10, 10, 0)
    with pytest.raises(ValueError, match="goals of another net"):
        kernel.PathFinder(net, [1, 0], other, [0], [[]], 0, [False], [0])
    with pytest.raises(ValueError, match="goals of another net"):
        kernel.Checker(net, [1, 0], other, [("goal", [0])], 1 << 20)


def test_an_order_has_a_number_for_each_transition() -> None:
    net = kernel.TokenNet(2, [([(0, 1)], [(0, -1), (1, 1)], 0)], False)
    dead = kernel.Goals(2, [("dead", [], [], 0)])
    with pytest.raises(ValueError, match="one number in the order"):
        net.walk([1, 0], dead, [0], 10, 10, 0, False, [], [0, 1])
    assert net.walk([1, 0], dead, [0], 10, 10, 0, False, [], [7]) == [(0, [0])]


def test_what_is_nested_too_deep_for_the_stack_is_refused() -> None:
    net = kernel.TokenNet(2, [([(0, 1)], [(0, -1), (1, 1)], 0)], False)
    first: tuple[str, list[int], list[tuple[int, int]], int] = ("at_most", [], [(0, 1)], 0)
    with pytest.raises(ValueError, match="nested deeper than 1,000"):
        kernel.Goals(2, [first, *(("all", [i], [], 0) for i in range(1_000))])
    goals, nots = kernel.Goals(2, [first]), [("not", [i]) for i in range(1_000)]
    with pytest.raises(ValueError, match="nested deeper than 1,000"):
        kernel.Checker(net, [1, 0], goals, [("goal", [0]), *nots], 1 << 20)
    deepest = kernel.Checker(net, [1, 0], goals, [("goal", [0]), *nots[:-1]], 1 << 20)
    assert deepest.decide(999, 100_000) == "yes"


def test_nets_of_more_places_than_there_can_be_are_refused() -> None:
    """The number of words of 2^32 - 1 places was 0."""
    for places in (1 << 28) + 1, (1 << 32) - 1:
        with pytest.raises(ValueError, match="at most 2\\^28 places"):
            kernel.SafeNet(places, [], False)
        with pytest.raises(ValueError, match="at most 2\\^28 places"):
            kernel.TokenNet(places, [], False)
        with pytest.raises(ValueError, match="at most 2\\^28 places"):
            kernel.Goals(places, [])


def test_limits_that_are_hit_are_runtime_errors() -> None:
    """As the types of the module promise."""
    for error in kernel.StateLimit, kernel.BudgetExceeded, kernel.Cancelled:
        assert issubclass(error, RuntimeError)
