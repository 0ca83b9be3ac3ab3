"""The compact templates: the same alternatives graph as the paper's, state by state, and linear sizes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest
from hypothesis import event, given

from mcpn.answers.spaces_by_engine import MissionSpaces
from mcpn.answers.template_equivalence import Likeness, likeness
from mcpn.drawing.compose import compose
from mcpn.drawing.templates import PaperTemplates
from mcpn.drawing.templates.activities import MAX_TOGETHER
from mcpn.drawing.templates.compact import CompactTemplates
from mcpn.errors import LimitError
from mcpn.mission.model import Mission, Objective, Parallel, Recursive
from mcpn.mission.robot import Activity, Alternative, DeclaredEvent, Fact, FactChange
from mcpn.mission.xml import read_mission
from mcpn.nets.game import TokenGame
from mcpn.testing import Shape, missions
from mcpn.testing.data import data_sharing_missions
from mcpn.testing.kit.corpus import MISSIONS
from tests.conftest import ULYSSE
from tests.drawing.test_handling import fusing_missions
from tests.draws import MOST_TRANSITIONS, fewer
from tests.shares import returns_early
from tests.small import activity, hw, mission, robot

EVERYWHERE = CompactTemplates(at_once=0, combined=0)
"""Those that combine nothing, however small."""


def the_same(drawn: Mission, *sets: CompactTemplates) -> None:
    """Each set gives the alternatives graph of the paper's templates; where there is none, neither does."""
    paper = compose(drawn)
    if len(paper.net.transitions) > MOST_TRANSITIONS:
        returns_early("a large net")
        return
    for templates in sets:
        try:
            found = likeness(drawn, None, templates, max_states=3000)
        except LimitError:
            returns_early("too many states")
            return
        event(f"alternatives graph: {found.sizes[0].states is not None}")
        event(f"drawn otherwise: {found.sizes[0].places != found.sizes[1].places}")
        as_expected(found)


def as_expected(found: Likeness) -> None:
    assert found.difference is None, found.difference
    assert found.isomorphic == (found.sizes[0].states is not None)
    assert found.sizes[0].states == found.sizes[1].states
    assert found.sizes[0].edges == found.sizes[1].edges


@fewer(1.0)
@given(missions())
def test_any_mission_behaves_the_same(drawn: Mission) -> None:
    the_same(drawn, EVERYWHERE, CompactTemplates())


@fewer(1.0)
@given(
    missions(Shape(own_hardware=True, shared_activities=False, hardware=4), events=2)
    | data_sharing_missions()
    | missions(Shape(disjoint_branches=True, alternatives=4, hardware=4), events=1)
)
def test_missions_without_contention_behave_the_same(drawn: Mission) -> None:
    the_same(drawn, EVERYWHERE)


@fewer(0.75)
@given(missions(Shape(facts=2, sections=6, early=3, timeouts=2, lasting=True), events=1))
def test_missions_with_facts_behave_the_same(drawn: Mission) -> None:
    the_same(drawn, EVERYWHERE, CompactTemplates())


@fewer(0.5)
@given(fusing_missions())
def test_many_data_behave_the_same(drawn: Mission) -> None:
    the_same(drawn, EVERYWHERE, CompactTemplates())


@fewer(0.5, least=8)
@given(missions(Shape(own_hardware=True, shared_activities=False, hardware=4), events=1))
def test_sections_compose_the_same(drawn: Mission) -> None:
    """Types of sections and junctions are those of the paper's templates, and so is what comes of them."""
    counted = []
    for templates in (None, EVERYWHERE):
        net = compose(drawn, templates)
        if len(net.net.transitions) > MOST_TRANSITIONS:
            returns_early("a large net")
            return
        space = MissionSpaces(net, templates=templates).composite()
        counted.append((space.everything.count(), sum(space.firings(space.everything).values())))
    assert counted[0] == counted[1]


@pytest.mark.parametrize("name", MISSIONS)
@pytest.mark.parametrize("templates", [EVERYWHERE, CompactTemplates()], ids=["everywhere", "default"])
def test_the_corpus_behaves_the_same(name: str, templates: CompactTemplates) -> None:
    as_expected(likeness(MISSIONS[name], PaperTemplates(), templates))


