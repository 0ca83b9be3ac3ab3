"""Drawn facts of the world: who changes them, and what asks for them."""

from __future__ import annotations

from hypothesis import strategies as st

from mcpn.mission.robot import (
    BOOLEAN_VALUES,
    DeclaredEvent,
    Fact,
    FactChange,
)
from mcpn.testing.drawer import MissionDrawer
from mcpn.testing.shape import Shape


class WorldDrawing(MissionDrawer):
    """Draws the facts of a mission; nothing is drawn where there are none."""

    def __init__(self, draw: st.DrawFn, shape: Shape) -> None:
        super().__init__(draw, shape)
        self.facts: tuple[Fact, ...] = ()
        self.done: list[str] = []
        """Elementary objectives that have been drawn."""

    def world(self) -> None:
        """Draws the facts."""
        if self.shape.facts:
            self.facts = tuple(self.fact(f"f{i}") for i in range(self.number(1, self.shape.facts)))

    def fact(self, name: str) -> Fact:
        """A fact that is false or true, or has a few values."""
        values = self.draw(
            st.sampled_from([BOOLEAN_VALUES, BOOLEAN_VALUES, ("low", "high"), ("a", "b", "c")])
        )
        initial = self.draw(st.none() | st.sampled_from(values))
        return Fact(name=name, values=values, initial=initial, description=self.description())

    def changes(self, occasions: tuple[str | None, ...]) -> tuple[FactChange, ...]:
        """Facts that are changed on some occasions, each fact once on each at most."""
        found = []
        for on in occasions:
            for fact in self.facts if on != "start" or not self.shape.becoming else ():
                if self.number(0, 2 if self.shape.becoming else 5) == 0:
                    value = self.draw(st.sampled_from(fact.values))
                    found.append(FactChange(fact=fact.name, to=value, on=on, description=self.description()))
        return tuple(found)

    def changing_events(self) -> tuple[DeclaredEvent, ...]:
        """Declared events that change facts."""
        if not self.facts:
            return ()
        drawn = (self.changes((None,)) for _ in range(self.number(0, 2)))
        return tuple(
            DeclaredEvent(name=f"x{i}", sets=sets, rate=self.value(0, 1e6))
            for i, sets in enumerate(filter(None, drawn))
        )

    def becomes(self) -> tuple[str, ...]:
        """What facts may become for a block to be left."""
        return self.condition(self.facts[:2])

    def condition(self, facts: tuple[Fact, ...] = ()) -> tuple[str, ...]:
        """Words of a condition, of one fact or two, of some or all facts."""
        asked = self.draw(st.lists(st.sampled_from(facts or self.facts), min_size=1, max_size=2, unique=True))
        words = [self.draw(st.sampled_from(_words(fact))) for fact in asked]
        if self.done and self.number(0, 3) == 0:
            sign = "!" if self.chance() else ""
            words.append(f"{sign}done({self.draw(st.sampled_from(self.done))})")
        return tuple(words)


def _words(fact: Fact) -> list[str]:
    """What may be asked of a fact."""
    words = [f"{fact.name}={value}" for value in fact.values]
    return [*words, fact.name, f"!{fact.name}"] if fact.values == BOOLEAN_VALUES else words
