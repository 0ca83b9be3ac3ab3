"""One mission or net with its spaces: each is built once, whoever asks, and what nets have not is said."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any
from unittest.mock import patch

import pytest
from hypothesis import given
from hypothesis import strategies as st

import mcpn
from mcpn.answers.spaces_by_engine import MissionSpaces
from mcpn.cli.line import run
from mcpn.drawing.compose import compose
from mcpn.errors import InputError, LimitError, McpnError, SemanticsError
from mcpn.mission.model import Mission
from mcpn.report.notebook import show
from mcpn.spaces.engine_names import SPACE_ENGINES, Engine
from mcpn.spaces.engines import Choice
from mcpn.testing import missions
from tests.conftest import ROOT, ULYSSE
from tests.draws import fewer

BUILT = {
    "composite": "mcpn.composite.composing.composite_space",
    "listing": "mcpn.spaces.stable.nearest_nonconfluence.proved",
    "diagram": "mcpn.spaces.registry.reaching",
    "markings": "mcpn.spaces.registry.explore",
}
"""What builds a space of the whole mission."""
NET = """pl a (1)
tr t a -> b
tr u b -> a
"""


@pytest.fixture
def built() -> Iterator[Counter[str]]:
    """How often each space of a whole mission is built; one in which hardware may die counts apart."""
    counts = Counter[str]()

    def counting(name: str, build: Callable[..., Any]) -> Callable[..., Any]:
        def counted(of: Any, **more: Any) -> Any:
            counts[f"{name}, may die" if more.get("may_die") else name] += 1
            return build(of, **more)

        return counted

    from mcpn.composite import composing
    from mcpn.spaces import registry as spaces
    from mcpn.spaces.stable import nearest_nonconfluence

    homes = {"composite": composing, "listing": nearest_nonconfluence, "diagram": spaces, "markings": spaces}
    with ExitStack() as stack:
        for name, target in BUILT.items():
            original = getattr(homes[name], target.rpartition(".")[2])
            stack.enter_context(patch(target, counting(name, original)))
        yield counts


@pytest.mark.parametrize(
    ("command", "once"),
    [
        ("check", {"composite"}),
        ("ask", {"composite"}),
        ("causes", {"composite", "composite, may die"}),
        ("report", {"composite", "composite, may die"}),
    ],
)
def test_one_command_builds_the_composite_once(
    command: str, once: set[str], built: Counter[str], tmp_path: Path
) -> None:
    more = {"report": ["-o", str(tmp_path / "page.html")], "ask": ["EF success", "AG EF (success | failure)"]}
    assert run([command, str(ULYSSE), *more.get(command, []), "--engine", "local"]) == 0
    assert built == dict.fromkeys(once, 1)


def test_a_report_lists_the_stable_states_once(built: Counter[str], tmp_path: Path) -> None:
    """Its verdicts and causes share them; its controller needs the composite besides."""
    assert run(["report", str(ULYSSE), "-o", str(tmp_path / "page.html")]) == 0
    assert built["listing"] == 1
    assert built["composite"] == 1


@pytest.mark.parametrize(
    ("engine", "once"),
    [("explicit", {"listing": 1}), ("local", {"composite": 1, "composite, may die": 1})],
)
def test_questions_share_what_one_has_built(
    engine: Engine, once: dict[str, int], built: Counter[str]
) -> None:
    study = mcpn.open(ULYSSE)
    for _ in range(2):
        assert study.verdicts(engine=engine).passed
        assert study.ctl("AG EF (success | failure)", engine=engine).holds
        assert len(study.causes(engine=engine).mission.cut_sets) == 2
        assert study.alternatives(engine=engine).everything.count() == 260
    assert built == once


def test_an_engine_that_gave_up_is_not_asked_again(built: Counter[str]) -> None:
    study = mcpn.open(ULYSSE)
    for _ in range(2):
        assert study.verdicts(max_states=100).choice.engine == "local"
        assert study.causes(max_states=100).choice.engine == "local"
    assert built == {"listing": 1, "composite": 1, "composite, may die": 1}


def test_the_same_listing_gives_integers_and_arrays() -> None:
    spaces = MissionSpaces(compose(mcpn.read_mission(ULYSSE)))
    low, high = (Choice("explicit", max_states=most) for most in (1000, 2000))
    few, _ = spaces.stable(low)
    arrays = [spaces.space(by, "alternatives") for by in (high, low)]
    assert [space.everything.count() for space in (few, *arrays)] == [260] * 3
    assert arrays[0] is arrays[1]


def test_what_was_listed_within_a_limit_serves_every_higher_one(built: Counter[str]) -> None:
    spaces = MissionSpaces(compose(mcpn.read_mission(ULYSSE)))
    for limit in (259, 259, 260, 1000):
        if limit == 259:
            with pytest.raises(LimitError, match="259"):
                spaces.bound(max_states=limit).listed()
        else:
            assert spaces.bound(max_states=limit).listed().states == 260
    assert built == {"listing": 2}
    with pytest.raises(LimitError, match="100"):  # and no lower one
        spaces.bound(max_states=100).listed()


@pytest.mark.parametrize("engine", SPACE_ENGINES)
@fewer(0.2)
@given(mission=missions(), order=st.permutations(["check", "ctl", "causes", "alternatives"]))
def test_a_study_answers_as_fresh_spaces_do(engine: Engine, mission: Mission, order: list[str]) -> None:
    """Whatever was asked before; an error too is the same error again."""
    asked: dict[str, Callable[[mcpn.Study], object]] = {
        "check": lambda study: {name: v.holds for name, v in study.verdicts(engine=engine).verdicts.items()},
        "ctl": lambda study: study.ctl("AG EF (success | failure)", engine=engine).holds,
        "causes": lambda study: study.causes(engine=engine).mission.moments,
        "alternatives": lambda study: study.alternatives(engine=engine).everything.count(),
    }

    def answer(name: str, study: mcpn.Study) -> object:
        try:
            return asked[name](study)
        except SemanticsError as error:
            return type(error), str(error), error.runs
        except McpnError as error:
            return type(error), str(error)

    study = mcpn.Study(mission)
    for name in (*order, *order):
        assert answer(name, study) == answer(name, mcpn.Study(mission)), name


@pytest.mark.parametrize(
    "ask",
    [
        lambda study: study.causes(),
        lambda study: study.controller(),
        lambda study: study.alternatives(),
        lambda study: study.findings(),
        lambda study: study.verdicts(),
        lambda study: study.mission_net,
        lambda study: study.picture("mission"),
        lambda study: study.picture("net", "a"),
    ],
)
def test_what_is_asked_of_missions_alone_is_an_error_of_a_net(
    ask: Callable[[mcpn.Study], object], tmp_path: Path
) -> None:
    (tmp_path / "ring.net").write_text(NET)
    with pytest.raises(InputError, match="found a net, expected a mission") as told:
        ask(mcpn.open(tmp_path / "ring.net"))
    assert told.value.problems[0].source is not None
    assert told.value.problems[0].source.file == str(tmp_path / "ring.net")


@pytest.mark.parametrize("suffix", [".net", ".pnml", ".json"])
def test_a_net_answers_what_has_a_meaning_for_it(suffix: str, tmp_path: Path) -> None:
    (tmp_path / "ring.net").write_text(NET)
    assert run(["convert", str(tmp_path / "ring.net"), str(tmp_path / f"other{suffix}")]) == 0
    study = mcpn.open(str(tmp_path / f"other{suffix}"))
    assert study.is_net
    behaviour = study.behaviour()
    assert behaviour == study.check()
    assert (behaviour.states, behaviour.reversible, behaviour.deadlock_free) == (2, True, True)
    assert study.states().states == 2
    assert study.ctl("AG EF b").holds
    assert study.structure().conservative
    with pytest.raises(InputError, match="no priorities"):
        study.ctl("EF b", on="alternatives")
    with pytest.raises(InputError, match="composition"):
        study.ctl("EF b", engine="local")
    assert repr(study).startswith("<study of the net ")


@pytest.mark.parametrize("command", ["causes", "controller -o {out}", "alternatives", "report -o {out}.html"])
def test_the_command_line_says_that_a_net_is_no_mission(
    command: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "ring.net").write_text(NET)
    name, *options = command.format(out=tmp_path / "out").split()
    assert run([name, str(tmp_path / "ring.net"), *options]) == 2
    assert f"{tmp_path / 'ring.net'}: found a net, expected a mission" in capfd.readouterr().err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["ring.net"]


def test_a_report_is_the_page_that_the_command_writes(tmp_path: Path) -> None:
    mcpn.open(ROOT / "experiments" / "courier" / "mission.xml").report(tmp_path / "page.html")
    assert "<!doctype html>" in (tmp_path / "page.html").read_text(encoding="utf-8")[:100]


def test_a_check_keeps_its_spaces() -> None:
    study = mcpn.open(ULYSSE)
    found = study.verdicts()
    assert found.spaces is study.spaces
    assert found.alternatives is study.spaces.stable(Choice("explicit"))[0]
    assert show(found, "html")
