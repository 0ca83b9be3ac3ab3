"""Two sets of templates side by side: the same, or a shortest run that tells them apart."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import pytest

from experiments.faults.template_faults import FAULTS, HARMLESS, Faulty
from mcpn.answers.spaces_by_engine import MissionSpaces
from mcpn.answers.template_equivalence import Likeness, likeness, likeness_of
from mcpn.answers.verdicts.modes import situation
from mcpn.drawing.compose import compose
from mcpn.drawing.templates import PaperTemplates
from mcpn.drawing.templates.compact import CompactTemplates
from mcpn.errors import SemanticsError
from mcpn.mission.model import Mission
from mcpn.nets.game import TokenGame
from mcpn.testing.kit.corpus import MISSIONS
from mcpn.testing.kit.properties import behaves_as
from mcpn.testing.kit.running import broken, first_broken
from tests.commands import mcpn, output
from tests.conftest import ULYSSE

MOST_COMPARED = 3


@cache
def of_paper(name: str) -> MissionSpaces:
    """A mission of the kit with the paper's templates, which all others are held against."""
    return MissionSpaces(compose(MISSIONS[name], PaperTemplates()), templates=PaperTemplates())


def rounds(*sets: Behaviour) -> int | None:
    """Oracle: after how many events the sets can be told apart, by refining a partition of all states."""
    onward: list[list[int]] = []
    begins, saying = list[int](), list[object]()
    for behaviour in sets:
        begins.append(begin := len(onward))
        for said, events, afters in behaviour:
            saying.append((said, events))
            onward.append([begin + after for after in afters])
    known = {said: number for number, said in enumerate(dict.fromkeys(saying))}
    block = [known[said] for said in saying]
    for passed in range(len(block)):
        if block[begins[0]] != block[begins[1]]:
            return passed
        finer = [(of, *(block[after] for after in afters)) for of, afters in zip(block, onward, strict=True)]
        named = {of: number for number, of in enumerate(dict.fromkeys(finer))}
        if len(named) == len({*block}):
            return None
        block = [named[of] for of in finer]
    raise AssertionError("a partition is refined at most as often as there are states")


Behaviour = list[tuple[str, tuple[str, ...], list[int]]]
"""By state what it is, the events that may happen there, sorted, and where each leads."""


@cache
def behaviour_of_paper(name: str) -> Behaviour:
    return behaviour(of_paper(name))


def behaviour(spaces: MissionSpaces) -> Behaviour:
    graph, found = spaces.listed(), Behaviour()
    for state in range(graph.states):
        said = situation(spaces.mission, graph.marking(state))
        onward = sorted(
            {(str(graph.net.transitions[t].event), after) for t, after in graph.successors(state)}
        )
        words = str(sorted(map(str, vars(said).items())))
        found.append((words, tuple(event for event, _ in onward), [after for _, after in onward]))
    return found


@pytest.mark.parametrize("name", [*FAULTS, *HARMLESS])
def test_faults_are_told_apart_by_a_shortest_run(name: str) -> None:
    """In the first missions of the corpus that have the fault; what changes nothing, in all."""
    compared = 0
    for told, mission in MISSIONS.items():
        if compared == MOST_COMPARED and name in FAULTS:
            return
        templates = Faulty(*{**FAULTS, **HARMLESS}[name])
        faulty = MissionSpaces(compose(mission, templates), templates=templates)
        if faulty.net == of_paper(told).net:
            continue  # nothing in this mission has the fault
        compared += 1
        try:
            found = likeness_of(*(spaces.bound(max_states=20_000) for spaces in (of_paper(told), faulty)))
        except SemanticsError:  # an event has several outcomes: that is how these are known to be wrong
            assert name in FAULTS
            continue
        if found.sizes[1].reason:
            assert found.difference is not None  # the paper's templates always have a graph here
            assert found.sizes[1].reason in found.difference.message
            return  # it goes on without end: in the next mission, too, which takes seconds each
        expected = rounds(behaviour_of_paper(told), behaviour(faulty))
        assert expected == (None if found.difference is None else len(found.difference.events))
        replayed(found, of_paper(told), faulty)
        assert name in FAULTS or expected is None


def replayed(found: Likeness, *sets: MissionSpaces) -> None:
    """What is told to fire inside the nets after each event fires there."""
    if found.difference is None:
        return
    for spaces, firings in zip(sets, found.difference.firings, strict=True):
        net = spaces.net
        game = TokenGame(net)
        assert len(firings) == len(found.difference.events)
        for event, names in zip(found.difference.events, firings, strict=True):
            (taken,) = (t for t in game.enabled if net.transitions[t].event == event)
            game.fire(taken)
            for name in names:
                game.fire(net.transition_index[name])
            assert not any(net.transitions[t].internal for t in game.enabled)


