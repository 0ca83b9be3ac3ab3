"""Another checker of claims by sections, in C++, written from the page alone, says what sectioncheck says."""

from __future__ import annotations

import copy
import json
import random
import re
import subprocess
import zipfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import event, given

from experiments.faults import stated_mutants
from experiments.faults.section_mutants import CLAIMED, MOST, core_of, mutated
from mcpn.certificates import certcheck
from mcpn.certificates.core_entry import core_entry
from mcpn.certificates.sections import sectioncheck
from mcpn.drawing.compose import compose
from mcpn.errors import McpnError
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.testing import elements, missions
from tests.certificates.programs import compiled
from tests.certificates.test_second_checker import changed, of_the_other, paths_in
from tests.conftest import ULYSSE
from tests.draws import campaign, composed, fewer
from tests.shares import returns_early

DRAWN = (
    missions(max_hardware=3, max_objectives=2, max_sections=5)
    | missions(max_hardware=2, max_objectives=3, max_sections=4, events=2, timeouts=1)
    | missions(max_hardware=2, max_objectives=2, max_sections=4, early=1)
    | elements.INTERRUPTED
    | elements.PAUSING
    | elements.CRASHING
    | elements.COMMON_CAUSES
    | elements.IN_TIME
)
Report = list[tuple[str, str]]


