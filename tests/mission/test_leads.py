"""Destinations that facts choose, flattened into one list: they choose as nested routes do in every world."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product

from hypothesis import example, given
from hypothesis import strategies as st

from mcpn.mission.fact_cases import Destination, FactCase, by_facts
from mcpn.mission.fact_conditions import Condition

FACTS = {"door": ("open", "shut"), "light": ("on", "off", "dim")}
WORLDS = [dict(zip(FACTS, values, strict=True)) for values in product(*FACTS.values())]

conditions: st.SearchStrategy[Condition] = st.fixed_dictionaries(
    {}, optional={fact: st.sampled_from(values) for fact, values in FACTS.items()}
).map(lambda asked: tuple(asked.items()))
targets = st.sampled_from("abcdef")
leads = st.builds(
    Destination,
    targets,
    st.lists(st.builds(FactCase, conditions.filter(bool), targets), max_size=3).map(tuple),
)


def holds(when: Condition, world: Mapping[str, str]) -> bool:
    return all(world[fact] == value for fact, value in when)


def chosen(lead: Destination, world: Mapping[str, str]) -> str:
    """Where a lead leads in a world: to the target of its first case that holds, else to its default."""
    return next((case.target for case in lead.cases if holds(case.when, world)), lead.target)


OPEN, SHUT, DIM = (("door", "open"),), (("door", "shut"),), (("light", "dim"),)


@given(st.lists(st.tuples(conditions, leads), max_size=4), leads)
@example([(OPEN, Destination("a"))], Destination("b", (FactCase(DIM, "c"),)))  # the default chooses, too
@example([(OPEN, Destination("a", (FactCase(DIM, "b"),)))], Destination("c"))  # so does what a case leads to
@example([(OPEN, Destination("a", (FactCase(SHUT, "b"),)))], Destination("c"))  # by what cannot hold there
def test_one_list_chooses_as_the_lists_in_each_other_do(
    cases: list[tuple[Condition, Destination]], default: Destination
) -> None:
    flat = by_facts(cases, default)
    for world in WORLDS:
        inner = next((lead for when, lead in cases if holds(when, world)), default)
        assert chosen(flat, world) == chosen(inner, world)
    for case in flat.cases:
        assert len(dict(case.when)) == len(case.when), "a condition asks for one value of a fact"
