"""Claims say what their formulas say: one engine makes them, another is asked."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from string import Formatter
from tracemalloc import get_traced_memory, start, stop
from typing import Any

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from mcpn.answers.causes.fmeca import fmeca
from mcpn.answers.causes.prospects import Prospects
from mcpn.answers.claims import KINDS, Claim, claims_of, claims_of_causes, claims_of_losses, entries, of_check
from mcpn.answers.claims.parts import FormulaParts
from mcpn.answers.claims.unasked import DEFEATING, UNASKED
from mcpn.errors import ConfluenceError, LimitError, UnsafeError
from mcpn.mission.model import SUCCEED, Mission, Objective
from mcpn.mission.passes import core
from mcpn.mission.requirement import Requirement
from mcpn.mission.xml import read_mission
from mcpn.report.checked import IDLE
from mcpn.spaces.engine_names import Engine
from mcpn.spaces.run import Run
from mcpn.spaces.stable.alternatives import direct
from mcpn.study import Study
from mcpn.testing import missions
from tests.conftest import ROOT, ULYSSE
from tests.draws import fewer
from tests.judge.nominal import said
from tests.logic.asked import ENGINES
from tests.logic.oracle import coming_home, fragile_missions
from tests.shares import returns_early
from tests.small import activity, hw, mission, robot


def made(study: Study, engine: Engine) -> list[Claim]:
    checked = study.verdicts(engine=engine)
    if checked.alternatives is None:
        return []
    causes = study.causes(engine=engine)
    return [*claims_of(checked), *claims_of_causes(causes, fmeca(causes.prospects))]


def confirm(mission: Mission, claims: list[Claim], engine: Engine) -> None:
    """Each formula holds where its claim does, by an engine that did not make it."""
    asked = Study(mission)
    for claim in claims:
        if claim.formula and claim.holds is not None:
            assert asked.ctl(claim.formula, engine=engine).holds == claim.holds, (claim.key, claim.formula)


def shown(claims: list[Claim]) -> None:
    """Each run that shows a claim can be played, and what repeats comes back to the state that it leaves."""
    for claim in claims:
        if claim.find_run is not None and (run := claim.find_run()) is not None:
            ended(run)
        if claim.find_lasso is not None and (lasso := claim.find_lasso()) is not None:
            run, before = lasso
            own = [t for t in run.transitions if not run.net.transitions[t].internal]
            assert before < len(own), claim.key
            once = ended(replace(run, transitions=tuple(own[:before]), settles=True))
            assert ended(replace(run, transitions=tuple(own), settles=True)) == once, claim.key


def ended(run: Run) -> tuple[int, ...]:
    """The marking that a run ends in."""
    marking = tuple(run.net.initial)
    for t in run.firings:
        assert t in run.net.enabled(marking)
        marking = run.net.fire(marking, t)
    return marking


@st.composite
def requiring(draw: st.DrawFn, drawn: st.SearchStrategy[Mission]) -> Mission:
    """Missions that require what one of two words says after the other."""
    mission = draw(drawn)
    words = [f"objective({block.name})" for block in mission.blocks if isinstance(block, Objective)]
    words += [f"oos({h.name})" for h in core(mission).hardware if h.faulty]
    words += [f"happens({event.name})" for event in mission.events]
    word = st.sampled_from(["success", "failure", *words])
    formula = draw(st.sampled_from(["G ({} -> F {})", "G ({} -> X {})", "F ({} | !{})"]))
    required = Requirement(name="r", formula=formula.format(draw(word), draw(word)))
    return replace(mission, requirements=(required,))


@fewer(0.15)
@given(
    said(missions(max_hardware=1, max_objectives=2, max_sections=3, facts=1))
    | requiring(missions(max_hardware=2, max_objectives=2, max_sections=3, events=2))
    | missions(max_hardware=3, max_objectives=2, max_sections=4, events=2, timeouts=2, early=1)
    | missions(max_hardware=2, max_objectives=2, max_sections=4, events=3, facts=1)
    | fragile_missions(max_hardware=3, max_objectives=2, max_sections=4, events=2)
    | fragile_missions(max_hardware=2, max_objectives=2, max_sections=4, faults=1)
    | fragile_missions(max_hardware=2, max_objectives=2, max_sections=4, crashes=True, lasting=True)
    | coming_home(),
    st.sampled_from([("explicit", "symbolic"), ("local", "explicit"), ("symbolic", "local")]),
)
def test_claims_of_drawn_missions(mission: Mission, engines: tuple[Engine, Engine]) -> None:
    study = Study(mission)
    maker, judge = engines
    try:
        direct(study.mission_net.net, max_states=2_000)
        claims = made(study, maker)
        confirm(mission, claims, judge)
        shown(claims)
        for claim in claims:
            event(f"{claim.kind} {claim.assumes.help}: {claim.holds}")
    except (LimitError, ConfluenceError, UnsafeError) as error:
        returns_early(type(error).__name__)


def test_claims_of_ulysse_do_not_depend_on_the_engine() -> None:
    checked = (Study(read_mission(ULYSSE)).verdicts(engine=engine) for engine in ENGINES)
    claims = [[(claim.key, claim.holds) for claim in claims_of(each)] for each in checked]
    assert claims[0] == claims[1] == claims[2]


def test_told_missions_are_told_as_they_are(faults: Path) -> None:
    """Missions of which sentences once were false: every claim on them is what its formula says."""
    told = 0
    for path in sorted((faults / "told").glob("*.xml")):
        mission = read_mission(path)
        claims = made(Study(mission), "explicit")
        confirm(mission, claims, "symbolic")
        told += len(claims)
    assert told > 300


def test_formulas_of_told_missions_have_the_answers_that_their_folder_has(faults: Path) -> None:
    answers = (faults / "told" / "verdicts.txt").read_text().splitlines()
    studies = {path.stem[:3]: Study(read_mission(path)) for path in (faults / "told").glob("*.xml")}
    for line in answers:
        mission, found, formula = line.split(" ", 2)
        assert studies[mission].ctl(formula).holds is (found == "holds"), line


ALONE = '<activity name="go"/></robot><objective name="dig" activities="go"{}/>'
NOMINAL = {
    "succeeds": (ALONE.format(""), ["nominal_success"]),
    "for ever": (ALONE.format(' success="dig" nominal="endless"'), ["nominal_endless"]),
    "for ever, and that is not meant": (ALONE.format(' success="dig"'), []),
    "ends as facts say": (
        '<fact name="full"/><activity name="pump"/><activity name="leak"/></robot>'
        '<parallel name="both" success="both" nominal="endless"><route goto="succeed" when="full"/>'
        '<objective name="fill" activities="pump"><sets fact="full" to="true" on="success"/></objective>'
        '<objective name="drain" activities="leak"><sets fact="full" to="false" on="success"/></objective>'
        "</parallel>",
        ["nominal_either"],
    ),
}


@pytest.mark.parametrize("name", NOMINAL)
def test_the_formula_of_one_kind_of_nominal_runs_holds(name: str, tmp_path: Path) -> None:
    text, expected = NOMINAL[name]
    (tmp_path / "m.xml").write_text(f"{HEAD}{text}</mission>")
    study = Study(read_mission(tmp_path / "m.xml"))
    parts = FormulaParts(
        Prospects(study.mission_net, study.mission_spaces().space("explicit", "alternatives"))
    )
    good, lasts = parts.goes_well()
    for engine in ENGINES:
        kinds = (kind for kind in KINDS if kind.startswith("nominal_"))
        holding = [
            kind
            for kind in kinds
            if study.ctl(
                KINDS[kind].formula.format(good=good, lasts=lasts, as_meant=parts.as_meant), engine=engine
            ).holds
        ]
        assert holding == expected
        found = study.verdicts(engine=engine)
        claims = [c.kind for c in claims_of(found) if c.kind.startswith("nominal_") and c.holds]
        assert claims == expected


BOTH_WAYS = {
    "met_as_never": (
        '<event name="storm"/><fact name="wet"/><activity name="go"/></robot>'
        '<requirement name="hides" formula="G (happens(storm) -&gt; X objective(rest))"/>'
        '<requirement name="digs" formula="G (happens(storm) -&gt; X objective(dig))"/>'
        '<objective name="dig" activities="go" success="succeed"><route goto="rest" when="wet"/></objective>'
        '<objective name="rest" activities="go"/>',
        {"met_as_never: hides, objective(rest)": True, "met_as_never: digs, objective(dig)": False},
    ),
    "event_leaves_repair": (
        '<hardware name="motor"/><event name="storm"/><event name="fog"/><activity name="drift"/>'
        '<activity name="climb" consumes="motor"/></robot>'
        '<objective name="swim" activities="drift" success="succeed"><on event="storm" goto="rise"/>'
        '<on event="fog" goto="succeed"/></objective>'
        '<objective name="rise" activities="climb" failure="rise"/>',
        {"event_leaves_repair: storm": True, "event_leaves_repair: fog": False},
    ),
    "loss_unnoticed_later": (
        '<hardware name="lamp" detected="late"/><hardware name="sonar"/><hardware name="motor"/>'
        '<activity name="see"><alternative name="hear" consumes="sonar"/>'
        '<alternative name="look" consumes="lamp"/></activity>'
        '<activity name="shine" consumes="lamp"/></robot>'
        '<objective name="search" activities="see"/><objective name="signal" activities="shine"/>',
        {
            "loss_unnoticed_later: lamp, search": True,
            "loss_unnoticed_later: lamp, signal": False,
        },
    ),
}


@pytest.mark.parametrize("kind", BOTH_WAYS)
@pytest.mark.parametrize("engine", ENGINES)
def test_kinds_that_are_seldom_drawn_hold_and_fail(kind: str, engine: Engine, tmp_path: Path) -> None:
    text, expected = BOTH_WAYS[kind]
    (tmp_path / "m.xml").write_text(f"{HEAD}{text}</mission>")
    mission = read_mission(tmp_path / "m.xml")
    claims = [claim for claim in made(Study(mission), engine) if claim.kind == kind]
    assert {claim.key: claim.holds for claim in claims} == expected
    assert all(claim.formula for claim in claims)
    for judge in ENGINES:
        confirm(mission, claims, judge)


HEAD = '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r">'


def of(text: str, tmp_path: Path, engine: Engine = "explicit") -> dict[str, Claim]:
    (tmp_path / "m.xml").write_text(f"{HEAD}{text}</mission>")
    return {claim.key: claim for claim in made(Study(read_mission(tmp_path / "m.xml")), engine)}


def test_a_loss_that_a_rescue_makes_up_for_is_told_so(tmp_path: Path) -> None:
    claims = of(
        '<hardware name="motor" repairable="false"/><event name="rescue"/>'
        '<activity name="drive" consumes="motor"/><activity name="wait"/></robot>'
        '<objective name="go" activities="drive" failure="go" success="succeed">'
        '<on event="rescue" goto="towed"/></objective>'
        '<objective name="towed" activities="wait" failure="towed"/>',
        tmp_path,
    )
    assert claims["loss_defeats: motor"].holds is False
    alone = claims["loss_defeats: motor: without help"]
    assert (alone.holds, alone.refers_to) == (True, ("rescue",))
    assert alone.sentence == (
        "The loss of motor alone, at its worst moment, leaves no way to success without the help of rescue."
    )
    assert claims["succeeds_without: go"].holds


def test_where_success_is_out_of_reach_nothing_says_that_it_stays_possible(tmp_path: Path) -> None:
    robot = (
        '<hardware name="motor"/><event name="rescue"/><fact name="wet"/>'
        '<activity name="drive" consumes="motor"/><activity name="wait"/></robot>'
    )
    never = of(f'{robot}<objective name="go" activities="drive" success="fail"/>', tmp_path)
    assert not never["can_succeed"].holds
    assert [key for key in never if key.startswith("loss_defeats")] == []
    assert never["end_always_decides: go, failure"].sentence.endswith(
        "or it never comes where success is in reach."
    )
    assert never["fact_defeats: wet, false"].sentence.endswith("or never succeeds.")
    aided = of(
        f'{robot}<objective name="go" activities="drive" success="fail"><on event="rescue" goto="towed"/>'
        '</objective><objective name="towed" activities="wait"/>',
        tmp_path,
    )
    assert [key for key in aided if key.startswith("loss_defeats")] == ["loss_defeats: motor"]


def test_a_loss_after_an_objective_that_fails_by_itself_counts(tmp_path: Path) -> None:
    claims = of(
        '<hardware name="camera"/><hardware name="anchor"/><activity name="film" consumes="camera"/>'
        '<activity name="hold" consumes="anchor"/></robot>'
        '<objective name="survey" activities="film" success="succeed" failure="park"/>'
        '<objective name="park" activities="hold" success="abort" failure="park"/>',
        tmp_path,
    )
    anchor = claims["loss_endangers: anchor"]
    assert anchor.holds
    assert anchor.find_run is not None
    run = anchor.find_run()
    assert run is not None
    assert [str(each) for each in run.events][-2:] == ["OBJ_survey_EV_FAIL", "anchor_EV_OOS"]
    assert claims["loss_endangers: camera"].holds is False


@pytest.mark.parametrize("engine", ENGINES)
def test_a_second_emergency_interrupts_what_the_first_leads_to(engine: Engine, tmp_path: Path) -> None:
    claims = of(
        '<event name="low"/><event name="critical"/><activity name="fly"/></robot>'
        '<on event="low" goto="climb"/><on event="critical" goto="land"/>'
        '<objective name="survey" activities="fly"/>'
        '<objective name="climb" activities="fly" success="land" failure="land"/>'
        '<objective name="land" activities="fly" success="succeed" failure="land"/>',
        tmp_path,
        engine,
    )
    found = claims["interrupts_answer: low, land, critical"]
    assert found.holds
    assert found.sentence == "low interrupts land, to which critical leads."
    ever = claims["alternate_for_ever"]
    assert ever.holds
    assert ever.sentence == "low and critical may go on for ever, and nothing else happens."
    shown([ever])


def test_a_set_with_what_may_crash_is_supposed_to_be_missing(tmp_path: Path) -> None:
    claims = of(
        '<hardware name="sonar"/><activity name="look"><alternative name="cam" faulty="true"/>'
        '<alternative name="ear" consumes="sonar"/></activity></robot>'
        '<objective name="see" activities="look"/>',
        tmp_path,
    )
    assert claims["missing_defeats: look.cam and sonar"].sentence == (
        "Without look.cam and sonar from the start on, for good, there is no way to success."
    )
    assert claims["loss_before_defeats: sonar"].holds is False


def test_of_many_objectives_one_claim_says_what_is_so_of_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing is left out: a claim on all others takes the place of one on each."""
    text = (
        '<hardware name="motor"/><event name="leak"/><activity name="go" consumes="motor"/>'
        '<activity name="wait"/></robot><objective name="a" activities="wait"/>'
        '<objective name="b" activities="go"><on event="leak" goto="c"/></objective>'
        '<objective name="c" activities="wait"/>'
    )
    every = of(text, tmp_path)
    for module in (entries, of_check):
        monkeypatch.setattr(module, "MOST_PAIRS", 1)
    some = of(text, tmp_path)
    assert {key for key in every if key not in some} == {
        "ignored: leak, b",
        "ignored: leak, c",
        *(f"loss_at_entry_defeats: motor, {entered}" for entered in "abc"),
    }
    else_ = some["handled_else: leak"]
    assert (else_.holds, else_.formula) == (True, "AG (((objective(b))) -> event(leak))")
    assert some["loss_at_entries_spares_success: motor"].holds
    assert some["ignored: leak, a"].holds
    confirm(read_mission(tmp_path / "m.xml"), list(some.values()), "symbolic")


