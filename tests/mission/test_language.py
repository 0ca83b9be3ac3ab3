"""The mission language: what is written is read back, and means what it says."""

from __future__ import annotations

import re
from collections.abc import Generator, Iterator
from itertools import chain, product
from pathlib import Path
from random import Random

import pytest
from hypothesis import Phase, find, given, settings
from hypothesis import strategies as st

from mcpn.errors import InputError, LimitError
from mcpn.mission.core.flattening import flatten
from mcpn.mission.core.objectives_graph import ParallelSection
from mcpn.mission.model import (
    FAIL,
    SUCCEED,
    Block,
    Each,
    Mission,
    Objective,
    Parallel,
    Recursive,
    Use,
)
from mcpn.mission.static.resource_use import Usage
from mcpn.mission.static.warnings import find_warnings
from mcpn.mission.validate import find_errors
from mcpn.mission.writer import save_mission
from mcpn.mission.xml import read_mission
from mcpn.testing import missions
from tests.draws import fewer

HEAD = '<mission name="m" xmlns="urn:mcpn:mission:1">'
ROBOT = (
    '<robot name="r"><hardware name="H"/><software name="S"/>'
    '<activity name="driver" produces="S" consumes="H"/><activity name="go" consumes="S"/>'
    '<activity name="look"/></robot>'
)


def mission(tmp_path: Path, text: str) -> Mission:
    (tmp_path / "m.xml").write_text(HEAD + ROBOT + text + "</mission>")
    return read_mission(tmp_path / "m.xml")


@given(missions(text=True, max_events=2))
def test_reading_what_was_written_gives_the_same_mission(
    tmp_path_factory: pytest.TempPathFactory, written: Mission
) -> None:
    path = tmp_path_factory.mktemp("round") / "mission.xml"
    save_mission(written, path)
    assert read_mission(path) == written


@given(missions(text=True, max_events=2))
def test_generated_missions_are_valid(generated: Mission) -> None:
    assert find_errors(generated) == []


@fewer(0.5)
@given(missions(max_hardware=4, max_sections=5, disjoint_branches=True))
def test_disjoint_branches_do_not_contend(generated: Mission) -> None:
    graph = flatten(generated)
    assert Usage(generated, graph).contentions == ()
    assert len(list(graph.walk())) <= 5
    assert find_errors(generated) == []


def test_disjoint_missions_still_run_things_together() -> None:
    def together(mission: Mission) -> bool:
        sections = flatten(mission).sections
        return any(isinstance(s, ParallelSection) and len(s.branches) > 1 for s in sections) and any(
            alternative.consumes for activity in mission.activities for alternative in activity.alternatives
        )

    unshrunk = settings(phases=[Phase.generate], max_examples=500, database=None)  # under any profile
    assert together(find(missions(disjoint_branches=True), together, settings=unshrunk))


@given(missions(allow_shared_activities=False))
def test_unshared_activities_are_started_by_one_objective(generated: Mission) -> None:
    started = [activity for section in flatten(generated).walk() for activity in section.activities]
    assert len(started) == len(set(started))
    assert find_errors(generated) == []


def test_ulysse_is_split_as_its_three_actors_would(ulysse: Mission) -> None:
    # The paper, section 8: 11 activities, 3 hardware and 4 software resources, 7 elementary objectives.
    assert [len(part) for part in (ulysse.activities, ulysse.hardware, ulysse.software)] == [11, 3, 4]
    graph = flatten(ulysse)
    assert len(list(graph.walk())) == 7
    assert {s.source.file.rsplit("/", 1)[-1] for s in graph.walk() if s.source} == {"protocols.xml"}
    assert find_warnings(ulysse) == []


