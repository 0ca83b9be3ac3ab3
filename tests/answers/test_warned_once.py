"""What is suspicious is told once, however many rounds, tries, values, uses and copies it is so in."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from hypothesis import given, target

from mcpn.answers.verdicts.mission import check
from mcpn.drawing.compose import compose
from mcpn.editor.shown_states import findings
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission, walk
from mcpn.mission.static.warnings import static_warnings
from mcpn.mission.xml import read_mission
from mcpn.testing import missions
from tests.commands import mcpn
from tests.shares import returns_early

ONE = {
    "objectives": "objective",
    "blocks": "block",
    "their": "its",
    "them": "it",
    "run": "runs",
    "lead": "leads",
}


def without_copies(mission: Mission, message: str) -> tuple[str, ...]:
    """The words of a warning, names of copies as those of the blocks that drawn missions write.

    Drawn names of blocks have no ``_``; all that follows one tells copies apart.
    """
    texts = (mission.blocks, *(protocol.blocks for protocol in mission.protocols))
    blocks = {block.name for text in texts for block in walk(text)}
    assert not any("_" in name for name in blocks)
    message = re.sub(r" \(all [0-9]+\)| and [0-9]+ more", "", message)
    words = list[str]()
    for word in re.findall(r"[\w.]+", message):
        name = word.rpartition(".")[2].partition("_")[0]
        words.append(name if name in blocks else ONE.get(word, word))
    return tuple(dict.fromkeys(words))


def assert_once(mission: Mission, messages: Iterable[str]) -> None:
    several = {said: n for said, n in Counter(without_copies(mission, m) for m in messages).items() if n > 1}
    assert not several


@given(missions(recovers=5, pauses=5, events=2, aborts=3))
def test_no_two_warnings_differ_in_names_of_copies_alone(mission: Mission) -> None:
    of = compose(mission)
    contentions = of.usage.contentions
    static = [problem.message for problem in static_warnings(of.usage)]
    target(len(contentions) - sum("both need" in said for said in static))
    assert_once(mission, static)
    assert bool(contentions) == any("both need" in said for said in static)
    for each in contentions:  # each is told of: its resource by name
        assert any(said.endswith(f"both need {each.wanted}") for said in static)
    try:
        found = check(of, engine="explicit", max_states=5_000)
    except (LimitError, SemanticsError) as error:
        returns_early(type(error).__name__)
        return
    assert_once(mission, [problem.message for problem in found.warnings])


ROBOT = """<robot name="r">
<hardware name="sonar"/>
<hardware name="arm"/>
<software name="place"/>
<event name="rain"/>
<activity name="map" consumes="sonar"/>
<activity name="avoid" consumes="sonar"/>
<activity name="localise" produces="place" consumes="arm"/>
<activity name="grasp" consumes="arm place"/>
<activity name="wait"/>
</robot>
"""

BLOCK = """<parallel name="leg"{}>
<objective name="chart" activities="map"/>
<objective name="steer" activities="avoid"/>
</parallel>
"""

RIVALS = "avoid and map, both in {}, both need sonar"


def warned(folder: Path, blocks: str, protocols: str = "") -> list[str]:
    """The messages of a mission's warnings: those of an editor, in text and in JSON are the same."""
    path = folder / "mission.xml"
    spaces = 'xmlns="urn:mcpn:mission:1"'
    (folder / "protocols.xml").write_text(f"<protocols {spaces}>{protocols}</protocols>")
    text = '<import href="protocols.xml"/>' if protocols else ""
    path.write_text(f'<mission {spaces} name="m">{text}{ROBOT}{blocks}</mission>')
    found = json.loads(mcpn("check", str(path), "--json").stdout)["warnings"]
    told = [line.removeprefix("warning: ") for line in mcpn("check", str(path)).stderr.splitlines()]
    of = compose(read_mission(path))
    static = static_warnings(of.usage)
    assert [line for line in told if "both need" in line] == [str(p) for p in static if "both need" in str(p)]
    assert Counter(each["message"] for each in found)[static[0].message] == 1
    return [each["message"] for each in found]