def test_keys_are_those_of_one_claim(tmp_path: Path) -> None:
    study = Study(read_mission(ROOT / "experiments" / "courier" / "mission.xml"))
    keys = [claim.key for claim in claims_of(study.verdicts())]
    assert len(keys) == len(set(keys))


@fewer(0.1)
@given(missions(), st.sampled_from(sorted(KINDS)))
def test_whoever_asks_for_some_kinds_has_the_claims_of_these(mission: Mission, kind: str) -> None:
    """What makes claims says of which kinds they are: it is not asked for others."""
    try:
        checked = Study(mission).verdicts()
    except (LimitError, ConfluenceError, UnsafeError) as error:
        returns_early(type(error).__name__)
        return
    claims = claims_of(checked)
    for asked in ({kind}, IDLE, {*DEFEATING, *UNASKED}):
        assert claims_of(checked, asked) == [claim for claim in claims if claim.kind in asked]


def test_kinds_without_a_formula_say_why() -> None:
    for kind in KINDS.values():
        assert kind.formula or kind.why
        for sentence in kind.sentences:
            named = {name for _, name, _, _ in Formatter().parse(sentence) if name is not None}
            assert named <= {"0", "1", "2", "3", "4", "5", "others", "given", "moments"}


def test_what_claims_keep_grows_as_their_objectives_do() -> None:
    """None keeps what may happen in the whole mission, which has as many events as it has objectives."""
    kept = []
    for sites in (30, 120):
        names = [*(f"visit{i}" for i in range(sites)), SUCCEED]
        visits = (
            Objective(name=one, activities=("look",), success=then, failure=then)
            for one, then in pairwise(names)
        )
        checked = Study(mission(robot(hw("camera"), activity("look", ("camera",))), *visits)).verdicts()
        claims_of(checked)  # what is computed once for a mission
        start()
        claims = claims_of(checked)
        kept.append(get_traced_memory()[0])
        stop()
        assert [c.holds for c in claims if c.kind == "succeeds_without"] == [True] * sites
    assert kept[1] < 4 * kept[0]


def test_ways_that_losses_leave_are_found_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each loss asked again for the ways without it: of many sections that was a third of causes."""
    blocks = [Objective(name=name, activities=("a",)) for name in ("first", "second")]
    study = Study(mission(robot(hw("h1", "h2", "h3"), activity("a", ("h1", "h2"), ("h3",))), *blocks))
    prospects, asked = study.causes(engine="local").prospects, list[tuple[object, object]]()
    reaching = type(prospects.space).reaching

    def counted(space: Any, goal: Any, along: Any = None, transitions: Any = None, guards: Any = None) -> Any:
        asked.append((goal, transitions))
        return reaching(space, goal, along, transitions, guards)

    monkeypatch.setattr(type(prospects.space), "reaching", counted)
    assert claims_of_losses(prospects)
    assert len(asked) == len({*asked}) == 4  # with all events, and without each repair