def test_ulysse_objectives_graph(ulysse: Mission) -> None:
    graph = flatten(ulysse)
    routes = {s.name: (s.success, s.failure) for s in graph.sections}
    assert graph.entry == "coral_head.manual_moving"
    assert routes == {
        "coral_head.manual_moving": ("coral_head.isopheric_observation", "transect.diving"),
        "coral_head.isopheric_observation": ("transect.diving", "transect.diving"),
        "transect.diving": ("transect.census", "transect.going_up"),
        "transect.census": ("transect.going_up", "transect.going_up"),
        "transect.going_up": (SUCCEED, FAIL),
    }
    census = graph.section("transect.census")
    assert isinstance(census, ParallelSection)
    assert [(b.name, b.mandatory) for b in census.branches] == [
        ("transect.filming", True),
        ("transect.advancing", True),
        ("transect.measuring_temperature", True),
    ]


def test_parameters_of_a_use_override_those_of_its_protocol(ulysse: Mission) -> None:
    diving = next(s for s in flatten(ulysse).walk() if s.name == "transect.diving")
    assert {(p.name, p.value, p.unit) for p in diving.parameters} == {
        ("depth", "10", "m"),
        ("length", "50", "m"),
    }


def test_inner_parameters_win_and_those_of_protocols_are_defaults(tmp_path: Path) -> None:
    inner = (
        '<protocol name="inner"><parameter name="d" value="inner"/>'
        '<objective name="x" activities="go"><parameter name="own" value="x"/></objective></protocol>'
    )
    outer = (
        '<protocol name="outer"><parameter name="d" value="outer"/><parameter name="e" value="outer"/>'
        '<objective name="r"><parameter name="d" value="r"/>'
        '<objective name="y" activities="go"><parameter name="d" value="y"/></objective>'
        '<objective name="z" activities="go"/></objective>'
        '<objective name="w" activities="go"/><use name="i" protocol="inner"/>'
        '<use name="j" protocol="inner"><parameter name="d" value="j"/></use></protocol>'
    )
    uses = (
        '<objective name="all"><parameter name="d" value="all"/><parameter name="f" value="all"/>'
        '<use name="u" protocol="outer"/>'
        '<use name="v" protocol="outer"><parameter name="d" value="v"/></use></objective>'
    )
    found = mission(tmp_path, f"<protocols>{inner}{outer}</protocols>{uses}")
    told = {s.name: {p.name: p.value for p in s.parameters} for s in flatten(found).walk()}
    everywhere = {"e": "outer", "f": "all"}
    assert told == {
        "u.y": {"d": "y", **everywhere},
        "u.z": {"d": "r", **everywhere},
        "u.w": {"d": "all", **everywhere},  # outer says what counts where nobody else does
        "u.i.x": {"d": "all", "own": "x", **everywhere},
        "u.j.x": {"d": "j", "own": "x", **everywhere},
        "v.y": {"d": "y", **everywhere},
        "v.z": {"d": "r", **everywhere},
        "v.w": {"d": "v", **everywhere},
        "v.i.x": {"d": "v", "own": "x", **everywhere},
        "v.j.x": {"d": "j", "own": "x", **everywhere},
    }


def test_the_objectives_graph_as_networkx(ulysse: Mission) -> None:
    drawn = flatten(ulysse).to_networkx()
    kinds = [drawn.nodes[node]["kind"] for node in drawn]
    assert (kinds.count("objective"), kinds.count("parallel")) == (7, 1)
    assert drawn.has_edge("transect.going_up", SUCCEED)
    census = drawn["transect.census"].items()
    assert {v for v, edges in census if any(e["outcome"] == "branch" for e in edges.values())} == {
        "transect.filming",
        "transect.advancing",
        "transect.measuring_temperature",
    }


def test_uses_nest_and_routes_may_go_back(tmp_path: Path) -> None:
    found = mission(
        tmp_path,
        '<protocols><protocol name="inner"><objective name="x" activities="go" failure="x"/></protocol>'
        '<protocol name="outer"><use name="i" protocol="inner"/><objective name="y" activities="look"/>'
        "</protocol></protocols>"
        '<use name="o" protocol="outer" failure="again"/><objective name="z" activities="look"/>'
        '<objective name="again" activities="go" success="o"/>',
    )
    routes = {s.name: (s.success, s.failure) for s in flatten(found).sections}
    assert routes == {
        "o.i.x": ("o.y", "o.i.x"),
        "o.y": ("z", "again"),
        "z": ("again", FAIL),
        "again": ("o.i.x", FAIL),
    }


