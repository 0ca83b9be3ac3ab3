"""Awkward names for missions: like parts of one another, and alike in different kinds."""

from __future__ import annotations

from hypothesis import strategies as st

from mcpn.mission.model import Mission
from mcpn.mission.renaming import renamed

_AWKWARD = (
    *("a", "a_EV", "a_EV_OK", "a_EV_OOS", "a_EV_b", "a_ok", "a_fail", "a_enter", "a_begin", "a_b", "a_free"),
    *("a_idle", "a_error", "a_wait1", "a_start", "OBJ_a", "OBJ_a_ok", "PAR_a", "PAR_a_exit_0", "MISSION"),
    *("MISSION_success", "EV", "OK", "b", "sel1", "start", "b_sel1", "answer"),
)


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
                left = [new for new in _AWKWARD if new not in known] or [f"a_{len(known)}"]
                given[kind, name] = draw(st.sampled_from(left))
                known.add(given[kind, name])
            return given[kind, name]

        return renamed(mission, rename)

    return drawn()
