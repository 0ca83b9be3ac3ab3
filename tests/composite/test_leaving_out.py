"""Whether a mission reaches its success without some events: by sections, and by a closure for each set."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given

from mcpn._kernel import Zdd
from mcpn.answers.claims import claims_of
from mcpn.answers.verdicts.mission import check
from mcpn.composite.composing import composite_space
from mcpn.composite.glued import Glued, SectionSets
from mcpn.composite.section_type import Allowed, SectionType
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.events import Event, What
from mcpn.mission.model import SUCCEED, Handler, Mission, Objective, Parallel
from mcpn.spaces.by_steps import BySteps
from mcpn.testing import missions
from tests.draws import composed, fewer
from tests.shares import returns_early
from tests.small import activity, hw, mission, robot


def check_each_set(net: MissionNet) -> list[bool]:
    space = composite_space(net)
    events = {t: event for t, each in enumerate(net.net.transitions) if (event := each.event) is not None}
    asked = [frozenset([t]) for t in events]
    asked += [frozenset(t for t, event in events.items() if event.what is what) for what in What]
    names = {event.element.partition("_try")[0] for event in events.values()}
    asked += [frozenset(t for t, e in events.items() if e.element.partition("_try")[0] == n) for n in names]
    won = space.marked([net.success])
    found = space.reaches_without(won, asked)
    assert found == BySteps.reaches_without(space, won, asked)
    return list(found)


@fewer(0.5, least=8)
@given(missions())
def test_each_set_is_left_out_as_by_a_closure_of_its_own(drawn: Mission) -> None:
    try:
        check_each_set(composed(drawn))
    except (SemanticsError, LimitError):
        returns_early("no composite")


def sites(number: int, *, back: str = "") -> MissionNet:
    """Sites with a retry each, the first of which must succeed; the last may lead back to one."""
    doing = robot(hw("H", "G"), activity("go", ("H",), ("G",)), events=("low",))
    onward = [*(f"site{i + 1}" for i in range(number - 1)), SUCCEED]
    blocks = [
        Objective(
            name=f"site{i}",
            activities=("go",),
            retries=1,
            success=to,
            failure=(to if i else None) if to != SUCCEED or not back else back,
            handlers=(Handler(event="low", goto=f"site{i + 2}"),) if 0 < i < number - 2 else (),
        )
        for i, to in enumerate(onward)
    ]
    return compose(mission(doing, *blocks))


@pytest.mark.parametrize("back", ["", "site1", "site4"])
def test_some_are_needed_and_others_are_not(back: str) -> None:
    assert {*check_each_set(sites(7, back=back))} == {True, False}


def test_success_may_come_before_what_is_left_out() -> None:
    """It ends as the first fails, before the others are entered."""
    doing = robot(hw("H"), activity("go", ("H",)))
    first = Objective(name="first", activities=("go",), failure=SUCCEED)
    for last in (SUCCEED, "last"):  # success is possible behind it, or not
        then = Objective(name="last", activities=("go",), success=last, failure=last)
        net = compose(mission(doing, first, then))
        check_each_set(net)
        claims = claims_of(check(net, engine="local"))
        without = {c.subject[0] for c in claims if c.kind == "succeeds_without" and c.holds}
        assert without == {"first", "last"}


@pytest.mark.parametrize("pause", [False, True])
def test_what_a_block_waits_for_is_needed_without_a_closure(
    pause: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No exit of the block is in reach then, even if firings took no token; of an optional branch one is."""
    asked, work = list[frozenset[int] | None](), SectionType.reaching.func

    def counted(self: SectionType) -> Any:
        reaching = work(self)

        def noted(goal: Zdd, along: Zdd, allowed: Allowed) -> Zdd:
            asked.append(allowed.local)
            return reaching(goal, along, allowed)

        return noted

    going = [activity(f"go{i}", (f"H{i}",)) for i in range(4)]
    doing = robot(hw("H0", "H1", "H2", "H3"), *going, events=("storm",))
    branches = (*(Objective(name=f"o{i}", activities=(f"go{i}",)) for i in range(3)),)
    extra = Objective(name="extra", activities=("go3",), mandatory=False)
    handlers = (Handler(event="storm", pause="shelter"),) if pause else ()
    block = Parallel(name="all", blocks=(*branches, extra), handlers=handlers, success=SUCCEED)
    net = compose(mission(doing, block, Objective(name="shelter", activities=("go0",))))
    space = composite_space(net)
    without = {n: frozenset(net.net.events.of(Event(What.SUCCESS, n))) for n in ("o0", "o1", "o2", "extra")}
    won = space.marked([net.success])
    monkeypatch.setattr(SectionType, "reaching", property(counted))
    assert space.reaches_without(won, list(without.values())) == [False, False, False, True]
    assert len({local for local in asked if local is not None}) <= 1
    assert check_each_set(net)


def test_claims_on_what_is_left_out_work_on_few_sections_each(monkeypatch: pytest.MonkeyPatch) -> None:
    """A closure of the whole mission for each objective takes time as the square of the sections."""
    counts, work = list[int](), Glued.leaving

    def counted(self: Glued, *given: Any, **named: Any) -> SectionSets:
        counts[-1] += 1
        return work(self, *given, **named)

    monkeypatch.setattr(Glued, "leaving", counted)
    for number in (10, 40):
        counts.append(0)
        claims = claims_of(check(sites(number), engine="local"))
        needed = [c.subject[0] for c in claims if c.kind == "succeeds_without" and not c.holds]
        assert needed[0] == "site0"
    assert counts[1] < 5 * counts[0]