def test_imports_are_merged_once(tmp_path: Path) -> None:
    (tmp_path / "robots").mkdir()
    (tmp_path / "robots" / "r.xml").write_text(ROBOT.replace("<robot ", '<robot xmlns="urn:mcpn:mission:1" '))
    text = '<import href="robots/r.xml"/><import href="./robots/r.xml"/><objective name="o" activities="go"/>'
    (tmp_path / "m.xml").write_text(f"{HEAD}{text}</mission>")
    found = read_mission(tmp_path / "m.xml")
    assert len(found.robots) == 1
    assert found.hardware[0].source is not None
    assert found.hardware[0].source.file.endswith("r.xml")


def test_a_wider_import_root_is_an_option(tmp_path: Path) -> None:
    (tmp_path / "r.xml").write_text(ROBOT.replace("<robot ", '<robot xmlns="urn:mcpn:mission:1" '))
    (tmp_path / "in").mkdir()
    text = '<import href="../r.xml"/><objective name="o" activities="go"/>'
    (tmp_path / "in" / "m.xml").write_text(f"{HEAD}{text}</mission>")
    assert read_mission(tmp_path / "in" / "m.xml", import_root=tmp_path).hardware[0].name == "H"


def test_warnings_name_their_lines(tmp_path: Path) -> None:
    found = mission(
        tmp_path,
        '\n<robot name="q"><hardware name="spare"/>\n<activity name="idle"/>\n'
        '<activity name="two">\n<alternative name="always"/>\n<alternative name="never" consumes="H"/>'
        "</activity></robot>\n"
        '<protocols><protocol name="unused"><objective name="x" activities="look"/></protocol></protocols>\n'
        '<objective name="first" activities="two go" success="succeed"/>\n'
        '<objective name="lost" activities="go"/>',
    )
    told = [(p.source.line, p.message) for p in find_warnings(found) if p.source]
    assert told == [
        (1, "activity look is never started"),
        (2, "resource spare is never used"),
        (3, "activity idle is never started"),
        (6, "alternative never is never tried: always is always possible"),
        (7, "protocol unused is never used"),
        (9, "objective lost can never be entered: no route reaches it"),
    ]


@given(missions(), st.data())
def test_flattening_keeps_every_reachable_objective_once(generated: Mission, data: st.DataObject) -> None:
    names = [section.name for section in flatten(generated).walk()]
    assert len(names) == len(set(names))
    assert names


def suffixes(block: Block, before: str) -> Iterator[list[str]]:
    """By round, the ends of the names of its tries."""
    for number in [""] if block.repeat is None else [f"_{n + 1}" for n in range(block.repeat)]:
        tries = [f"_try{n + 1}" for n in range(block.retries + 1)] if block.retries else [""]
        yield [before + number + attempt for attempt in tries]


def play(mission: Mission, block: Block, prefix: str = "", before: str = "") -> Generator[str, bool, bool]:
    """Does a block as its text says, asks for the outcome of each objective and parallel block, by name."""
    well = True
    for tries in suffixes(block, before):
        for suffix in tries:
            well = yield from play_once(mission, block, prefix, suffix)
            if well:
                break
        if not well:
            break
    return well


def play_once(mission: Mission, block: Block, prefix: str, suffix: str) -> Generator[str, bool, bool]:
    name = prefix + block.name + suffix
    inside = f"{name}." if suffix else prefix
    if isinstance(block, Objective | Parallel):
        return (yield name)
    if isinstance(block, Use):
        (protocol,) = [p for p in mission.protocols if p.name == block.protocol]
        return (yield from play_series(mission, protocol.blocks, f"{name}.", ""))
    if isinstance(block, Recursive):
        return (yield from play_series(mission, block.blocks, inside, ""))
    for value in block.values:
        if not (yield from play_series(mission, block.blocks, inside, f"_{value}")):
            return False
    return True


