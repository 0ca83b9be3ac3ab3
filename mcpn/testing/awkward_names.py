"""Awkward names for missions, like parts of one another and alike in different kinds; and renaming."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from hypothesis import strategies as st

from mcpn.mission.fact_conditions import objective_done, word
from mcpn.mission.language.forms import form_of
from mcpn.mission.model import ABORT, FAIL, SUCCEED, Mission, Protocol
from mcpn.mission.robot import Alternative, Element


def renamed(mission: Mission, rename: Callable[[str, str], str]) -> Mission:
    """The mission with other names, without its requirements, whose formulas say the names that it had.

    Args:
        mission: A valid mission.
        rename: From a kind (``resource``, ``activity``, ``alternative``, ``block``, ``protocol``, ``event``,
            ``fact``, ``reason``) and a name to the new name, which must be unique in its kind. An alternative
            that has the name of its activity gets the activity's new name.
    """

    def reworded(text: str) -> str:
        said = word(text)
        objective = objective_done(said.fact)
        name = rename("fact", said.fact) if objective is None else f"done({rename('block', objective)})"
        return f"{'!' * said.negated}{name}{'' if said.value is None else f'={said.value}'}"

    def other(kind: str, value: Any) -> Any:
        if kind == "condition":
            return tuple(map(reworded, value))
        if kind == "reason" and isinstance(value, tuple):
            words = (text.partition("=") for text in value)
            return tuple("".join((rename(kind, name), *share)) for name, *share in words)
        if isinstance(value, tuple):
            return tuple(rename(kind, name) for name in value)
        exits = (None, SUCCEED, FAIL, ABORT) if kind == "block" else (None,)
        return value if value in exits else rename(kind, value)

    def changed(element: Any, around: Any) -> Any:
        form = form_of(type(element))
        made = {
            a.name: other(a.datatype.refers, getattr(element, a.name))
            for a in form.attributes
            if a.datatype.refers
        }
        if isinstance(element, Element) and element.NAMED:
            as_around = isinstance(element, Alternative) and element.name == around.name
            made["name"] = rename(around.NAMED if as_around else element.NAMED, element.name)
        if isinstance(element, Mission | Protocol):
            element = replace(element, requirements=())
        for content in form.contents:
            made[content.name] = tuple(changed(member, element) for member in getattr(element, content.name))
        return replace(element, **made)

    whole: Mission = changed(mission, None)
    return whole


_AWKWARD = (
    *("a", "a_EV", "a_EV_OK", "a_EV_OOS", "a_EV_b", "a_ok", "a_fail", "a_enter", "a_begin", "a_b", "a_free"),
    *("a_idle", "a_error", "a_wait1", "a_start", "OBJ_a", "OBJ_a_ok", "PAR_a", "PAR_a_exit_0", "MISSION"),
    *("MISSION_success", "EV", "OK", "b", "sel1", "start", "b_sel1", "answer"),
)
_AWKWARD_REASONS = ("OK", "FAIL", "a", "OOS", "a_b", "b", "OBJ_a", "a_OK")


def awkwardly_named(mission: Mission) -> st.SearchStrategy[Mission]:
    """The mission with other names: like parts of one another, and alike in different kinds.

    Args:
        mission: A valid mission.

    Returns:
        Missions that say the same.
    """

    @st.composite
    def drawn(draw: st.DrawFn) -> Mission:
        given: dict[tuple[str, str], str] = {}
        taken: dict[str, set[str]] = {}

        def rename(kind: str, name: str) -> str:
            if (kind, name) not in given:
                known = taken.setdefault(kind, set())
                some = _AWKWARD_REASONS if kind == "reason" else _AWKWARD
                left = [new for new in some if new not in known] or [f"a_{len(known)}"]
                given[kind, name] = draw(st.sampled_from(left))
                known.add(given[kind, name])
            return given[kind, name]

        return renamed(mission, rename)

    return drawn()