def test_a_difference_is_told_with_both_nets(ulysse: Mission) -> None:
    found = mcpn("compare", ULYSSE, "--templates", "paper", f"{__name__}:Other")
    assert found.returncode == 1
    assert re.search(r"They differ: \w+: .+ with paper, .+ with tests", found.stdout)
    assert "  1. MISSION_EV_START: mission ulysse starts\n       paper" in found.stdout
    told = output("compare", ULYSSE, "--templates", "paper", f"{__name__}:Other", code=1)
    assert (told["same"], told["isomorphic"]) == (False, False)
    assert told["sets"][0] == {
        "templates": "paper",
        "places": 133,
        "transitions": 150,
        "states": 260,
        "edges": 1332,
        "reason": "",
    }
    assert told["difference"]["events"][0] == "MISSION_EV_START"
    assert len(told["difference"]["firings"]) == 2


class Other(Faulty):
    """Templates with a fault of activities."""

    def __init__(self) -> None:
        super().__init__(*FAULTS["it selects and does not ask"])


def test_sets_that_are_the_same_are_told_so() -> None:
    found = mcpn("compare", ULYSSE, "--templates", "paper", "compact")
    assert (found.returncode, found.stderr) == (0, "")
    assert "The same happens with both: the alternatives graphs are isomorphic." in found.stdout
    told = output("compare", ULYSSE, "--templates", "compact", "paper")
    assert (told["same"], told["isomorphic"], told["difference"]) == (True, True, None)


def test_what_cannot_be_compared_is_refused(tmp_path: Path) -> None:
    assert mcpn("compare", ULYSSE, "--templates", "paper", "nothing").returncode == 2
    assert (
        mcpn("compare", ULYSSE, "--templates", "paper", "paper", "--plot", tmp_path / "p.svg").returncode == 2
    )
    assert mcpn("convert", ULYSSE, tmp_path / "net.pnml").returncode == 0
    found = mcpn("compare", tmp_path / "net.pnml", "--templates", "paper", "compact")
    assert found.returncode == 2
    assert "found a net, expected a mission" in found.stderr
    limit = mcpn("compare", ULYSSE, "--templates", "paper", "compact", "--max-states", 10)
    assert limit.returncode == 2
    assert "10" in limit.stderr


def test_neither_has_a_graph() -> None:
    """Two activities want one resource at the same moment: the same with both sets."""
    from tests.test_matrix import mission

    drawn = mission(contention=True).mission
    found = likeness(drawn, None, CompactTemplates())
    assert found.difference is None
    assert [sizes.states for sizes in found.sizes] == [None, None]
    assert all(sizes.reason for sizes in found.sizes)
    assert not found.isomorphic


def test_an_event_of_several_transitions_is_no_function() -> None:
    class Twice(PaperTemplates):
        """Hardware that may also come back broken."""

        def hardware(self, canvas, resource):  # type: ignore[no-untyped-def]
            draw = canvas.transition

            def twice(name, *, event=None, **arcs):  # type: ignore[no-untyped-def]
                draw(name, event=event, **arcs)
                if name == f"{resource.name}_EV_RD":
                    oos = {**arcs, "consume": arcs["consume"], "produce": arcs["consume"]}
                    draw(f"{name}_in_vain", event=event, **oos)

            canvas.transition = twice
            super().hardware(canvas, resource)
            del canvas.transition

    mission = MISSIONS["driver"]
    spaces = [MissionSpaces(compose(mission, s), templates=s) for s in (PaperTemplates(), Twice())]
    with pytest.raises(SemanticsError, match="h_EV_RD fires several transitions"):
        likeness_of(*spaces)


def test_drawn_missions_are_compared() -> None:
    """The kit finds and shrinks a mission on which two sets differ."""
    like = {"behaves_as": behaves_as(PaperTemplates(), name="paper")}
    assert broken(CompactTemplates(at_once=0, combined=0), profile="dev", properties=like) is None
    found = broken(Other(), profile="ci", properties=like)
    assert found is not None
    assert found.property == "behaves_as"
    told = str(found)
    assert "They differ: " in told
    assert "       these" in told
    assert "paper" in told
    assert told.index("<mission") > told.index("They differ")
    again = first_broken(found.mission, Other(), like)
    assert again is not None
    assert again.violation.message == found.violation.message
