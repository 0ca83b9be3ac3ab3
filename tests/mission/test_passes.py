"""Passes from what an author writes to the core mission: what each gives reads again, and means the same."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given

from mcpn.errors import InputError
from mcpn.mission.core.copies import Copies
from mcpn.mission.core.flattening import flatten
from mcpn.mission.model import Each, FactRoute, Handler, Mission, Objective, Parallel, Recursive, Use, walk
from mcpn.mission.passes import PASSES, core
from mcpn.mission.passes.recovery import recovery_problems
from mcpn.mission.robot import Crash, DeclaredEvent, Fact, Hardware
from mcpn.mission.writer import write_mission
from mcpn.mission.xml import read_mission
from mcpn.testing.elements import WIDEST
from tests.conftest import ROOT, ULYSSE
from tests.draws import fewer
from tests.small import activity, mission, robot


def placed(copies: Copies) -> dict[str, list[object]]:
    """Where each objective stands: itself and the blocks around it, with what tells copies apart."""
    return {
        name: [(at.prefix, at.block, at.suffixes, at.protocol, at.nominal) for at in position.chain]
        for name, position in copies.objectives.items()
    }


def meaning(mission: Mission) -> tuple[Any, ...]:
    """All that follows from a mission: its objectives graph, what names mean in it, requirements, robots."""
    graph = flatten(mission)
    assert graph.core is not None
    robots = graph.core.hardware, graph.core.activities
    return graph, graph.unreached, placed(graph.copies), graph.requirements, robots


@fewer(0.7)
@given(mission=WIDEST)
def test_what_a_pass_gives_reads_again_and_means_the_same(
    mission: Mission, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path, whole = tmp_path_factory.mktemp("core") / "m.xml", meaning(mission)
    for rewrite in PASSES:
        rewritten = core(mission, until=rewrite.__name__)
        path.write_bytes(write_mission(rewritten))
        assert (again := read_mission(path)) == rewritten, rewrite.__name__
        assert meaning(again) == whole, rewrite.__name__


def test_a_core_mission_holds_objectives_and_parallel_blocks_alone() -> None:
    for path in sorted((ROOT / "experiments").glob("*/mission.xml")):
        made = core(read_mission(path))
        assert not [block for block in walk(made.blocks) if isinstance(block, Use | Each)], path
        assert not [b for b in walk(made.blocks) if b.retries or b.repeat is not None], path
        series = [block for block in walk(made.blocks) if isinstance(block, Recursive)]
        assert not [block for block in series if block.parameters or block.timeout is not None], path


def test_the_lines_of_an_author_stay() -> None:
    mission = read_mission(ULYSSE)
    texts = (mission.blocks, *(protocol.blocks for protocol in mission.protocols))
    lines = {(block.name, block.source) for blocks in texts for block in walk(blocks)}
    assert {(block.written, block.source) for block in walk(core(mission).blocks)} <= lines


@pytest.mark.parametrize(
    ("attribute", "found"),
    [
        ('copy="try1"', "found the attribute copy on <objective>"),
        ('protocol="deliver"', "found the attribute protocol on <objective>"),
        ('success="timed out"', "success of <objective> is 'timed out'"),
    ],
)
def test_words_of_core_missions_are_refused_in_others(tmp_path: Path, attribute: str, found: str) -> None:
    (tmp_path / "m.xml").write_text(
        '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><activity name="a"/></robot>'
        f'<objective name="o" {attribute}><objective name="p" activities="a"/></objective></mission>'
    )
    with pytest.raises(InputError, match=found):
        read_mission(tmp_path / "m.xml")


RECOVERING = """<objective name="take" activities="a" recover="back" times="2" failure="give_up">
    <route on="success" when="sunny" goto="give_up"/>
    <route on="failure" when="sunny" goto="fail"/>
    <on event="stop" pause="shelter"/>
  </objective>
  <objective name="back" activities="a"/>
  <objective name="shelter" activities="a"/>
  <objective name="give_up" activities="a"/>"""


def test_a_block_that_recovers_becomes_its_runs_with_copies_of_the_sibling_between_them(
    tmp_path: Path,
) -> None:
    robot = '<robot name="r"><fact name="sunny"/><event name="stop"/><activity name="a"/></robot>'
    path = tmp_path / "m.xml"
    path.write_text(f'<mission name="m" xmlns="urn:mcpn:mission:1">{robot}{RECOVERING}</mission>')
    written = core(read_mission(path), until="recovery")
    assert [(b.name, b.success, b.failure, [(r.on, r.goto) for r in b.routes]) for b in written.blocks] == [
        ("take_run1", "give_up", "back_take1", [("success", "give_up")]),
        ("back_take1", "take_run2", "give_up", [("failure", "fail without reason")]),
        ("take_run2", "give_up", "back_take2", [("success", "give_up")]),
        ("back_take2", "take_run3", "give_up", [("failure", "fail without reason")]),
        ("take_run3", "give_up", "give_up", [("success", "give_up"), ("failure", "fail")]),
        ("shelter", "give_up", None, []),
        ("give_up", "succeed", None, []),
    ]
    pauses = [[handler.fails_as for handler in block.handlers] for block in written.blocks]
    assert pauses == [["take_run3"], [], ["take_run3"], [], [None], [], []]
    path.write_bytes(write_mission(written).replace(b'fails_as="take_run3"', b'fails_as="shelter"'))
    with pytest.raises(InputError, match="fails_as of take_run1 names shelter; expected"):
        read_mission(path)


FAULTS = """<mission name="m" xmlns="urn:mcpn:mission:1">
  <robot name="r">
    <hardware name="left"/><hardware name="right"/>
    <fault name="water" affects="left lamp" repairable="false" failure_rate="2"/>
    <activity name="a">
      <alternative name="both" consumes="left right"/><alternative name="dark" consumes="lamp right"/>
      <alternative name="one" consumes="right"/>
    </activity>
  </robot>
  <robot name="s"><hardware name="lamp"/></robot>
  <objective name="o" activities="a"/>
