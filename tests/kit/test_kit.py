"""The kit: the paper's templates keep every property, each seeded fault breaks one, what is told is small."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from typing import ClassVar

import pytest
from hypothesis import given
from hypothesis import strategies as st

from experiments.faults.template_faults import FAULTS, HARMLESS, RIGHT, Faulty, Held
from mcpn.drawing.compose import compose
from mcpn.drawing.templates import Canvas, PaperTemplates, TemplateSet
from mcpn.drawing.templates.compact import CompactTemplates
from mcpn.errors import InputError, LimitError
from mcpn.mission.model import FactRoute, Mission, Objective, walk
from mcpn.mission.robot import Fact, Hardware
from mcpn.mission.xml import read_mission
from mcpn.testing.by_hand import activity, hw, robot
from mcpn.testing.by_hand import mission as written_mission
from mcpn.testing.kit.contract import STATES, contract_of_arcs
from mcpn.testing.kit.corpus import MISSIONS
from mcpn.testing.kit.properties import PROPERTIES, no_dead_transition, refused_for_a_reason
from mcpn.testing.kit.running import (
    SMALL_SHAPES,
    BrokenProperty,
    broken,
    first_broken,
    of_the_corpus,
    small_missions,
    without_leftovers,
)
from mcpn.testing.kit.subject import Subject, Violation
from mcpn.testing.shape import Shape
from tests.draws import fewer
from tests.shares import returns_early

pytest_plugins = ["pytester"]

OURS: tuple[TemplateSet, ...] = (PaperTemplates(), CompactTemplates(at_once=0, combined=0))
"""The sets that mcpn has; of the compact one the form that differs most from the paper's."""


@fewer(0.3)
@given(st.one_of(small_missions()))
def test_our_templates_keep_every_property(mission: Mission) -> None:
    for templates in OURS:
        found = first_broken(mission, templates)
        assert found is None, str(found)


@pytest.mark.parametrize("templates", OURS, ids=["paper", "compact"])
def test_our_templates_keep_every_property_on_ulysse_and_the_corpus(
    ulysse: Mission, templates: TemplateSet
) -> None:
    subject = Subject(ulysse, templates, max_states=60_000)
    for holds in PROPERTIES.values():
        holds(subject)
    found = list(of_the_corpus(templates))
    assert found == [], "\n".join(map(str, found))


def where_it_is(templates: Faulty, monkeypatch: pytest.MonkeyPatch) -> Iterator[BrokenProperty]:
    """What a fault breaks on the missions of the corpus that have it; the others are as without it."""
    for name, mission in MISSIONS.items():
        before = templates.changed
        with suppress(InputError):  # which is told as what is broken
            compose(mission, templates)
        if templates.changed > before:
            monkeypatch.setattr("mcpn.testing.kit.running.MISSIONS", {name: mission})
            yield from of_the_corpus(templates)