def test_ulysse_behaves_the_same() -> None:
    """The sizes are those of docs/templates.md; the paper's are those of Table 1 as we have them."""
    ulysse = read_mission(ULYSSE)
    for templates, places in ((CompactTemplates(), 133), (EVERYWHERE, 157)):
        found = likeness(ulysse, None, templates)
        as_expected(found)
        assert (found.sizes[0].states, found.sizes[0].edges) == (260, 1332)
        assert found.sizes[1].places == places


def returning(number: int, *, switch_back: bool = True) -> Mission:
    """An activity that returns, with many alternatives; the last consumes all that the others do."""
    names = tuple(f"h{i}" for i in range(number))
    ways = [(h,) for h in names] + [()]
    going = replace(activity("go", *ways), switch_back=switch_back)
    return mission(robot(hw(*names), going), Objective(name="x", activities=("go",)))


def waiting(number: int) -> Mission:
    """An activity whose alternative consumes much, some of it of a producer that may wait."""
    names = tuple(f"H{i}" for i in range(number - 1))
    activities = (activity("d", ("h",), produces=("s",)), activity("a", ("s", *names)), activity("b", ("h",)))
    branches = tuple(Objective(name=f"o{a}", activities=(a,)) for a in "ab")
    return mission(robot(hw("h", *names), *activities), Parallel(name="both", blocks=branches))


def branching(number: int) -> Mission:
    """A parallel block of some children."""
    names = [f"a{i}" for i in range(number)]
    branches = tuple(Objective(name=f"o{a}", activities=(a,)) for a in names)
    return mission(robot((), *(activity(a, ()) for a in names)), Parallel(name="all", blocks=branches))


@pytest.mark.parametrize(("grown", "few", "many"), [(returning, 4, 24), (waiting, 4, 24), (branching, 4, 24)])
def test_nets_grow_as_missions_do(grown: Callable[[int], Mission], few: int, many: int) -> None:
    """Equal steps of the mission are equal steps of the net, in places and in transitions."""
    nets = [compose(grown(n), CompactTemplates()).net for n in (few, (few + many) // 2, many)]
    for what in ("places", "transitions"):
        sizes = [len(getattr(net, what)) for net in nets]
        assert sizes[2] - sizes[1] == sizes[1] - sizes[0] > 0, what


@pytest.mark.parametrize("drawn", [returning(4), returning(3, switch_back=False), waiting(4), branching(5)])
def test_small_ones_behave_the_same(drawn: Mission) -> None:
    as_expected(likeness(drawn, None, CompactTemplates()))


def test_what_is_too_wide_for_the_paper_is_drawn() -> None:
    drawn = waiting(MAX_TOGETHER + 1)
    with pytest.raises(LimitError, match="13 resources consumed"):
        compose(drawn)
    assert len(compose(drawn, CompactTemplates()).net.transitions) < 300


def test_a_fact_that_changes_while_it_waits_is_heard() -> None:
    """An alternative asks a producer that waits for what another branch holds; then its fact changes."""
    door = Fact(name="door", values=("open", "closed"))
    closes = DeclaredEvent(name="close", sets=(FactChange(fact="door", to="closed"),))
    through = Alternative(name="through", consumes=("s", "g"), requires=("door=open",))
    going = Activity(name="go", alternatives=(through, Alternative(name="around", consumes=("g",))))
    activities = (
        activity("make", ("h",), produces=("s",)),
        activity("hold", ("h",)),
        activity("rest", ()),
        going,
    )
    of = replace(robot(hw("h", "g"), *activities), facts=(door,), events=(closes,))
    later = Recursive(
        name="y", blocks=(Objective(name="z", activities=("rest",)), Objective(name="w", activities=("go",)))
    )
    drawn = mission(of, Parallel(name="both", blocks=(Objective(name="x", activities=("hold",)), later)))
    for templates in (EVERYWHERE, CompactTemplates()):
        as_expected(likeness(drawn, None, templates))
    net = compose(drawn, EVERYWHERE).net
    game = TokenGame(net)
    fired = list[str]()
    for event_ in ("MISSION_EV_START", "OBJ_z_EV_OK", "close"):
        (taken,) = (t for t in game.enabled if str(net.transitions[t].event) == event_)
        game.fire(taken)
        fired = [net.transitions[t].name for t in game.settle()]
    assert any("go_asklost1" in name for name in fired), fired
    assert net.place_index["go_active2"] in [p for p, n in enumerate(game.marking) if n]
