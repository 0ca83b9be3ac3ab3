"""Another checker of cut sets at every moment and of probabilities, in C++, agrees with furthercheck.

It was written from the page on certificates alone.
"""

from __future__ import annotations

import json
import random
import tempfile
import zipfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.certificates import certcheck, furthercheck
from mcpn.certificates.writing import certificate_of_causes
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.spaces.stable.alternatives import direct
from mcpn.study import Study
from mcpn.testing import missions
from tests.answers.dense import any_missions, interrupted_missions
from tests.answers.test_interval_bounds import with_intervals
from tests.certificates.files import entries_of, rewritten
from tests.certificates.programs import compiled
from tests.certificates.test_second_checker import Claims, mutant, of_the_other
from tests.draws import fewer
from tests.logic.oracle import fragile_missions
from tests.shares import returns_early

SMALL = """
<mission xmlns="urn:mcpn:mission:1" name="small">
  <robot name="r">
    <hardware name="arm" failure_rate="0.02 .. 0.05" repair_rate="0.5"/>
    <hardware name="camera" failure_rate="0.01" repairable="false"/>
    <event name="stop" rate="0.1"/>
    <activity name="hold"><alternative name="on" consumes="arm"/></activity>
    <activity name="look">
      <alternative name="eye" consumes="camera"/><alternative name="feel" consumes="arm"/>
    </activity>
  </robot>
  <objective name="first" activities="look" duration="0.7" failure_probability="0.2" failure="abort"/>
  <objective name="second" activities="hold" duration="3"><on event="stop" goto="fail"/></objective>
</mission>
"""


LEFT = """
<mission xmlns="urn:mcpn:mission:1" name="left">
  <robot name="r">
    <hardware name="arm"/><event name="stop"/>
    <activity name="hold"><alternative name="on" consumes="arm"/></activity>
    <activity name="rest"><alternative name="on"/></activity>
  </robot>
  <objective name="one" activities="rest" success="succeed" failure="fail">
    <on event="stop" goto="other"/>
  </objective>
  <objective name="other" activities="hold"/>
</mission>
"""