def play_series(
    mission: Mission, blocks: tuple[Block, ...], prefix: str, suffix: str
) -> Generator[str, bool, bool]:
    at = 0
    while True:
        well = yield from play(mission, blocks[at], prefix, suffix)
        following = blocks[at + 1].name if at + 1 < len(blocks) else SUCCEED
        route = (blocks[at].success or following) if well else (blocks[at].failure or FAIL)
        if route in (SUCCEED, FAIL):
            return route == SUCCEED
        at = next(i for i, block in enumerate(blocks) if block.name == route)


@given(missions(max_sections=40), st.randoms(use_true_random=False))
def test_the_objectives_graph_is_run_as_the_text_says(generated: Mission, random: Random) -> None:
    graph = flatten(generated)
    text = play_series(generated, generated.blocks, "", "")
    at, asked = graph.entry, next(text)
    for _ in range(60):
        assert at == asked
        section = graph.section(at)
        well = random.random() < 0.6
        at = section.success if well else section.failure
        ended = None
        try:
            asked = text.send(well)
        except StopIteration as end:
            ended = end.value
        if ended is not None:
            assert at == (SUCCEED if ended else FAIL)
            return


def written(mission: Mission, blocks: tuple[Block, ...], prefix: str = "", before: str = "") -> Iterator[str]:
    """Qualified names of all elementary objectives as they stand in the text, routes left aside."""
    for block in blocks:
        for suffix in chain.from_iterable(suffixes(block, before)):
            name = prefix + block.name + suffix
            inside = f"{name}." if suffix else prefix
            if isinstance(block, Objective):
                yield name
            elif isinstance(block, Use):
                (protocol,) = [p for p in mission.protocols if p.name == block.protocol]
                yield from written(mission, protocol.blocks, f"{name}.")
            elif isinstance(block, Each):
                for value in block.values:
                    yield from written(mission, block.blocks, inside, f"_{value}")
            else:
                yield from written(mission, block.blocks, inside)


@given(missions())
def test_an_objective_is_in_the_graph_or_in_a_warning(generated: Mission) -> None:
    told = " ".join(p.message for p in find_warnings(generated) if "never be entered" in p.message)
    told = re.sub(r"objectives?|can never be entered|no route reaches|[:,]", " ", told)
    graph, every = flatten(generated), list(written(generated, generated.blocks))
    reached = {section.name for section in graph.walk()}
    assert sorted([*reached, *(section.name for section in graph.never_entered())]) == sorted(every)
    for name in every:
        ways = [name, *(plain for plain in plains(name) if f"{plain} (all" in told)]
        assert (name in reached) or "more" in told or any(way in told.split() for way in ways)
    assert bool(told) == (len(reached) < len(every))


def plains(name: str) -> Iterator[str]:
    """What a name may be without the numbers and values of copies."""
    segments = [
        [part, *(part[:at] for at in range(len(part)) if part[at] == "_")] for part in name.split(".")
    ]
    return (".".join(chosen) for chosen in product(*segments))


def test_deeply_nested_blocks_are_flattened(tmp_path: Path) -> None:
    depth = 50
    opening = "".join(f'<objective name="r{i}">' for i in range(depth))
    found = mission(tmp_path, f'{opening}<objective name="o" activities="go"/>{"</objective>" * depth}')
    assert isinstance(found.blocks[0], Recursive)
    assert [s.name for s in flatten(found).walk()] == ["o"]


