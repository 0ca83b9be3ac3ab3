"""The kit: the paper's templates keep every property, each seeded fault breaks one, what is told is small."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st

from experiments.faults.template_faults import FAULTS, HARMLESS, RIGHT, Faulty, Held
from mcpn.drawing.compose import compose
from mcpn.drawing.templates import Canvas, PaperTemplates, TemplateSet
from mcpn.drawing.templates.canvas import RoleName
from mcpn.drawing.templates.compact import CompactTemplates
from mcpn.drawing.templates.interface import HAPPENING, MEETINGS, SAYING
from mcpn.drawing.templates.named import templates_named
from mcpn.errors import InputError, LimitError
from mcpn.events import Event, What
from mcpn.mission.language.forms import form_of, language
from mcpn.mission.model import Approximation, FactRoute, Mission, Objective, Translated, walk
from mcpn.mission.requirement import Requirement
from mcpn.mission.robot import Activity, Described, Fact, Hardware
from mcpn.mission.xml import read_mission
from mcpn.testing.by_hand import activity, hw, robot
from mcpn.testing.by_hand import mission as written_mission
from mcpn.testing.elements import LATE, LATE_APART
from mcpn.testing.elements import MISSIONS as MISSIONS_OF_ANY_KIND
from mcpn.testing.kit.contract import STATES, WORDS, contract_of_arcs, drawer, touches
from mcpn.testing.kit.corpus import MISSIONS
from mcpn.testing.kit.properties import PROPERTIES, no_dead_transition, refused_for_a_reason
from mcpn.testing.kit.running import (
    ALL,
    SMALL_SHAPES,
    BrokenProperty,
    broken,
    first_broken,
    of_the_corpus,
    small_missions,
    without_leftovers,
)
from mcpn.testing.kit.subject import Subject, Violation
from mcpn.testing.kit.units import MACHINES, driven
from mcpn.testing.shape import Shape
from tests.conftest import ROOT, ULYSSE
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


# --- the contract ----------------------------------------------------------------------------------------


@fewer(0.3)
@given(st.one_of(MISSIONS_OF_ANY_KIND, LATE, LATE_APART))
def test_the_contract_accepts_our_templates_whatever_a_mission_says(mission: Mission) -> None:
    """Every element of the language, contended or not: what touches what follows from the templates alone."""
    for templates in OURS:
        try:
            contract_of_arcs(Subject(mission, templates))
        except LimitError as error:
            returns_early(type(error).__name__)


Row = tuple[str, str, str, str]
"""Kind, part, side, letter."""


def rows_touched(missions: Iterable[Mission]) -> set[Row]:
    """What the paper's templates do, of what is declared of their places."""
    found = set()
    for mission in missions:
        for touch in touches(Subject(mission)):
            if touch.row is not None:
                found.add((*touch.row, touch.side, touch.letter))
    return found


def test_no_more_is_declared_than_the_templates_do() -> None:
    allowed = {
        (kind, part, side, letter)
        for kind, parts in MEETINGS.items()
        for part, meeting in parts.items()
        for side, letters in meeting.allowed.items()
        for letter in letters
    }
    assert allowed - rows_touched((*MISSIONS.values(), read_mission(ULYSSE))) == RARE