def contended(messages: Iterable[str]) -> list[str]:
    return [message for message in messages if "sonar" in message]


def test_rounds_tries_and_values_are_one(tmp_path: Path) -> None:
    alone = [RIVALS.format("parallel block leg")]
    assert contended(warned(tmp_path, BLOCK.format(""))) == alone
    for several, number in ((' repeat="12"', 12), (' retries="2"', 3), (' repeat="2" retries="1"', 4)):
        told = contended(warned(tmp_path, BLOCK.format(several)))
        assert told == [RIVALS.format(f"parallel block leg (all {number})")]
    each = f'<each name="legs" in="north south">{BLOCK.format("")}</each>'
    assert contended(warned(tmp_path, each)) == [RIVALS.format("parallel block leg (all 2)")]


def test_uses_are_one_and_named(tmp_path: Path) -> None:
    text = '<protocol name="survey">' + BLOCK.format(' repeat="3"') + "</protocol>"
    uses = "".join(f'<use name="{name}" protocol="survey"/>' for name in ("north", "south"))
    assert contended(warned(tmp_path, uses, text)) == [
        RIVALS.format("parallel blocks north.leg (all 3), south.leg (all 3)")
    ]


def test_runs_of_a_block_that_recovers_are_one(tmp_path: Path) -> None:
    blocks = BLOCK.format(' recover="back" times="2"') + '<objective name="back" activities="wait"/>'
    assert contended(warned(tmp_path, blocks)) == [RIVALS.format("parallel block leg (all 3)")]
    aside = '<objective name="go" activities="wait" recover="leg" times="2"/>' + BLOCK.format("")
    assert contended(warned(tmp_path, aside)) == [RIVALS.format("parallel block leg (all 2)")]


def test_copies_of_what_is_run_in_a_pause_are_one(tmp_path: Path) -> None:
    inside = "".join(f'<objective name="{name}" activities="wait"/>' for name in "ab")
    blocks = f'<objective name="go"><on event="rain" pause="leg"/>{inside}</objective>' + BLOCK.format("")
    assert contended(warned(tmp_path, blocks)) == [RIVALS.format("parallel block leg (all 2)")]


def test_what_only_some_copies_say_is_told_of_those(tmp_path: Path) -> None:
    """In the first round grasping fails whatever is in service; the rounds behind it are never entered."""
    blocks = '<objective name="go" repeat="5"><objective name="take" activities="grasp"/></objective>'
    told = warned(tmp_path, blocks)
    assert "objective go_1.take can never succeed" in told
    assert "block go_2.take" not in " ".join(told)
    behind = [message for message in told if "can never be entered" in message]
    assert behind == [
        "objective go.take (all 5 but go_1.take) can never be entered: objective go_1.take can never succeed"
    ]


def test_futile_uses_are_one(tmp_path: Path) -> None:
    """In each use looking leads on only where it fails."""
    uses = '<use name="north" protocol="p"/><use name="south" protocol="p"/>'
    text = '<protocol name="p"><objective name="look" activities="wait" failure="succeed"/>'
    text += '<objective name="take" activities="grasp"/></protocol>'
    told = warned(tmp_path, uses, text)
    never = "objectives north.take, south.take can never succeed"
    assert never in told
    assert [message for message in told if "lead" in message] == [
        f"objectives north.look, south.look lead only to failure by their success: {never}"
    ]


def test_an_editor_tells_once_that_a_requirement_of_a_protocol_is_not_met(tmp_path: Path) -> None:
    text = '<protocol name="p"><requirement name="never" formula="A G !objective(look)"/>'
    text += '<objective name="look" activities="wait"/></protocol>'
    uses = '<use name="north" protocol="p" repeat="2"/><use name="south" protocol="p"/>'
    assert warned(tmp_path, uses, text)
    problems = findings(tmp_path / "mission.xml")["problems"]
    told = [each["message"] for each in problems if "requirement" in each["message"]]
    assert told == ["requirements north.never (all 2), south.never are not met"]