def test_rounds_and_tries_are_written_out(tmp_path: Path) -> None:
    found = mission(
        tmp_path,
        '<protocols><protocol name="visit"><parameter name="room" value="none"/>\n'
        '<objective name="travel" activities="go" retries="1"/><objective name="look" activities="look"/>'
        "</protocol></protocols>\n"
        '<each name="room" in="12 14" failure="home"><use name="visit" protocol="visit"/></each>\n'
        '<objective name="home" activities="go" repeat="2"/>',
    )
    graph = flatten(found)
    assert {s.name: (s.success, s.failure) for s in graph.sections} == {
        "visit_12.travel_try1": ("visit_12.look", "visit_12.travel_try2"),
        "visit_12.travel_try2": ("visit_12.look", "home_1"),
        "visit_12.look": ("visit_14.travel_try1", "home_1"),
        "visit_14.travel_try1": ("visit_14.look", "visit_14.travel_try2"),
        "visit_14.travel_try2": ("visit_14.look", "home_1"),
        "visit_14.look": ("home_1", "home_1"),
        "home_1": ("home_2", FAIL),
        "home_2": (SUCCEED, FAIL),
    }
    told = {s.name: {p.name: p.value for p in s.parameters} for s in graph.walk()}
    assert told["visit_12.travel_try2"] == told["visit_12.look"] == {"room": "12"}
    assert told["visit_14.travel_try1"] == {"room": "14"}
    assert [told[f"home_{n}"] for n in (1, 2)] == [{"round": "1"}, {"round": "2"}]
    lines = {s.name.rpartition(".")[2]: s.source.line for s in graph.walk() if s.source}
    assert (lines["travel_try2"], lines["look"], lines["home_2"]) == (2, 2, 4)


def test_values_of_rounds_are_parameters_like_those_that_a_use_states(tmp_path: Path) -> None:
    found = mission(
        tmp_path,
        '<protocols><protocol name="inner"><parameter name="place" value="inner"/>'
        '<objective name="x" activities="look"/></protocol>'
        '<protocol name="outer"><use name="i" protocol="inner"/></protocol></protocols>'
        '<each name="spots" parameter="place" in="a">'
        '<use name="plain" protocol="inner"/><use name="deep" protocol="outer"/>'
        '<use name="said" protocol="inner"><parameter name="place" value="said"/></use>'
        '<objective name="own" activities="look"><parameter name="place" value="own"/></objective></each>',
    )
    told = {s.name: {p.name: p.value for p in s.parameters} for s in flatten(found).walk()}
    assert told == {
        "plain_a.x": {"place": "a"},
        "deep_a.i.x": {"place": "a"},
        "said_a.x": {"place": "said"},
        "own_a": {"place": "own"},
    }


def test_handlers_are_ways_out_of_what_they_stand_around(tmp_path: Path) -> None:
    text = (
        '<robot name="q"><event name="leak"/><event name="recall"/><event name="storm"/></robot>'
        '<on event="recall" goto="home" once="true"/><on event="leak" goto="fail"/>'
        '<objective name="survey" failure="home"><on event="leak" goto="home"/>'
        '<objective name="dive" activities="go"/>'
        '<parallel name="both"><on event="leak" goto="dive"/>'
        '<objective name="x" activities="look"><on event="leak" goto="succeed"/></objective>'
        '<objective name="y" activities="go"/></parallel></objective>'
        '<objective name="home" activities="go"/>'
    )
    found = mission(tmp_path, text)
    graph = flatten(found)
    routes = {s.name: [(i.event, i.target, i.once) for i in s.interruptions] for s in graph.all_sections()}
    recall, leak = ("recall", "home", "recall"), ("leak", FAIL, None)
    assert routes == {
        "dive": [("leak", "home", None), recall],
        "both": [("leak", "dive", None), recall],
        "x": [("leak", SUCCEED, None)],
        "y": [],
        "home": [recall, leak],
    }
    told = [(p.source and p.source.line, p.message) for p in find_warnings(found)]
    assert (1, "event storm interrupts nothing") in told