@pytest.mark.parametrize("kind", MEETINGS)
def test_an_element_that_declares_no_places_is_told(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """So a new element cannot be forgotten: none may touch its places until they are declared."""
    monkeypatch.delitem(MEETINGS, kind)
    told = []
    for mission in MISSIONS.values():
        try:
            contract_of_arcs(Subject(mission))
        except Violation as violation:
            told.append(violation.message)
    assert told
    assert all(re.search(rf"which the .* of {kind} \S+ may not$", message) for message in told)


def test_what_places_say_is_declared_or_private() -> None:
    """By role, so that a new one is thought of: who may touch a place that says so?"""
    private = {
        *("wait", "want", "known", "ready", "presumed"),  # of who draws it; others learn of it otherwise
        *(
            "objective",
            "pending",
            "done",
            "success",
            "failure",
            "abort",
            "exit",
            "open",
            "happened",
        ),  # control
        *("alive", "dead"),  # never drawn by templates: made of the net of a mission later
        "fine",  # has the name that is declared
    }
    assert {*get_args(RoleName)} == {*SAYING} | private
    assert not {*SAYING} & private
    assert all(part in MEETINGS[kind] for kind, part in SAYING.values())


def test_every_event_is_of_some_kind_of_element() -> None:
    """By what it says; no set draws losses for good and what was before a part, and a set may name others."""
    assert {*What} - {*HAPPENING} == {What.LOST, What.EARLIER}
    drawn = {
        (transition.event.what, drawer(transition.provenance)[0])
        for mission in MISSIONS.values()
        for transition in Subject(mission).net.transitions
        if transition.event is not None and transition.provenance is not None
    }
    assert all(kind in HAPPENING[what] for what, kind in drawn)
    assert {*HAPPENING} == {what for what, _ in drawn}


def test_events_of_other_elements_break_the_contract() -> None:
    class Meddling(PaperTemplates):
        """An activity during which hardware may fail, without the hardware's template."""

        def activity(self, canvas: Canvas, activity: Activity) -> None:
            super().activity(canvas, activity)
            running = canvas.place_of("activity", activity.name, "active1")
            fails = Event(What.OUT_OF_SERVICE, "h")
            canvas.of("activity", activity.name, None).transition("worn", [running], [running], event=fails)

    told = "a_worn, of activity a, fires with h_EV_OOS, an event of another element"
    with pytest.raises(Violation, match=told):
        contract_of_arcs(Subject(MISSIONS["retried"], Meddling()))


class Noticing(PaperTemplates):
    """An activity that looks at a place of its hardware that this set alone has."""

    def hardware(self, canvas: Canvas, resource: Hardware) -> None:
        super().hardware(canvas, resource)
        pen = canvas.of("hardware", resource.name, resource.source)
        self.declared(canvas, canvas.place(f"hours of {resource.name}", provenance=pen.provenance))

    def declared(self, canvas: Canvas, place: str) -> None:
        """It is not declared that others look at it."""

    def activity(self, canvas: Canvas, activity: Activity) -> None:
        super().activity(canvas, activity)
        read = [f"hours of {name}" for way in activity.alternatives for name in way.consumes]
        canvas.of("activity", activity.name, None).transition("look", [], [], read=read)


def test_a_set_declares_places_of_its_own_at_which_templates_meet() -> None:
    told = "a_look, of activity a, reads hours of h, which the other side of hardware h may not"
    with pytest.raises(Violation, match=told):
        contract_of_arcs(Subject(MISSIONS["retried"], Noticing()))

    class Declaring(Noticing):
        letters = "r"

        def declared(self, canvas: Canvas, place: str) -> None:
            canvas.meet(place, "it has run for long", consumer=self.letters)

    contract_of_arcs(Subject(MISSIONS["retried"], Declaring()))

    class Other(Declaring):
        letters = "t"

    told = "a_look, of activity a, reads hours of h, which the consumer of hardware h may not"
    with pytest.raises(Violation, match=told):
        contract_of_arcs(Subject(MISSIONS["retried"], Other()))


NOT_DRAWN: Mapping[str, set[str]] = {
    "it is text": {"Described.description", "Described.source", "Parameter.value", "Parameter.unit"}
    | {f"{of}.parameters" for of in ("Activity", "Alternative", "Objective", "Protocol", "Recursive", "Use")},
    "it is a number": {
        f"{of}.{number}"
        for of, numbers in {
            **dict.fromkeys(
                ("Hardware", "Fault", "Activity", "Alternative"), ("failure_rate", "repair_rate")
            ),
            "Objective": ("duration", "failure_probability"),
            "DeclaredEvent": ("rate",),
        }.items()
        for number in numbers
    }
    | {"Activity.detection_rate", "Hardware.demand_probability"},
    "it is asked of the net": {"BlockElement.nominal", "DeclaredEvent.required", "Mission.requirements"}
    | {"Protocol.requirements"},
    "it is of files": {"Import.href", "Protocols.name", "Protocols.protocols", "Mission.translated"},
}
"""What the language has and no net shows, by the reason."""


def test_every_element_of_the_language_is_in_the_corpus() -> None:
    """With each attribute that a net may show, not at its default: so a new one is thought of."""
    missed = {
        f"{field.owner.__name__}.{field.name}"
        for tag in language().values()
        for form in tag.forms
        if not issubclass(form, (Requirement, Translated, Approximation)) and form.__module__ in DRAWN
        for field in form_of(form).fields
        if field not in form_of(form).core
    }
    for mission in MISSIONS.values():
        missed -= {*said(mission)}
    assert missed == set().union(*NOT_DRAWN.values())


DRAWN = ("mcpn.mission.model", "mcpn.mission.robot")
"""Modules that declare elements; patterns of requirements have one of their own."""


def said(element: Described) -> Iterator[str]:
    """The attributes and contents of an element that are not the default, and of those inside."""
    for field in form_of(type(element)).fields:
        value = getattr(element, field.name)
        if value not in (field.default, None, ()):
            yield f"{field.owner.__name__}.{field.name}"
        for inner in value if isinstance(value, tuple) else ():
            if isinstance(inner, Described):
                yield from said(inner)


RARE = {
    # A request is given up of a producer that waits; those of the corpus that do so serve.
    ("software", "free", "consumer", "p"),
    # Errors of hardware are noted one by one beside more than three data.
    ("hardware", "answer", "consumer", "p"),
    ("hardware", "error", "consumer", "r"),
    # An activity returns for hardware that only its supplier uses.
    ("hardware", "service", "watcher", "r"),
    # An event that changes several facts does so by transitions of one of them, and reads what is so already.
    ("fact", "value", "owner", "r"),
    *(("fact", "value", "event", letter) for letter in "tpr"),
}


def test_who_touches_what_is_private_breaks_the_contract() -> None:
    class Meddling(PaperTemplates):
        """An activity that looks into the hardware that it uses."""

        def hardware(self, canvas: Canvas, resource: Hardware) -> None:
            super().hardware(canvas, resource)
            pen = canvas.of("activity", "a", None)
            pen.transition(("peek", resource.name), [], [], read=[canvas.resource(resource.name, "busy")])

    with pytest.raises(
        Violation, match=r"a_peek_h, of activity a, reads h_busy, which the other side of hardware h may not"
    ):
        contract_of_arcs(Subject(MISSIONS["retried"], Meddling()))
    assert WORDS.keys() == {"t", "p", "r"}


# --- by name, and in pytest ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("nothing", "found the templates 'nothing', expected paper, compact or MODULE:NAME"),
        ("mcpn.no_such:X", "cannot be loaded: ModuleNotFoundError"),
        ("mcpn.nets.petri:NoSuch", "cannot be loaded: AttributeError"),
        ("mcpn.nets.petri:PetriNet", "cannot be loaded: TypeError"),
        (
            "mcpn.nets.petri:EVENTS",
            "found no hardware, software, activity, control; expected a set",
        ),
    ],
)
def test_templates_that_are_none_are_refused(name: str, told: str) -> None:
    with pytest.raises(InputError, match=re.escape(told)):
        templates_named(name)