</mission>"""


def test_common_causes_become_hardware_behind_all_other_that_users_of_what_they_affect_consume_too(
    tmp_path: Path,
) -> None:
    (path := tmp_path / "m.xml").write_text(FAULTS)
    written = core(of := read_mission(path), until="faults")
    assert [[h.name for h in robot.hardware] for robot in of.robots] == [["left", "right"], ["lamp"]]
    assert [h.name for h in written.hardware] == ["left", "right", "lamp", "water"]
    (water,) = written.common_causes
    assert (water.shared, water.repairable, water.failure_rate) == (True, False, 2.0)
    assert (water.affects, water.source) == (("left", "lamp"), of.faults[0].source)
    consumed = [way.consumes for way in written.activities[0].alternatives]
    assert consumed == [("left", "right", "water"), ("lamp", "right", "water"), ("right",)]
    path.write_bytes(text := write_mission(written))
    assert read_mission(path) == written
    for wrong, found in (
        (text.replace(b' core="true"', b""), "found the attribute affects on <hardware>"),
        (text.replace(b'shared="true" ', b""), "water stands for a common cause: expected it shared"),
        (text.replace(b'"left lamp"', b'"left lamb"'), "water affects lamb, which is not declared"),
    ):
        path.write_bytes(wrong)
        with pytest.raises(InputError, match=found):
            read_mission(path)


def test_missions_of_authors_have_no_hardware_that_stands_for_common_causes() -> None:
    h = Hardware(name="h")
    of = robot((h, Hardware(name="w", shared=True, affects=("h",))), activity("a", ("h",)))
    with pytest.raises(InputError, match="w has affects, though the mission is no core mission"):
        flatten(mission(of, Objective(name="o", activities=("a",))))


CRASHES = """<mission name="m" xmlns="urn:mcpn:mission:1">
  <robot name="r">
    <hardware name="lidar"/>
    <activity name="find" faulty="true" recovers="false" failure_rate="2">
      <alternative name="by_scan" consumes="lidar" faulty="true" failure_rate="3" repair_rate="4"/>
      <alternative name="by_hand"/>
    </activity>
    <activity name="go"/>
  </robot>
  <objective name="o" activities="find go"/>