def test_rounds_are_interrupted_as_one(tmp_path: Path) -> None:
    found = mission(
        tmp_path,
        '<robot name="q"><event name="stop"/></robot>'
        '<each name="room" in="a b"><on event="stop" goto="home"/>'
        '<objective name="visit" activities="go" retries="1"><on event="stop" goto="rest" once="true"/>'
        '</objective><objective name="rest" activities="look"/></each>'
        '<objective name="home" activities="go"/>',
    )
    graph = flatten(found)
    assert graph.once() == ["visit.stop"]
    targets = {s.name: [(i.target, i.once) for i in s.interruptions] for s in graph.sections}
    assert targets == {
        "visit_a_try1": [("rest_a", "visit.stop"), ("home", None)],
        "visit_a_try2": [("rest_a", "visit.stop"), ("home", None)],
        "rest_a": [("home", None)],
        "visit_b_try1": [("rest_b", "visit.stop"), ("home", None)],
        "visit_b_try2": [("rest_b", "visit.stop"), ("home", None)],
        "rest_b": [("home", None)],
        "home": [],
    }


VALUES = " ".join(f"v{number}" for number in range(50_001))


@pytest.mark.parametrize(
    "block",
    [
        '<objective name="r" repeat="2"><objective name="o" activities="go" repeat="100000"/></objective>',
        '<objective name="o" activities="go" retries="100000"/>',
        f'<each name="e" in="{VALUES}"><objective name="o" activities="go" repeat="2"/></each>',
        '<objective name="o" activities="go" recover="b" times="60000"/>'
        '<objective name="b"><objective name="p" activities="go" recover="q" times="2"/>'
        '<objective name="q" activities="go"/></objective>',
    ],
)
def test_more_copies_than_there_may_be_are_refused_before_one_is_made(
    tmp_path: Path, block: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = mission(tmp_path, block)
    monkeypatch.setattr("mcpn.mission.passes.PASSES", None)
    with pytest.raises(LimitError, match=r"m.*\.xml:\d+: more than 100000 objectives after expansion"):
        flatten(found)


@pytest.mark.parametrize("copies", ["repeat", "retries"])
@given(most=st.integers(2, 6), more=st.integers(0, 2), alone=st.integers(0, 2))
def test_there_may_be_as_many_objectives_as_the_limit_says(
    tmp_path_factory: pytest.TempPathFactory, copies: str, most: int, more: int, alone: int
) -> None:
    """One more is refused; those beside the copies count, too."""
    number = max(2, most - alone + more)
    blocks = "".join(f'<objective name="o{i}" activities="go"/>' for i in range(alone))
    blocks += f'<objective name="o" activities="go" {copies}="{number - (copies == "retries")}"/>'
    found = mission(tmp_path_factory.mktemp("limit"), blocks)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("mcpn.mission.rewriting.limits.MAX_OBJECTIVES", most)
        if number + alone > most:
            patch.setattr("mcpn.mission.passes.PASSES", None)  # it is refused before a copy is made
            with pytest.raises(LimitError, match=f"more than {most} objectives"):
                flatten(found)
        else:
            assert len(list(flatten(found).walk())) == number + alone


def test_an_alternative_consumes_no_more_than_it_may(tmp_path: Path) -> None:
    def text(number: int) -> str:
        names = [f"h{i}" for i in range(number)]
        declared = "".join(f'<hardware name="{name}"/>' for name in names)
        robot = f'<robot name="r">{declared}\n<activity name="a" consumes="{" ".join(names)}"/></robot>'
        block = '<objective name="o" activities="a"/>'
        return f'<mission name="m" xmlns="urn:mcpn:mission:1">{robot}{block}</mission>'

    (tmp_path / "m.xml").write_text(text(1000))
    read_mission(tmp_path / "m.xml")
    (tmp_path / "m.xml").write_text(text(1001))
    with pytest.raises(InputError, match=r"m\.xml:2: .* consumes 1001 resources, expected at most 1000"):
        read_mission(tmp_path / "m.xml")
