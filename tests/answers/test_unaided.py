"""What defeats a mission that no event and no timeout helps is what formulas say of it."""

from __future__ import annotations

from hypothesis import event, given
from hypothesis import strategies as st

from mcpn.errors import ConfluenceError, LimitError, UnsafeError
from mcpn.events import HELPING
from mcpn.mission.model import Mission
from mcpn.spaces.engine_names import Engine
from mcpn.spaces.stable.alternatives import direct
from mcpn.study import Study
from mcpn.testing import missions
from tests.draws import fewer
from tests.logic.asked import ENGINES
from tests.logic.oracle import coming_home
from tests.shares import returns_early


def without(events: list[str]) -> str:
    return " & ".join(f"!happens({event})" for event in events) or "true"


@fewer(0.1)
@given(
    missions(max_hardware=2, max_objectives=2, max_sections=4, events=2, timeouts=2)
    | missions(max_hardware=2, max_objectives=2, max_sections=3, events=2, facts=1)
    | coming_home(),
    st.sampled_from(ENGINES),
)
def test_single_losses_of_drawn_missions(mission: Mission, engine: Engine) -> None:
    study = Study(mission)
    try:
        direct(study.mission_net.net, max_states=2_000)
        causes = study.causes(engine=engine)
    except (LimitError, ConfluenceError, UnsafeError) as error:
        returns_early(type(error).__name__)
        return
    found = causes.mission.unaided
    assert found is not None
    events = {str(t.event): t.event for t in study.mission_net.net.transitions if t.event is not None}
    quiet = [name for name, of in events.items() if of.what in HELPING]
    for hardware in causes.prospects.hardware:
        unrepaired = quiet + [f"{hardware}_EV_RD"] * (f"{hardware}_EV_RD" in events)
        later = f"E(({without(unrepaired)}) U success)"
        survives = f"E(({without(quiet)}) U (event(MISSION_EV_START) & oos({hardware}) & {later}))"
        defeats = any(set(lost) <= {hardware} for lost in found.cut_sets)
        asked = Study(mission)
        reached = asked.ctl(f"E(({without(quiet)}) U (event(MISSION_EV_START) & oos({hardware})))").holds
        assert asked.ctl(survives).holds is (reached and not defeats), survives
        event(f"defeats: {defeats}, helped: {bool(found.helpers)}")