</mission>"""


def test_what_may_crash_consumes_what_stands_for_that(tmp_path: Path) -> None:
    (path := tmp_path / "m.xml").write_text(CRASHES)
    written = core(of := read_mission(path))
    find, go = written.activities
    assert [(find.faulty, find.recovers, find.failure_rate), go] == [(False, True, None), of.activities[1]]
    assert [way.consumes for way in find.alternatives] == [("lidar", "find", "find.by_scan"), ("find",)]
    scan = find.alternatives[0]
    assert (scan.faulty, scan.failure_rate, scan.repair_rate) == (False, None, None)
    assert [h.name for h in written.hardware] == ["lidar", "find", "find.by_scan"]
    told = [(c.activity, c.repairable, c.failure_rate, c.repair_rate) for c in written.crashes]
    assert told == [("find", False, 2.0, None), ("find", True, 3.0, 4.0)]
    lines = of.activities[0].source, of.activities[0].alternatives[0].source
    assert tuple(c.source for c in written.crashes) == lines
    path.write_bytes(text := write_mission(written))
    assert read_mission(path) == written
    for old, new, found in (
        (b' core="true"', b"", "found <crash> inside <robot>"),
        (
            b'<crash name="find"',
            b'<crash faulty="false" name="find"',
            "found the attribute faulty on <crash>",
        ),
        (b'activity="find"', b'activity="fund"', "find is of activity fund, which is not declared"),
        (
            b'<activity name="go"',
            b'<activity name="go" consumes="find"',
            "go consumes find, which stands",
        ),
        (
            b'repairable="false"',
            b'repairable="false" repair_rate="1"',
            "find has a repair_rate, though it",
        ),
        (b'<crash name="find"', b'<crash name="lidar"', "resource lidar is declared twice"),
    ):
        assert old in text
        path.write_bytes(text.replace(old, new, 1))
        with pytest.raises(InputError, match=found):
            read_mission(path)


def test_missions_of_authors_hold_nothing_that_stands_for_crashes() -> None:
    of = replace(robot((), activity("a", ())), crashes=(Crash(name="a", activity="a"),))
    with pytest.raises(InputError, match="has crashes, though the mission is no core mission"):
        flatten(mission(of, Objective(name="o", activities=("a",))))


REASONS = """<mission name="m" xmlns="urn:mcpn:mission:1">
  <robot name="r">
    <activity name="a" failures="stuck lost"/><activity name="b"/><activity name="c" failures="dark"/>
  </robot>
  <protocols>
    <protocol name="unused"><objective name="n" activities="a">
      <route reason="lost" on="failure" goto="abort"/>
    </objective></protocol>
  </protocols>
  <objective name="o" activities="b c a" failures="lost=0.5 cold"/>
  <objective name="p" activities="b" failures="cold"/>
</mission>"""


def test_reasons_of_activities_stand_on_the_objectives_that_run_them(tmp_path: Path) -> None:
    (path := tmp_path / "m.xml").write_text(REASONS)
    written = core(read_mission(path), until="reasons")
    assert not any(activity.failures for activity in written.activities)
    named = [block.failures for block in walk(written.blocks) if isinstance(block, Objective)]
    assert named == [("dark", "stuck", "lost=0.5", "cold"), ("cold",)]
    path.write_bytes(write_mission(written))
    assert read_mission(path) == written  # though the protocol that nothing uses asks for a reason, too


DONE = """<mission name="m" xmlns="urn:mcpn:mission:1">
  <robot name="r"><fact name="sunny"/><activity name="a" requires="!done(late)"/></robot>
  <protocols><protocol name="p">
    <objective name="look" activities="a"><sets fact="sunny" to="true"/></objective>
    <objective name="late" activities="a"/>
  </protocol></protocols>
  <requirement name="seen" formula="F done(look)"/>
  <use name="twice" protocol="p" repeat="2"/>
  <objective name="o" activities="a"/>
