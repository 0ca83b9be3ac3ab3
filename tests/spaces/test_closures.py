"""Closures on diagrams: what leads to the initial state leads everywhere; one that was ended goes on."""

from __future__ import annotations

from collections.abc import Sequence

from mcpn._kernel import BudgetExceeded, Zdd
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.spaces.diagrams.spaces import DiagramMarkings
from mcpn.spaces.registry import Spaces
from tests.turns import ByTurns


def counters(count: int, *, last: bool) -> PetriNet:
    """Rings of three places each, that turn; the last place of the first ring may be left for ever."""
    builder = NetBuilder("counters")
    for ring in range(count):
        for place in range(3):
            builder.place(f"{ring}_{place}", initial=int(place == 0))
        for place in range(3):
            builder.transition(
                f"turn_{ring}_{place}", consume=[f"{ring}_{place}"], produce=[f"{ring}_{(place + 1) % 3}"]
            )
    if last:
        builder.place("out")
        builder.transition("leave", consume=["0_2"], produce=["out"])
    return builder.build()


class Counting(DiagramMarkings):
    """Counts its closures."""

    closures = 0

    def closure(self, begin: Zdd, events: Sequence[int], within: Zdd) -> Zdd:
        self.closures += 1
        return super().closure(begin, events, within)


def test_a_reversible_net_takes_one_closure_for_all_goals() -> None:
    space = Counting(Spaces(counters(4, last=False)).symbolic())
    goals = [space.marked([place]) for place in range(12)]
    assert all(space.reaching(goal) == space.everything for goal in goals)
    assert all(space.reached(goal) == space.everything for goal in goals)
    assert space.closures == 1
    assert not space.reaching(space.nothing)


def test_what_cannot_return_does_not_lead_everywhere() -> None:
    net = counters(2, last=True)
    space = DiagramMarkings(Spaces(net).symbolic())
    out = space.marked([6])
    assert space.returning == space.everything - out
    for place in range(3, 6):  # of the second ring, which turns for ever
        assert space.reaching(space.marked([place])) == space.everything
    assert space.reaching(space.marked([0])) == space.everything - out
    assert space.reaching(out) == space.everything
    assert space.reached(out) == out
    assert space.reached(space.marked([4])) == space.everything


def test_a_closure_goes_on_where_an_error_has_ended_it() -> None:
    space = ByTurns(Spaces(counters(6, last=True)).symbolic())
    space.most_steps, ended = 1, 0
    events = space.of(space.encoding.undoing, space.free, None)
    while True:
        try:
            found = space.closure(space.marked([18]), events, space.everything)
            break
        except BudgetExceeded:
            ended += 1
    assert ended > 1
    assert found == space.everything