@pytest.fixture(scope="module")
def checker(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program."""
    return compiled("further_checker", tmp_path_factory)


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The certificate of the causes and the probabilities of a small mission."""
    path = tmp_path_factory.mktemp("small") / "mission.xml"
    path.write_text(SMALL.lstrip())
    return certificate_of_causes(Study(read_mission(path)).causes(), chances=True).to_bytes()


def of_furthercheck(path: str) -> Claims | str:
    try:
        return [(how, key) for how, key, _ in furthercheck.checked(path)]
    except certcheck.Malformed:
        return "malformed"


def verdicts(found: Claims | str) -> set[str]:
    """What became of claims."""
    return {"malformed"} if isinstance(found, str) else {how for how, _ in found}


def agreed(checker: Path, path: str) -> Claims | str:
    """What both say of a certificate."""
    expected = of_furthercheck(path)
    assert of_the_other(checker, Path(path)) == expected
    return expected


def agreed_on_mutant(checker: Path, entries: dict[str, Any], drawn: random.Random) -> Claims | str:
    """What both say of a certificate of which a value or two are others."""
    names = ("net.json", *["further.json"] * 4)
    with tempfile.NamedTemporaryFile() as file:
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, document in mutant(entries, drawn, names).items():
                archive.writestr(name, json.dumps(document))
        file.flush()
        return agreed(checker, file.name)


def test_both_prove_each_claim_of_a_small_mission(checker: Path, small: bytes) -> None:
    kinds = {claim["kind"] for claim in entries_of(small)["further.json"]["claims"]}
    moments = ("at_start", "at_entry", "whenever", "at_worst")
    assert kinds == {"chance", *(f"cut_sets_{moment}" for moment in moments)}
    with rewritten(small, "further.json") as path:
        assert verdicts(agreed(checker, path)) == {"proved"}


@pytest.mark.slow
def test_both_prove_each_claim_of_the_mission_of_the_paper(checker: Path, ulysse: Mission) -> None:
    with rewritten(certificate_of_causes(Study(ulysse).causes()).to_bytes(), "further.json") as path:
        assert verdicts(agreed(checker, path)) == {"proved"}


def _of_kind(kind: str, change: Callable[[Any], Any]) -> Callable[[Any], None]:
    """A change of the first claim of a kind that says something."""

    def changed(document: Any) -> None:
        found = (claim for claim in document["claims"] if claim["kind"] == kind)
        claim = next(claim for claim in found if kind == "chance" or claim["statement"]["cuts"])
        change(claim)

    return changed


def _one_set_less(claim: Any) -> None:
    claim["statement"]["cuts"].pop()


def _one_run_less(claim: Any) -> None:
    claim["evidence"]["survived"].pop()


def _another_moment(claim: Any) -> None:
    for each in claim["evidence"]["survived"]:
        each["by"] = 0


def _a_bit_less(claim: Any) -> None:
    number = next(at for at, each in enumerate(claim["evidence"]["above"]) if 0 < each < 10**17)
    claim["evidence"]["above"][number] -= 10**6


def _a_bit_more(claim: Any) -> None:
    number = next(at for at, each in enumerate(claim["evidence"]["below"]) if 0 < each < 10**17)
    claim["evidence"]["below"][number] += 10**6


def _other_rate(claim: Any) -> None:
    claim["statement"]["hardware"][0]["fails"] = ["0.02", "0.06"]


@pytest.mark.parametrize(
    ("kind", "change"),
    [
        *(
            (f"cut_sets_{moment}", change)
            for moment in ("at_start", "at_entry", "whenever")
            for change in (_one_set_less, _one_run_less)
        ),
        ("cut_sets_at_entry", _another_moment),
        ("cut_sets_at_worst", _one_set_less),
        *(("chance", change) for change in (_a_bit_less, _a_bit_more, _other_rate)),
    ],
)
def test_both_refute_what_is_wrong(checker: Path, small: bytes, kind: str, change: Any) -> None:
    with rewritten(small, "further.json", _of_kind(kind, change)) as path:
        found = agreed(checker, path)
    assert [each[0] for each in found].count("refuted") == 1


def test_an_element_without_a_name_is_none_of_those_named(checker: Path, small: bytes) -> None:
    """No entry is left where the places of what is entered say that of an element without a name."""
    entries = entries_of(small)
    for place in entries["net.json"]["places"]:
        place["roles"] = [
            [role, "" if role in ("objective", "pending") and of == "first" else of]
            for role, of in place["roles"]
        ]
    with rewritten(small, "net.json", lambda document: document.update(entries["net.json"])) as path:
        found = agreed(checker, path)
    assert ("refuted", "cut_sets_at_entry: success: first") in found


def test_an_event_of_three_texts_has_no_rate(checker: Path, small: bytes) -> None:
    def longer(document: Any) -> None:
        claim = next(claim for claim in document["claims"] if claim["key"] == "chance: abort")
        claim["statement"]["events"].append({"event": ["declared", "stop", "stop"], "rate": ["1", "1"]})

    with rewritten(small, "further.json", longer) as path:
        assert ("refuted", "chance: abort") in agreed(checker, path)


def test_a_run_that_is_left_has_ended(checker: Path, tmp_path: Path) -> None:
    """Where only a declared event leads from one objective to another, it enters the other one."""
    (tmp_path / "mission.xml").write_text(LEFT.lstrip())
    data = certificate_of_causes(Study(read_mission(tmp_path / "mission.xml")).causes()).to_bytes()

    def change(document: Any) -> None:
        found = (claim for claim in document["claims"] if claim["kind"] == "cut_sets_at_entry")
        claim = next(claim for claim in found if claim["subject"] == ["success", "other"])
        claim["statement"] |= {"inside": [["objective", "one"]], "again": ["one"]}

    with rewritten(data, "further.json", change) as path:
        assert verdicts(agreed(checker, path)) == {"proved"}


FEW_MUTANTS = 1000
"""Fewer need not show each kind of verdict."""


@pytest.mark.parametrize("count", [40, pytest.param(5000, marks=pytest.mark.slow)])
def test_both_say_the_same_of_changed_certificates(
    checker: Path, small: bytes, fresh_seed: int, count: int
) -> None:
    kinds = Counter[str]()
    for number in range(count):
        found = agreed_on_mutant(checker, entries_of(small), random.Random(f"{fresh_seed} {number}"))
        kinds.update(verdicts(found))
    assert {"malformed", "proved", "refuted"} <= kinds.keys() or count < FEW_MUTANTS


def certified(mission: Mission, chances: bool) -> bytes | str:
    """A certificate with further claims, or why there is none."""
    study = Study(mission)
    try:
        direct(study.mission_net.net, max_states=300)
        certificate = certificate_of_causes(study.causes(), chances=chances)
    except (LimitError, SemanticsError) as error:
        return type(error).__name__
    return certificate.to_bytes() if certificate.further else "trusted"


@fewer(0.05, least=3)
@given(
    st.tuples(any_missions() | interrupted_missions(), st.sampled_from([1.0, 10.0]))
    | st.tuples(
        missions(max_hardware=3, max_objectives=2, max_sections=3, events=2, timeouts=2, early=1)
        | missions(max_hardware=2, max_objectives=2, max_sections=3, events=2, facts=1)
        | fragile_missions(max_hardware=2, max_objectives=2, max_sections=3, crashes=True),
        st.none(),
    ),
    st.randoms(use_true_random=False),
)
def test_both_say_the_same_of_drawn_missions(
    checker: Path, drawn: tuple[Mission, float | None], rest: random.Random
) -> None:
    mission, share = drawn
    data = certified(mission if share is None else with_intervals(mission, share), share is not None)
    if isinstance(data, str):
        return returns_early(data)
    with rewritten(data, "further.json") as path:
        assert verdicts(agreed(checker, path)) == {"proved"}
    agreed_on_mutant(checker, entries_of(data), rest)
    return None