@pytest.fixture(scope="module")
def checker(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program."""
    return compiled("section_checker", tmp_path_factory)


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where certificates are written, one after the other."""
    return tmp_path_factory.mktemp("certificate") / "certificate"


def of_both(
    checker: Path, file: Path, core: Any, document: Any = CLAIMED
) -> tuple[Report | str, Report | str]:
    """What sectioncheck and the program say of claims on a core mission."""
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("core.json", json.dumps(core))
        archive.writestr("sections.json", json.dumps(document))
    try:
        first: Report | str = [(how, key) for how, key, _ in sectioncheck.checked(str(file), most=MOST)]
    except certcheck.Malformed:
        first = "malformed"
    except certcheck.Limit as limit:
        if "states" in str(limit):
            return "large", "large"
        first = [("not checked", each["key"]) for each in document["claims"]]
    return first, of_the_other(checker, file)


def kinds_of(report: Report | str) -> set[str]:
    return {report} if isinstance(report, str) else {how for how, _ in report}


def test_both_prove_the_same_of_a_row_of_sites(checker: Path, file: Path) -> None:
    expected, found = of_both(checker, file, core_of(60))
    assert found == expected
    assert {each[1] for each in found if each[0] == "proved"} == {
        "can_always_end True",
        "can_always_end_safely True",
        "can_always_go_on True",
        "can_be_aborted False",
        "can_fail False",
        "can_succeed True",
    }
    # A site in the row, the last one and "home". With wheels and a receiver, of three kinds, a site drives or
    # has been refused; with both receivers it drives by either. In five other kinds of status it is refused.
    assert counted(checker, file) == [61, 3, 2 * (2 * 3 + 1 + 5) + 1]


def counted(checker: Path, file: Path) -> list[int]:
    """How many sections, types and states the program counts."""
    run = subprocess.run([checker, file], check=False, capture_output=True, text=True, timeout=60)
    return [int(each) for each in re.findall(r"\d+", run.stderr)]


WORKED = Path(__file__).parents[2] / "experiments"


@pytest.mark.parametrize(
    "path",
    [
        ULYSSE,
        *(
            pytest.param(each, marks=pytest.mark.slow, id=f"{each.parent.parent.name}-{each.parent.name}")
            for each in sorted(WORKED.glob("*/mission.xml")) + sorted(WORKED.glob("natural/*/mission.xml"))
        ),
    ],
)
def test_both_say_the_same_of_a_mission(checker: Path, file: Path, path: Path) -> None:
    core = json.loads(json.dumps(core_entry(compose(read_mission(path)))))
    expected, found = of_both(checker, file, core)
    assert found == expected


@pytest.mark.may_leave(0.8)
@fewer(0.2, least=3)
@given(mission=DRAWN)
def test_both_say_the_same_of_drawn_missions(checker: Path, file: Path, mission: Mission) -> None:
    try:
        expected, found = of_both(checker, file, core_entry(composed(mission)))
    except McpnError as error:
        returns_early(type(error).__name__)
        return
    assert found == expected
    event("".join(sorted(kinds_of(found))))


@pytest.mark.slow
def test_both_say_the_same_of_many_drawn_missions(checker: Path, file: Path) -> None:
    """Where claims are proved they also keep as many states of as many types."""

    def judge(mission: Mission) -> str:
        try:
            core = json.loads(json.dumps(core_entry(composed(mission))))
        except McpnError as error:
            return type(error).__name__
        expected, found = of_both(checker, file, core)
        assert found == expected
        if "proved" in kinds_of(found):
            sections = sectioncheck.PlayedSections(core, sectioncheck.Budget(MOST, float("inf")))
            states = sum(len(each.states) for each in sections.types.values())
            assert counted(checker, file) == [len(sections.type), len(sections.types), states]
        return " ".join(sorted(kinds_of(found)))

    found = campaign(DRAWN, judge, 500)
    assert found["proved refuted"] > found["drawn"] // 4


@pytest.mark.parametrize("count", [12, pytest.param(2000, marks=pytest.mark.slow)])
def test_both_say_the_same_of_changed_missions(
    checker: Path, file: Path, fresh_seed: int, count: int
) -> None:
    kinds = Counter[str]()
    for number in range(count):
        drawn = random.Random(f"{fresh_seed} {number}")
        original = core_of(drawn.randint(1, 4), drawn.choice(["home", "abort", "succeed", "site0"]))
        core, document = mutated(original, drawn), copy.deepcopy(CLAIMED)
        if drawn.random() < 0.5:
            core, part = copy.deepcopy(original), drawn.choice(["core", "sections"])
            holder: Any = core if part == "core" else document
            *way, last = drawn.choice(list(paths_in(holder)))
            for key in way:
                holder = holder[key]
            holder[last] = changed(holder[last], drawn, core)
        expected, found = of_both(checker, file, core, document)
        assert found == expected, f"mutant {number} of --seed {fresh_seed}"
        kinds.update(kinds_of(found))
    assert {"malformed", "proved", "refuted"} & kinds.keys()


APART: dict[str, Callable[[Any], object]] = {
    "a fact": lambda core: core["robot"]["facts"].append({"name": "day", "initial": "yes"}),
    "an event of the robot": lambda core: core["robot"]["events"].append({"name": "dusk", "changes": []}),
    "a late loss": lambda core: core["robot"]["hardware"][0].update(late=True),
    "a handler that happens once": lambda core: core["graph"]["sections"][1]["handlers"][0].update(once="o"),
    "a section that facts leave": lambda core: core["graph"]["sections"][0]["left"].append(
        {"when": [], "to": [{"when": [], "to": "succeed"}]}
    ),
}


@pytest.mark.parametrize("why", APART)
def test_neither_checks_sections_that_share_more_than_hardware(checker: Path, file: Path, why: str) -> None:
    core = copy.deepcopy(core_of(3))
    APART[why](core)
    expected, found = of_both(checker, file, core)
    assert found == expected
    assert kinds_of(found) == {"not checked"}


FORMULA = {"text": "it may succeed", "formula": ["EU", ["and"], ["says", "success", ""]]}
NOMINAL: dict[str, list[str]] = {"fails": [], "endless": [], "meant": [], "repaired": []}


UNREAD: list[Any] = [
    [],
    ["EU", [], ["says", "success", ""]],
    ["EU", ["and"], ["or", ["says", "success", ""], ["happens", ["start", ""]]]],
    ["EU", ["and"], ["maybe", ["says", "success", ""]]],
    ["not", ["U", ["and"], ["says", "success", ""]]],
    ["E", ["X", "and", ["says", "success", ""]]],
    ["EU", ["and"], ["at most", 1, [[0]]]],
]


def claiming(kind: str, statement: Any) -> Any:
    """The claims on a row of sites that are proved, and one that states something besides."""
    document: Any = CLAIMED
    claims = [each for each in document["claims"] if each["key"] == "can_succeed True"]
    return document | {"claims": [*claims, claims[0] | {"key": kind, "kind": kind, "statement": statement}]}


@pytest.mark.parametrize("which", [0, 1, 4, pytest.param(9, marks=pytest.mark.slow)])
def test_both_prove_the_same_formulas_and_nominal_success(checker: Path, file: Path, which: int) -> None:
    core, claims = stated_mutants.original(which)
    claims = claims + [each | {"key": f"not {each['key']}", "holds": not each["holds"]} for each in claims]
    expected, found = of_both(checker, file, core, CLAIMED | {"claims": claims})
    assert found == expected
    assert not isinstance(found, str)
    proved = [key for how, key in found if how == "proved"]
    assert len(proved) > len(claims) // 5
    assert any(key.startswith("nominal_success") for key in proved)


@pytest.mark.parametrize("count", [15, pytest.param(2000, marks=pytest.mark.slow)])
def test_both_say_the_same_of_changed_formulas(
    checker: Path, file: Path, fresh_seed: int, count: int
) -> None:
    for number in range(count):
        drawn = random.Random(f"{fresh_seed} {number}")
        core, every = copy.deepcopy(stated_mutants.original(drawn.randrange(5)))
        claims = drawn.sample(every, 12)
        stated_mutants.change_claim(drawn.choice(claims), drawn.choice(every), drawn)
        if drawn.random() < 0.3:
            core = mutated(core, drawn)
        expected, found = of_both(checker, file, core, CLAIMED | {"claims": claims})
        assert found == expected, f"mutant {number} of --seed {fresh_seed}"


def dotted(core: Any) -> None:
    """The activity and its alternative are named so that a dot stands elsewhere."""
    activity = core["robot"]["activities"][1]
    activity["name"], activity["alternatives"][0]["name"] = "drive.by", "map"
    for section in core["graph"]["sections"]:
        section["activities"] = [each.replace("drive", "drive.by") for each in section["activities"]]


def alike(core: Any) -> None:
    """Two alternatives of one name, of which the second one never runs."""
    ways = core["robot"]["activities"][2]["alternatives"]
    ways.append(copy.deepcopy(ways[0]))


RUNS = ["EU", ["and"], ["says", "active", "drive.by.map"]]
RESTS = ["EU", ["and"], ["says", "active", "rest.on"]]
LOST = ["EU", ["and"], ["fires", ["out of service", "wheels", "x"]]]


@pytest.mark.parametrize(
    ("change", "formula", "said"),
    [(dotted, RUNS, "proved"), (alike, RESTS, "proved"), (len, LOST, "refuted")],
)
def test_names_are_taken_as_they_are(
    checker: Path, file: Path, change: Callable[[Any], object], formula: Any, said: str
) -> None:
    core = copy.deepcopy(core_of(3))
    change(core)
    expected, found = of_both(checker, file, core, claiming("formula", FORMULA | {"formula": formula}))
    assert found == expected == [("proved", "can_succeed True"), (said, "formula")]


@pytest.mark.parametrize(
    ("kind", "statement"),
    [
        ("formula", {}),
        ("formula", FORMULA | {"formula": "x"}),
        ("formula", NOMINAL),
        *(("formula", FORMULA | {"formula": each}) for each in UNREAD),
        ("nominal_success", {}),
        ("nominal_success", NOMINAL | {"meant": [1]}),
    ],
)
def test_both_refuse_what_states_nothing(checker: Path, file: Path, kind: str, statement: Any) -> None:
    assert of_both(checker, file, core_of(3), claiming(kind, statement)) == ("malformed", "malformed")