</mission>"""


def test_what_objectives_have_done_is_a_fact_that_each_copy_of_them_sets(tmp_path: Path) -> None:
    (path := tmp_path / "m.xml").write_text(DONE)
    written = core(of := read_mission(path))
    declared = ["sunny", "done(late)", "done(look)"]
    assert [fact.name for fact in written.every_fact] == declared
    assert written.facts == of.facts == of.every_fact
    changes = {
        block.name: [(change.fact, change.to, change.occasion) for change in block.sets]
        for block in walk(written.blocks)
        if isinstance(block, Objective)
    }
    look = [("sunny", "true", "success"), ("done(look)", "true", "success")]
    late = [("done(late)", "true", "success")]
    rounds = {f"twice_{n}.{name}": sets for n in (1, 2) for name, sets in (("look", look), ("late", late))}
    assert changes == {**rounds, "o": []}
    path.write_bytes(text := write_mission(written))
    assert read_mission(path) == written
    assert core(read_mission(path)) == written
    path.write_bytes(text.replace(b' core="true"', b""))
    with pytest.raises(InputError, match=r"name of <fact> is 'done\(late\)'"):
        read_mission(path)


FOLLOWING = """<each name="n" in="p q">
    <objective name="x" activities="a"/>
    <parallel name="y"><objective name="v" activities="a"/><objective name="w">
      <objective name="s" activities="a" recover="t"/><objective name="t" activities="a"/>
    </objective></parallel>
    <objective name="z" activities="a"/>
  </each>
  <objective name="last" activities="a" failure="n"/>"""


def test_blocks_say_where_success_leads_but_for_children_of_parallel_blocks(tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    robot = '<robot name="r"><activity name="a"/></robot>'
    path.write_text(f'<mission name="m" xmlns="urn:mcpn:mission:1">{robot}{FOLLOWING}</mission>')
    written = core(read_mission(path), until="successors")
    assert {block.name: block.success for block in walk(written.blocks)} == {
        "n": "last",
        "x": "y",
        "y": "z",
        "z": "succeed",
        "last": "succeed",
        "v": None,
        "w": None,
        "s": "succeed",
        "t": "succeed",
    }
    assert [block.failure for block in written.blocks] == [None, "n"]


PAUSING = """<objective name="way" success="rest" failure="rest">
    <route on="failure" when="sunny" goto="fail"/>
    <on event="stop" pause="shelter"/>
    <objective name="go" activities="a"/>
    <parallel name="both"><objective name="x" activities="a"/></parallel>
    <objective name="kept" activities="a"><on event="stop" goto="go"/></objective>
  </objective>
  <objective name="shelter" activities="a" abort="rest" failure="way"/>
  <objective name="rest" activities="a"/>"""


def test_a_block_that_pauses_has_copies_of_the_sibling_behind_it_that_resume_what_is_stopped(
    tmp_path: Path,
) -> None:
    robot = '<robot name="r"><fact name="sunny"/><event name="stop"/><activity name="a"/></robot>'
    path = tmp_path / "m.xml"
    path.write_text(f'<mission name="m" xmlns="urn:mcpn:mission:1">{robot}{PAUSING}</mission>')
    written = core(read_mission(path), until="pauses")
    assert [(b.name, b.success, b.failure, b.resumes, b.abort) for b in written.blocks] == [
        ("way", "rest", "rest", None, None),
        ("shelter_at_go", None, "rest", "go", "rest"),
        ("shelter_at_both", None, "rest", "both", "rest"),
        ("rest", "succeed", None, None, None),
    ]  # in kept the event leads elsewhere
    routes = [[(r.on, r.when, r.goto) for r in block.routes] for block in written.blocks[1:3]]
    assert routes == [[("failure", ("sunny",), "fail without reason")]] * 2
    path.write_bytes(text := write_mission(written))
    assert read_mission(path) == written
    assert core(written) == core(read_mission(path)) == core(core(written))
    for old, new, found in (
        (b' core="true"', b"", "found the attribute copy on <objective>"),
        (b'resumes="go"', b'resumes="gone"', "resumes of shelter_at_go names gone; expected, with copy, an"),
        (b'resumes="go"', b'resumes="rest"', "resumes of shelter_at_go names rest; expected, with copy, an"),
        (b'resumes="go"', b'resumes="go" success="rest"', "shelter_at_go has success and resumes"),
        (b'pause="shelter"', b'pause="shelf"', "names shelf; expected one of shelter_at_go"),
    ):
        assert old in text
        path.write_bytes(text.replace(old, new, 1))
        with pytest.raises(InputError, match=found):
            read_mission(path)
    (way, _, *others) = written.blocks
    with pytest.raises(InputError, match="shelter has no copy that resumes go, and is none of its siblings"):
        core(replace(written, blocks=(way, *others)))


def test_missions_of_authors_resume_nothing() -> None:
    first = Objective(name="o", activities=("a",))
    again = Objective(name="s_x", activities=("a",), copy=("x",), resumes="o")
    with pytest.raises(InputError, match="s_x has resumes, though the mission is no core mission"):
        flatten(mission(robot((), activity("a", ())), first, again))


NAMED = """<objective name="go" retries="1">
    <route on="failure" reason="lost" when="sunny" goto="rest"/>
    <route on="failure" when="held" goto="rest"/>
    <objective name="way">
      <route on="failure" reason="cold" goto="fail"/>
      <objective name="x" activities="a" failures="lost cold"/>
      <objective name="y" activities="a" failures="lost cold"/>
    </objective>
  </objective>
  <objective name="rest" activities="a"/>"""


def test_all_that_a_failure_for_a_reason_leaves_says_where_it_leads(tmp_path: Path) -> None:
    robot = '<robot name="r"><fact name="sunny"/><fact name="held"/><activity name="a"/></robot>'
    path = tmp_path / "m.xml"
    path.write_text(f'<mission name="m" xmlns="urn:mcpn:mission:1">{robot}{NAMED}</mission>')
    written = core(read_mission(path), until="named_failures")
    said = {
        block.name: [(r.reason, " ".join(r.when), r.goto) for r in block.routes]
        for block in walk(written.blocks)
        if block.routes
    }
    leaves = [("lost", "", "fail lost"), ("cold", "", "fail cold")]
    assert said == {
        "go": [
            (None, "held", "rest"),
            ("lost", "sunny", "rest"),
            ("lost", "held", "rest"),
            ("lost", "", "fail"),
        ],
        "go_try1": [("lost", "sunny", "fail lost"), ("lost", "", "go_try2")],
        "go_try2": [("lost", "", "fail lost")],
        **{f"go_try{n}.way": [("lost", "", "fail lost"), ("cold", "", "fail")] for n in (1, 2)},
        **{f"go_try{n}.{leaf}": leaves for n in (1, 2) for leaf in "xy"},
    }
    path.write_bytes(text := write_mission(written))
    assert read_mission(path) == written
    assert core(written) == core(read_mission(path)) == core(core(written))
    path.write_bytes(text.replace(b'goto="fail lost"', b'goto="fail cold"', 1))
    with pytest.raises(InputError, match="leads to fail cold; expected one of"):
        read_mission(path)


GUARDED = """<objective name="take" activities="a" timeout="9" timeout_goto="put" failure="put">
    <route when="sunny" goto="put"/>
    <on event="stop" goto="put"/>
  </objective>
  <objective name="put" activities="a">
    <enter when="!sunny" else="rest"/>
    <enter when="held" else="fail"/>
  </objective>
  <objective name="rest" activities="a" success="succeed"/>
  <objective name="spare" activities="a" success="succeed"><enter when="held" else="rest"/></objective>"""


def test_guards_become_facts_by_which_what_leads_to_them_chooses(tmp_path: Path) -> None:
    facts = '<fact name="sunny"/><fact name="held"/>'
    robot = f'<robot name="r">{facts}<event name="stop"/><activity name="a"/></robot>'
    path = tmp_path / "m.xml"
    path.write_text(f'<mission name="m" xmlns="urn:mcpn:mission:1">{robot}{GUARDED}</mission>')
    written = core(read_mission(path), until="guards")
    take, *others = written.blocks
    cases = [("!sunny held", "put"), ("!sunny", "fail without reason")]
    assert [(r.on, " ".join(r.when), r.goto) for r in take.routes] == [
        ("success", "sunny", "rest"),  # while it is sunny no guard of put holds
        *(("success", when, goto) for when, goto in cases),
        *(("failure", when, goto) for when, goto in cases),
        *(("timeout", when, goto) for when, goto in cases),
    ]
    assert (take.success, take.failure, take.timeout_goto) == ("rest", "rest", "rest")
    assert [(" ".join(r.when), r.goto) for h in take.handlers for r in h.routes] == cases
    assert [h.goto for h in take.handlers] == ["rest"]
    assert [(block.name, len(block.guards)) for block in others] == [("put", 0), ("rest", 0), ("spare", 1)]
    path.write_bytes(text := write_mission(written))
    assert b'on="timeout"' in text
    assert read_mission(path) == written
    path.write_bytes(text.replace(b' core="true"', b""))
    with pytest.raises(InputError, match=r"on of <route> is 'timeout'"):
        read_mission(path)


@pytest.mark.parametrize(
    ("said", "found"),
    [
        ({"goto": "abort"}, "a route, though the mission is no core mission"),
        ({"pause": "b"}, "a route, though the mission is no core mission"),
    ],
)
def test_handlers_of_authors_have_no_routes(said: dict[str, str], found: str) -> None:
    routes = (FactRoute(when=("sunny",), goto="b"),)
    handler = Handler(event="stop", routes=routes, **said)  # type: ignore[arg-type]
    first = Objective(name="o", activities=("a",), handlers=(handler,))
    blocks = first, Objective(name="b", activities=("a",))
    of = replace(
        robot((), activity("a", ())),
        facts=(Fact(name="sunny"),),
        events=(DeclaredEvent(name="stop"),),
    )
    with pytest.raises(InputError, match=found):
        flatten(mission(of, *blocks))
    if "pause" in said:
        with pytest.raises(InputError, match="has a route that is none of a handler"):
            flatten(replace(mission(of, *blocks), core=True))


def test_a_mission_built_in_python_says_that_it_is_a_core_mission() -> None:
    built = mission(robot((), activity("a", ())), Objective(name="visit.o", activities=("a",)))
    assert [section.name for section in flatten(replace(built, core=True)).sections] == ["visit.o"]
    with pytest.raises(InputError, match=r"the name 'visit\.o' is not allowed"):
        flatten(built)
    copy = mission(robot((), activity("a", ())), Objective(name="o_try1", copy=("try1",), activities=("a",)))
    with pytest.raises(InputError, match="o_try1 has copy, though the mission is no core mission"):
        flatten(copy)
    other = mission(robot((), activity("a", ())), Objective(name="o", copy=("try1",), activities=("a",)))
    with pytest.raises(InputError, match="the copy try1 of o is not what its name ends in"):
        flatten(replace(other, core=True))


@pytest.mark.parametrize(
    ("said", "counted"),
    [
        ({}, ("all", "all", None)),
        ({"success_when": "any", "failure_when": "any"}, ("1", "any", None)),
        ({"failure_when": "2"}, ("all", "all", 2)),
        ({"impossible": "fails"}, ("all", "any", None)),
        ({"failure_when": "2", "impossible": "fails"}, ("all", "any", 2)),
        ({"success_when": "2", "impossible": "fails"}, ("2", "all", 2)),
        ({"success_when": "any", "failure_when": "any", "impossible": "fails"}, ("1", "any", 3)),
        ({"success_when": "2", "failure_when": "3", "impossible": "fails"}, ("2", "all", 2)),
        ({"success_when": "2", "failure_when": "1", "impossible": "fails"}, ("2", "all", 1)),
    ],
)
def test_what_ends_a_parallel_block_early_is_counted(
    said: dict[str, str], counted: tuple[str, str, int | None]
) -> None:
    branches = tuple(Objective(name=name, activities=("a",)) for name in "xyz")
    of = mission(robot((), activity("a", ())), Parallel(name="three", blocks=branches, **said))  # type: ignore[arg-type]
    (block,) = core(of, until="early_ends").blocks
    assert isinstance(block, Parallel)
    assert (block.success_when, block.failure_when, block.failing) == counted
    assert block.impossible == "waits"


def test_runs_of_one_block_are_looked_for_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Among siblings each asked all that follow it: 3,000 of them took a third of a minute."""
    asked = list[str]()

    def stem(block: Objective) -> str:
        asked.append(block.name)
        return block.name

    monkeypatch.setattr(Objective, "stem", property(stem))
    siblings = tuple(Objective(name=f"o{i}", activities=("a",)) for i in range(50))
    assert list(recovery_problems(siblings, ())) == []
    assert len(asked) <= 2 * len(siblings)