@pytest.mark.parametrize("name", FAULTS)
def test_each_fault_is_found(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    templates = Faulty(*FAULTS[name])
    found = next(where_it_is(templates, monkeypatch), None)
    assert found is not None
    assert found.violation.message
    # The run is one of the net with the fault.
    net = Subject(found.mission, templates).net
    for run in found.violation.runs:
        marking = net.initial
        for transition in run:
            assert net.transition_index[transition] in net.enabled(marking)
            marking = net.fire(marking, net.transition_index[transition])


def test_a_refusal_is_asked_for_a_reason_in_whole_missions() -> None:
    """All other properties hold: the activity is refused as one whose alternatives are not possible is."""
    templates = Faulty(*FAULTS["it is refused and its second alternative possible"])
    without = {name: holds for name, holds in PROPERTIES.items() if name != "refused_for_a_reason"}
    assert first_broken(MISSIONS["retried"], templates, without) is None
    found = first_broken(MISSIONS["retried"], templates)
    assert found is not None
    assert found.property == "refused_for_a_reason"
    assert re.search(r"a is refused, and \S+ was possible\nrun:\n  1\. h_EV_OOS\n", str(found))


@given(st.one_of(small_missions()))
def test_who_is_refused_has_a_reason(mission: Mission) -> None:
    """Also of the form of the compact set that passes alternatives over one by one."""
    for templates in OURS:
        try:
            refused_for_a_reason(Subject(mission, templates))
        except LimitError as error:
            returns_early(type(error).__name__)


def test_a_mission_that_facts_lead_round_need_not_end() -> None:
    """The objective cannot succeed, whatever the templates, and while that is so its failure leads to it."""
    alone = replace(activity("a", ()), requires=("lit",))
    dark = replace(robot((), alone), facts=(Fact(name="lit"),))
    again = FactRoute(when=("!lit",), goto="x", on="failure")
    round_and_round = written_mission(dark, Objective(name="x", activities=("a",), routes=(again,)))
    for templates in OURS:
        assert first_broken(round_and_round, templates) is None


@pytest.mark.parametrize("name", HARMLESS)
def test_faults_that_change_nothing_are_let_pass(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    templates = Faulty(*HARMLESS[name])
    assert list(where_it_is(templates, monkeypatch)) == []
    assert templates.changed


def test_a_gate_that_ignores_whether_its_block_runs_has_the_same_markings() -> None:
    """Not only what is seen is the same: no firing is more, wherever the arc is drawn."""
    faulty = Faulty(*HARMLESS["a gate opens in a block that is halted"])
    compared = 0
    for mission in MISSIONS.values():
        before = faulty.changed
        other = Subject(mission, faulty)
        if faulty.changed > before:
            compared += 1
            ours = Subject(mission)
            sizes = [(of.markings.states, of.markings.edges) for of in (ours, other)]
            assert sizes[0] == sizes[1]
    assert compared == 8


def test_a_set_maps_its_places_to_the_states_of_hardware() -> None:
    """Without the map its hardware would seem to be in no state while it is used."""
    mission = MISSIONS["retried"]
    assert first_broken(mission, Held()) is None

    class Unmapped(Held):
        hardware_states: ClassVar = {**STATES}

    found = first_broken(mission, Unmapped())
    assert found is not None
    said = "hardware h is not in one state: available, used, between, out of service"
    assert (found.property, found.violation.message) == ("unit_invariants", said)


def test_what_templates_declare_of_their_places_is_asked() -> None:
    class Declaring(PaperTemplates):
        """It says that hardware is never used while an alternative runs, which is wrong."""

        def hardware(self, canvas: Canvas, resource: Hardware) -> None:
            super().hardware(canvas, resource)
            if resource.name == "h":
                canvas.unit([canvas.resource("h", "busy"), canvas.place_of("activity", "a", "active1")])

    found = first_broken(MISSIONS["retried"], Declaring())
    assert found is not None
    said = "the templates say that one of these is marked at a time: h_busy, a_active1"
    assert (found.property, found.violation.message) == ("unit_invariants", said)


def test_places_of_other_names_are_known_by_what_they_say() -> None:
    """The contract judges a place by its role, where its name says nothing."""

    class Named(PaperTemplates):
        def hardware(self, canvas: Canvas, resource: Hardware) -> None:
            super().hardware(canvas, resource)
            if resource.name == "h":
                pen = canvas.of("hardware", "h", None)
                gone = canvas.role(pen.place("gone_for_now"), ("oos", "h"))
                canvas.of("activity", "a", None).transition(self.name, [gone] * self.takes, [], read=[gone])

        def __init__(self, name: str, *, takes: bool) -> None:
            self.name, self.takes = name, takes

    contract_of_arcs(Subject(MISSIONS["retried"], Named("looks", takes=False)))
    told = r"a_takes, of activity a, takes from h_gone_for_now, which the consumer of hardware h may not"
    with pytest.raises(Violation, match=told):
        contract_of_arcs(Subject(MISSIONS["retried"], Named("takes", takes=True)))


class Forgetful(PaperTemplates):
    """Hardware that is taken and never says so."""

    def hardware(self, canvas: Canvas, resource: Hardware) -> None:
        Faulty(*FAULTS["it forgets its acknowledgement"]).hardware(canvas, resource)


def test_what_is_found_is_small_and_can_be_read_again(tmp_path: Path) -> None:
    found = broken(Forgetful(), profile="ci")
    assert found is not None
    assert found.property == "unit_invariants"
    assert len(list(walk(found.mission.blocks))) == 1
    assert len(found.mission.hardware) == 1
    told = str(found)
    assert "unit_invariants is broken: the interface of hardware h0 does not hold one token" in told
    assert re.search(r"run:\n  1\. MISSION_EV_START\n       \w+_sel1\n       h0_[79]", told)
    (tmp_path / "m.xml").write_text(told[told.index("<mission") :])
    again = first_broken(read_mission(tmp_path / "m.xml"), Forgetful())
    assert again is not None
    assert again.violation.message == found.violation.message


def test_a_fault_that_only_the_corpus_shows_is_told() -> None:
    class Rare(PaperTemplates):
        """Wrong for what is called fuse alone, which no drawn mission has."""

        def hardware(self, canvas: Canvas, resource: Hardware) -> None:
            faulty = "fuse" in canvas.usage.activities
            (Forgetful if faulty else PaperTemplates)().hardware(canvas, resource)

    found = broken(Rare(), profile="dev", properties={"unit_invariants": PROPERTIES["unit_invariants"]})
    assert found is not None
    assert [a.name for a in found.mission.activities] == ["make3", "fuse"]  # that uses hardware, and it


def test_templates_that_do_not_fit_together_are_told() -> None:
    class Unnamed(PaperTemplates):
        """Its hardware is not drawn at all."""

        def hardware(self, canvas: Canvas, resource: Hardware) -> None:
            return

    found = first_broken(MISSIONS["retried"], Unnamed())
    assert found is not None
    assert found.property == "composes"
    assert "names the place" in str(found)


def test_missions_that_are_too_large_are_passed_over() -> None:
    assert first_broken(MISSIONS["four data"], Forgetful(), most=100) is None
    with pytest.raises(LimitError):
        Subject(MISSIONS["four data"], max_states=100).markings  # noqa: B018


def test_an_unknown_profile_is_refused() -> None:
    with pytest.raises(InputError, match="found the profile 'quick', expected one of: dev, ci, nightly"):
        broken(PaperTemplates(), profile="quick")


def test_right_variants_are_accepted() -> None:
    """Also hardware that passes through a place of its own between two states of the contract."""
    for name, made in RIGHT.items():
        if name not in ("paper", "compact, nothing combined"):  # which are asked above
            assert list(of_the_corpus(made())) == [], name
    net = Subject(MISSIONS["retried"], RIGHT["hardware that warms up"]()).net
    assert "h_warming" in net.place_index


def test_a_finding_has_no_leftovers() -> None:
    """Hypothesis leaves what nothing needs; it is taken out, and what is left shows the same."""
    cluttered = replace(
        MISSIONS["interrupted"],
        description="as it was drawn",
        robots=(
            replace(
                MISSIONS["interrupted"].robots[0],
                hardware=hw("h", "unused"),
                facts=(Fact(name="nobody_asks"),),
            ),
        ),
    )
    templates = Faulty(*FAULTS["it forgets its acknowledgement"])
    found = first_broken(cluttered, templates)
    assert found is not None
    small = without_leftovers(found, templates, PROPERTIES)
    assert small.property == found.property
    assert not small.mission.facts
    assert not small.mission.description
    assert [h.name for h in small.mission.hardware] == ["h"]
    assert len(list(walk(small.mission.blocks))) == 1
    assert first_broken(small.mission, templates) is not None


def test_every_element_of_the_language_is_drawn() -> None:
    """Whatever a shape bounds or allows is drawn by some of the kit's, but for what changes no net."""
    plain = Shape()
    drawn = {
        field.name
        for field in fields(Shape)
        if any(getattr(shape, field.name) != getattr(plain, field.name) for shape in SMALL_SHAPES.values())
    }
    never = {"disjoint_branches", "text", "numbers", "awkward_names"}
    as_any = {"depth", "parallel", "protocols", "loops"}  # as by default
    assert {field.name for field in fields(Shape)} - drawn == never | as_any


def test_what_never_fires_is_told_by_what_keeps_it_from_firing() -> None:
    with pytest.raises(Violation, match=r"^never fired: b_go; nor what comes behind: b_stop$"):
        no_dead_transition(Subject(MISSIONS["retried"], _Stuck()))


class _Stuck(PaperTemplates):
    """With a transition that waits for what never comes together, and one behind it."""

    def hardware(self, canvas: Canvas, resource: Hardware) -> None:
        super().hardware(canvas, resource)
        if resource.name == "h":
            pen, part = canvas.of("hardware", "b", None), partial(canvas.place_of, "hardware", "h")
            behind = pen.place("behind")
            pen.transition("go", [], [behind], read=[part("available"), part("OOS")])
            pen.transition("stop", [behind], [])
