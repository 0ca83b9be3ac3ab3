"""What is asked of copies of one section with the same states is found once, and is what each would say."""

from __future__ import annotations

from collections import Counter
from typing import Any

import pytest

from experiments.growth.growth import of_natural
from mcpn.composite.composing import composite_space
from mcpn.composite.composite import CompositeSpace
from mcpn.composite.sections import Stage
from mcpn.drawing.compose import compose
from mcpn.spaces.projections import ImageStore


def space_of(sites: int) -> CompositeSpace:
    return composite_space(compose(of_natural("sites")(sites)))


def asked(space: CompositeSpace) -> tuple[object, ...]:
    """What hardware is out of service, asked in four ways."""
    places = [p for p, (said, _) in sorted(space.mission_net.roles.items()) if said == "oos"]
    everything = space.everything
    return (
        space.marked(places[:2]),
        space.restricted(everything, places[:1], places[1:]),
        space.at_most(dict.fromkeys(places, 1), 2),
        space.image(everything, places, ImageStore(len(places))).count(),
    )


def test_each_section_says_what_it_would_say_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    space = space_of(5)
    together = asked(space)

    def each_alone(space: CompositeSpace, parts: Any, places: Any, of: Any) -> Any:
        return ((name, of(space.stages[name], part)) for name, part in parts.items())

    monkeypatch.setattr(CompositeSpace, "_alike", each_alone)
    assert together == asked(space)


def test_copies_with_the_same_states_are_asked_once(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = Counter[str]()
    for name in ("bit", "restricted", "at_most"):
        plain = getattr(Stage, name)

        def noted(stage: Stage, *given: Any, name: str = name, of: Any = plain) -> Any:
            calls[name] += 1
            return of(stage, *given)

        monkeypatch.setattr(Stage, name, noted)
    counts = []
    for sites in (8, 16):
        space = space_of(sites)
        assert space.everything
        calls.clear()
        asked(space)
        counts.append(dict(calls))
    assert counts[0] == counts[1] != {}