def test_templates_go_by_their_names() -> None:
    assert isinstance(templates_named("paper"), PaperTemplates)
    assert isinstance(templates_named("compact"), CompactTemplates)
    assert isinstance(templates_named(f"{__name__}:Forgetful"), Forgetful)


def test_the_plugin_runs_the_kit(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    pytester.makepyfile(forgetting="from tests.kit.test_kit import Forgetful as Mine\n")
    options = ["-p", "mcpn.pytest_plugin", "-p", "no:cacheprovider", "--mcpn-profile", "dev", "-k", "unit"]
    asked = ["--mcpn-templates", "forgetting:Mine", "--mcpn-templates", "paper"]
    result = pytester.runpytest_inprocess(*options, *asked)
    result.assert_outcomes(passed=1, failed=1, deselected=2 * (len(ALL) - 1 + len(MACHINES)))
    result.stdout.fnmatch_lines(["*hardware h0 does not hold one token*", "*<mission *", "*</mission>*"])
    result.stdout.no_fnmatch_line("*Traceback*")


def test_the_plugin_runs_beside_that_of_pytest_lsp(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its wrapper around the call ends before its ``yield`` where an item has no arguments."""
    pytest.importorskip("pytest_lsp", reason="needs pytest-lsp")
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    plugins = ["-p", "pytest_asyncio.plugin", "-p", "pytest_lsp", "-p", "mcpn.pytest_plugin"]
    asked = ["--mcpn-templates", "paper", "--mcpn-profile", "dev", "-k", "unit"]
    result = pytester.runpytest_subprocess(*plugins, "-p", "no:cacheprovider", *asked)
    result.assert_outcomes(passed=1, deselected=len(ALL) + len(MACHINES) - 1)


def test_the_first_example_of_the_page_passes_the_kit() -> None:
    page = (ROOT / "docs" / "templates.md").read_text()
    names: dict[str, Any] = {}
    exec(page.split("```python\n", 2)[1].partition("```")[0], names)
    assert type(names["Mine"]()) is not PaperTemplates
    assert broken(names["Mine"](), profile="dev") is None
    for machine in ("hardware", "shared hardware"):
        assert driven(names["Mine"](), profile="dev", only=machine) is None


def test_the_plugin_drives_templates_alone(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    pytester.makepyfile(forgetting="from tests.kit.test_kit import Forgetful as Mine\n")
    options = ["-p", "mcpn.pytest_plugin", "-p", "no:cacheprovider", "--mcpn-profile", "dev"]
    asked = ["--mcpn-templates", "forgetting:Mine", "-k", "alone and (software or hardware)"]
    result = pytester.runpytest_inprocess(*options, *asked)
    result.assert_outcomes(passed=1, failed=2, deselected=len(ALL) + len(MACHINES) - 3)
    result.stdout.fnmatch_lines(
        ["hardware, driven alone, breaks a promise: an interface of h holds 0 tokens*"]
    )
    result.stdout.no_fnmatch_line("*Traceback*")


def test_the_plugin_compares_sets(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    pytester.makepyfile(forgetting="from tests.kit.test_kit import Forgetful as Mine\n")
    options = ["-p", "mcpn.pytest_plugin", "-p", "no:cacheprovider", "--mcpn-profile", "dev", "-k", "behaves"]
    asked = ["--mcpn-templates", "forgetting:Mine", "--mcpn-templates", "compact", "--mcpn-like", "paper"]
    result = pytester.runpytest_inprocess(*options, *asked)
    result.assert_outcomes(passed=1, failed=1, deselected=2 * (len(ALL) - 1 + len(MACHINES)))
    result.stdout.fnmatch_lines(["*behaves_as is broken: They differ:*", "*these*paper*", "*<mission *"])
    result.stdout.no_fnmatch_line("*Traceback*")


def test_a_finding_says_all_there_is_to_know() -> None:
    told = str(BrokenProperty("one_safe", MISSIONS["retried"], Violation("twice", [("t",)])))
    assert told.startswith("one_safe is broken: twice\nrun:\n       t\n\non this mission:\n\n<mission ")
