"""What is told of small missions of which more, or something else, was once told."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from mcpn.answers.causes.effects import Severity
from mcpn.answers.causes.fmeca import fmeca
from mcpn.answers.claims import Claim, claims_of, claims_of_causes
from mcpn.answers.claims.claim import told
from mcpn.answers.claims.of_check import of_verdict
from mcpn.answers.claims.unasked import DEFEATING, UNASKED, ClaimRun, run_of, unasked
from mcpn.mission.xml import read_mission
from mcpn.report.failures.sentences import headlines, of_objectives
from mcpn.study import Study
from tests.commands import mcpn

HEAD = '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r">'


def of(folder: Path, text: str) -> Study:
    path = folder / "m.xml"
    path.write_text(f"{HEAD}{text}</mission>")
    return Study(read_mission(path))


OUT = (
    '<hardware name="radio" initial="oos"/><hardware name="lamp" initial="oos"/>'
    '<activity name="call" consumes="radio"/><activity name="shine" consumes="lamp"/><activity name="wait"/>'
    "</robot>"
)


def nominal(study: Study) -> str:
    return of_verdict(study.verdicts().verdicts["nominal_success"]).sentence


def test_hardware_that_is_out_at_first_is_named_where_success_needs_it(tmp_path: Path) -> None:
    calls = of(tmp_path, f'{OUT}<objective name="report" activities="call"/>')
    assert nominal(calls) == "While nothing fails, and once radio works again, the mission succeeds."
    assert not calls.ctl("E((!happens(radio_EV_RD)) U success)").holds
    waits = of(tmp_path, f'{OUT}<objective name="report" activities="wait"/>')
    assert nominal(waits) == "While nothing fails, the mission succeeds."


def test_a_mission_that_may_go_on_for_ever_is_not_told_to_succeed_alone(tmp_path: Path) -> None:
    patrol = (
        '<activity name="wait"/><fact name="door" values="shut open"/></robot>'
        '<objective name="go" activities="wait" nominal="endless" success="go">{}</objective>'
    )
    for_ever = of(tmp_path, patrol.format(""))
    assert nominal(for_ever) == "While nothing fails, the mission goes on for ever, as it is meant to."


def test_a_block_that_may_be_left_out_and_is_has_its_name(tmp_path: Path) -> None:
    found = of(
        tmp_path,
        '<activity name="wait"/></robot><objective name="go" activities="wait" success="succeed"/>'
        '<objective name="more" activities="wait" nominal="optional"/>',
    )
    verdict = found.verdicts().verdicts["nominal_success"]
    assert verdict.explanation == (
        "while nothing fails every run succeeds, and nothing is left out but more, which may be"
    )


def test_a_mission_that_was_lost_before_is_told_so(tmp_path: Path) -> None:
    """A failure that costs the objective alone takes nothing from a mission that can only be aborted."""
    found = of(
        tmp_path,
        '<hardware name="lamp"/><event name="leak"/><activity name="shine" consumes="lamp"/>'
        '<activity name="wait"/></robot><on event="leak" goto="rescue"/>'
        '<objective name="go" activities="wait" success="succeed"/>'
        '<objective name="rescue" activities="shine" success="give_up" failure="give_up"/>'
        '<objective name="give_up" activities="wait" success="abort" failure="give_up"/>',
    )
    (row,) = (row for row in fmeca(found.causes().prospects) if row.objective == "rescue")
    assert (row.severity, row.mission_effect) == (
        Severity.OBJECTIVE_LOST,
        "can end safely, but no longer succeed, as before it",
    )
    assert found.ctl("AG (objective(rescue) -> !EF success & EF abort)").holds


TWO = (
    '<hardware name="motor" repairable="false"/><event name="storm"/><activity name="watch"/>'
    '<activity name="film"/><activity name="hold" consumes="motor"/></robot><parallel name="work">'
    '<objective name="one"><objective name="a" activities="watch" success="succeed">'
    '<on event="storm" goto="b"/></objective><objective name="b" activities="hold"/></objective>'
    '<objective name="two" activities="film"/></parallel>'
)


def test_a_fault_tree_says_what_it_does_not_hold(tmp_path: Path) -> None:
    """Its gates hold what is lost before the start; the worst moment comes later."""
    from lxml import etree

    from mcpn.report.failures.openpsa import open_psa

    study = of(tmp_path, TWO)
    goal = study.causes().mission
    assert (goal.cut_sets, goal.only_at_worst) == ([], [("motor",)])
    assert study.ctl("EF (objective(b) & oos(motor) & !EF success)").holds
    tree = etree.fromstring(open_psa(study.mission_net.usage, goal.cut_sets, {}, worst=goal.only_at_worst))
    label = tree.findtext("define-fault-tree/label") or ""
    assert "holds losses before the start; at its worst moment motor defeats it, too" in label


def test_two_optional_failures_fail_a_block_while_another_child_runs(tmp_path: Path) -> None:
    """As the last children fail, the mandatory one has decided already."""
    found = of(
        tmp_path,
        '<hardware name="eye"/><activity name="look" consumes="eye"/><activity name="wait"/>'
        '<activity name="rest"/></robot><parallel name="work" failure_when="2">'
        '<objective name="a" activities="look" mandatory="false"/>'
        '<objective name="b" activities="rest" mandatory="false"/><objective name="c" activities="wait"/>'
        "</parallel>",
    )
    (row,) = (row for row in fmeca(found.causes().prospects) if row.objective == "a")
    assert row.compensation == "2 failures fail work while another child runs"
    last = "E(F (happens(OBJ_b_EV_FAIL) & !objective(a) & !objective(c) & X success))"
    assert found.ctl(last).holds


def unasked_of(study: Study) -> list[str]:
    claims = claims_of(study.verdicts())
    return [sentence for _, said in unasked(claims, (*DEFEATING, *UNASKED)) for sentence in said]


def test_what_a_reader_is_told_unasked(tmp_path: Path) -> None:
    """A second emergency that interrupts the answer to the first, and a survey that leaves out its lines."""
    found = of(
        tmp_path,
        '<event name="low"/><event name="critical"/><activity name="fly"/></robot>'
        '<on event="low" goto="climb"/><on event="critical" goto="land"/>'
        '<objective name="lines" activities="fly" failure="land"/>'
        '<objective name="climb" activities="fly" success="land" failure="land"/>'
        '<objective name="land" activities="fly" success="succeed" failure="land"/>',
    )
    said = unasked_of(found)
    assert "low interrupts land, to which critical leads." in said
    assert "low and critical may go on for ever, and nothing else happens." in said
    assert any("may end in success without" in sentence and "lines" in sentence for sentence in said)
    path = tmp_path / "m.xml"
    assert "low interrupts land, to which critical leads." in mcpn("check", path).stdout


def test_facts_and_events_that_put_success_out_of_reach_are_told(tmp_path: Path) -> None:
    found = of(
        tmp_path,
        '<fact name="broken"/><event name="breaks"><sets fact="broken" to="true"/></event>'
        '<activity name="grasp"/><activity name="wait"/></robot>'
        '<objective name="take" activities="grasp" success="succeed" failure="take">'
        '<route when="broken" goto="stay"/></objective>'
        '<objective name="stay" activities="wait" success="stay" failure="stay"/>',
    )
    said = unasked_of(found)
    assert "Once broken is true success is out of reach." in said
    assert "breaks can put success out of reach, whatever is repaired." in said
    assert found.ctl("AG (fact(broken)=true & !success -> !EF success)").holds


def test_several_names_begin_a_sentence_and_one_is_written_as_it_is() -> None:
    assert told([Claim("unrated", (name,), True) for name in ("leak", "rain")]) == (
        "Each of leak and rain has no rate, and never happens in these numbers."
    )
    assert (
        told([Claim("unrated", ("leak",), True)]) == "leak has no rate, and never happens in these numbers."
    )


def test_what_never_succeeds_is_not_told_to_need_a_repair(tmp_path: Path) -> None:
    found = of(
        tmp_path,
        '<hardware name="lamp"/><fact name="open"/><activity name="pull" requires="open=true"/>'
        '<activity name="shine" consumes="lamp"/></robot>'
        '<objective name="go" activities="pull" success="rest" failure="rest"/>'
        '<objective name="rest" activities="shine"/>',
    )
    causes = found.causes()
    assert "The success of go never comes." in [*of_objectives(causes)]
    assert not found.ctl("E(F happens(OBJ_go_EV_OK))").holds
    never = of(
        tmp_path, '<activity name="wait"/></robot><objective name="go" activities="wait" success="fail"/>'
    )
    causes = never.causes()
    assert next(headlines(causes, claims_of_causes(causes))) == "The mission can never succeed."


def test_a_mission_that_a_declared_event_alone_ends_well_says_so(tmp_path: Path) -> None:
    found = of(
        tmp_path,
        '<event name="stop"/><activity name="wait"/></robot>'
        '<objective name="go" activities="wait" success="go" failure="go" nominal="endless">'
        '<on event="stop" goto="home"/></objective><objective name="home" activities="wait"/>',
    )
    causes = found.causes()
    first = next(headlines(causes, claims_of_causes(causes)))
    assert first == "The mission can succeed only with the help of stop."
    assert not found.ctl("E((!happens(stop)) U success)").holds


def test_an_event_that_leads_past_the_block_which_parks_is_told(tmp_path: Path) -> None:
    """An abort of the mission itself leads past a block that catches what aborts inside another."""
    found = of(
        tmp_path,
        '<event name="stop"/><activity name="fly"/></robot><on event="stop" goto="abort"/>'
        '<objective name="survey" abort="park" success="succeed">'
        '<objective name="lines" activities="fly" failure="abort"/></objective>'
        '<objective name="park" activities="fly" success="abort" failure="park"/>',
    )
    assert "stop can lead to abort without park, which makes the robot safe elsewhere." in [
        sentence[:1].lower() + sentence[1:] for sentence in unasked_of(found)
    ]
    assert "can lead to abort without park" in mcpn("check", tmp_path / "m.xml").stdout
    assert found.ctl("E(F (!objective(park) & happens(stop) & X abort))").holds


def test_help_that_an_end_needs_is_told_by_name(tmp_path: Path) -> None:
    found = of(
        tmp_path,
        '<event name="rescue"/><activity name="wait"/></robot>'
        '<objective name="stay" activities="wait" success="stay" failure="stay">'
        '<on event="rescue" goto="succeed"/></objective>',
    )
    said = unasked_of(found)
    assert "The mission can succeed only with the help of rescue." in said
    assert "The mission can reach a state from which only rescue leads to an end." in said
    assert not found.ctl("E((!happens(rescue)) U success)").holds


def test_faults_of_failsafes_are_told_unasked(faults: Path) -> None:
    """Of each mission in the folder something is told that none asked for, by the terminal too."""
    files = sorted((faults / "failsafes").glob("*.xml"))
    assert files
    for path in files:
        said = unasked_of(Study(read_mission(path)))
        assert any(" interrupts " in sentence or " can lead to abort " in sentence for sentence in said), path
        printed = mcpn("--width", 1000, "check", path).stdout
        assert all(sentence in printed for sentence in said), path


def along(found: Study, shown: ClaimRun, last: str = "true") -> bool:
    """Whether the events of a run may happen one after the other, and what then is so."""
    formula = last
    for event in reversed(shown.events):
        formula = f"happens({event}) & X ({formula})"
    return bool(found.ctl(f"E({formula})", engine="symbolic").holds)


@pytest.mark.parametrize(
    ("text", "key", "last"),
    [
        (
            '<event name="low"/><event name="critical"/><activity name="fly"/></robot>'
            '<on event="low" goto="climb"/><on event="critical" goto="land"/>'
            '<objective name="survey" activities="fly"/>'
            '<objective name="climb" activities="fly" success="land" failure="land"/>'
            '<objective name="land" activities="fly" success="succeed" failure="land"/>',
            "interrupts_answer: low, land, critical",
            "objective(climb) & !objective(land)",
        ),
        (
            '<event name="link_lost"/><event name="link_back"/><activity name="fly"/></robot>'
            '<objective name="survey" activities="fly"><on event="link_lost" goto="hold"/></objective>'
            '<objective name="hold" activities="fly"><on event="link_back" goto="survey"/></objective>',
            "alternate_for_ever",
            "objective(survey)",
        ),
        (
            '<event name="leak"/><activity name="go"/><activity name="lock"/></robot>'
            '<objective name="work" activities="go" success="succeed" failure="park">'
            '<on event="leak" goto="abort"/></objective>'
            '<objective name="park" activities="lock" success="abort"/>',
            "leads_past: leak",
            "abort",
        ),
    ],
)
def test_what_failsafes_may_do_is_told_unasked_with_a_run(
    text: str, key: str, last: str, tmp_path: Path
) -> None:
    """A second emergency, events that go on for ever, an event that leads past what parks."""
    found, file = of(tmp_path, text), tmp_path / "m.xml"
    claims = {claim.key: claim for claim in claims_of(found.verdicts())}
    shown = run_of(claims[key])
    assert shown is not None
    assert along(found, shown, last)
    if shown.repeats is not None:
        again = shown.events[shown.repeats :]
        assert again
        assert along(found, shown._replace(events=[*shown.events, *again, *again]), last)
    printed = mcpn("--width", 1000, "check", file).stdout
    assert f"{claims[key].sentence}\n       by {shown.words}" in printed
    document = json.loads(mcpn("check", file, "--json").stdout)
    assert document["runs"][key] == {"events": [*map(str, shown.events)], "repeats": shown.repeats}
