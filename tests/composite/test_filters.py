"""What sections may do of a choice of transitions is found once for sections that are copies of one."""

from __future__ import annotations

from collections.abc import Collection, Iterator

import pytest

from experiments.growth.growth import of_natural
from mcpn.composite.composing import composite_space
from mcpn.composite.composite import CompositeSpace
from mcpn.composite.section_type import Allowed
from mcpn.composite.sections import Moved
from mcpn.drawing.compose import compose
from mcpn.events import What
from mcpn.spaces.algebra import Without


@pytest.fixture(scope="module")
def space() -> CompositeSpace:
    return composite_space(compose(of_natural("sites")(6)))


def by_definition(space: CompositeSpace, name: str, transitions: Collection[int]) -> Allowed:
    stage = space.stages[name]
    local = frozenset(i for i in stage.type.carrying if stage.transitions[i] in transitions)
    return Allowed(local, frozenset(t for t in space.layout.toggles if t in transitions))


def choices(space: CompositeSpace) -> dict[str, Collection[int]]:
    events, every = space.net.events, space.carrying
    ending = frozenset(events.carrying(What.SUCCESS))
    one = frozenset(events.of_element(What.SUCCESS, "do2_1"))
    failing = frozenset(events.carrying(What.OUT_OF_SERVICE))
    return {
        "all": every,
        "ends": ending,
        "all but failures of hardware": every - failing,
        "all but one end": every - one,
        "without failures of hardware": Without(every, failing),
        "without one end": Without(every, one),
        "ends without one": Without(ending, one),
        "odd ones": frozenset(t for t in every if t % 2),
    }


def test_each_section_may_do_what_is_chosen_of_its_own(space: CompositeSpace) -> None:
    assert any(isinstance(stage.transitions, Moved) for stage in space.stages.values())
    for said, transitions in choices(space).items():
        allowed = space.filtered(transitions)
        for name in space.stages:
            assert allowed(name) == by_definition(space, name, transitions), (said, name)


def test_copies_that_lie_alike_are_asked_once(monkeypatch: pytest.MonkeyPatch) -> None:
    iterated, plain = list[Moved](), Moved.__iter__

    def noted(row: Moved) -> Iterator[int]:
        iterated.append(row)
        return plain(row)

    monkeypatch.setattr(Moved, "__iter__", noted)
    counts = []
    for sites in (6, 12):
        space = composite_space(compose(of_natural("sites")(sites)))
        failing = frozenset(space.net.events.carrying(What.OUT_OF_SERVICE))
        iterated.clear()
        for transitions in (space.carrying, Without(space.carrying, failing)):
            allowed = space.filtered(transitions)
            assert [allowed(name) for name in space.stages]
        counts.append(len(iterated))
    assert counts[0] == counts[1]


def test_where_a_place_lies_in_a_copy_is_found_by_its_number(space: CompositeSpace) -> None:
    places = range(-1, len(space.net.places))
    for stage in space.sections.values():
        listed = list(stage.places)
        for place in places:
            expected = listed.index(place) if place in listed else None
            assert stage.at(place) == expected
            assert (place in stage.places) == (expected is not None)


def test_choices_of_one_section_alone_are_not_kept(space: CompositeSpace) -> None:
    sets = [frozenset(space.net.events.of_element(What.SUCCESS, f"do{site}_1")) for site in range(6)]
    assert all(0 < len(each) <= len(space.stages) for each in sets)
    kept = len(space._filters._wanted)
    for site, each in enumerate(sets):
        assert len(space.filtered(each)(f"at{site}").local or ()) == 1
    assert len(space._filters._wanted) == kept
    assert len({space.filtered(each)(f"at{site}") for site, each in enumerate(sets)}) == 1
