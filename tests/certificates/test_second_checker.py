"""Another checker of certificates, in C++, written from the page on them alone, agrees with certcheck.

What the two first made differently of changed certificates were sentences that the page lacked.
"""

from __future__ import annotations

import copy
import json
import random
import subprocess
import zipfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from mcpn.certificates import certcheck
from mcpn.certificates.writing import certificate_of, certificate_of_causes
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.study import Study
from tests.certificates.files import entries_of
from tests.certificates.programs import compiled

Claims = list[tuple[str, str]]
"""Of each claim what became of it, and its key."""

SMALL = """
<mission xmlns="urn:mcpn:mission:1" name="small">
  <robot name="r">
    <hardware name="camera"/><hardware name="arm"/><event name="stop"/>
    <activity name="look">
      <alternative name="eye" consumes="camera"/><alternative name="feel" consumes="arm"/>
    </activity>
    <activity name="rest"><alternative name="on"/></activity>
  </robot>
  <requirement name="looked" formula="G (success -> done(first))"/>
  <objective name="first" activities="look" failure="abort"/>
  <parallel name="both">
    <objective name="second" activities="look"/>
    <objective name="third" activities="rest" mandatory="false"><on event="stop" goto="fail"/></objective>
  </parallel>
</mission>
"""


@pytest.fixture(scope="module")
def checker(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program."""
    return compiled("checker", tmp_path_factory)


@pytest.fixture(scope="module")
def certificates(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """What ``check`` and ``causes`` write of a small mission."""
    folder = tmp_path_factory.mktemp("certificates")
    (folder / "small.xml").write_text(SMALL.lstrip())
    return [*written(Study(read_mission(folder / "small.xml")), folder)]


def written(study: Study, folder: Path) -> Iterator[Path]:
    """What ``check`` and ``causes`` write of a mission."""
    for name, certificate in (
        ("check", certificate_of(study.verdicts())),
        ("causes", certificate_of_causes(study.causes())),
    ):
        path = folder / name
        path.write_bytes(certificate.to_bytes())
        yield path


UNREAD = {("not checked", "further.json"), ("not checked", "diagrams.json")}
"""What it says of entries that it does not read, which certcheck leaves to others."""


def of_certcheck(path: Path) -> Claims | str:
    try:
        return [(how, key) for how, key, _ in certcheck.checked(str(path))]
    except certcheck.Malformed:
        return "malformed"


def of_the_other(checker: Path, path: Path) -> Claims | str:
    run = subprocess.run([checker, path], check=False, capture_output=True, text=True, timeout=60)
    if ": malformed: " in run.stderr:
        assert run.returncode == 2
        return "malformed"
    found = []
    for line in run.stdout.splitlines():
        how = next(how for how in ("proved", "refuted", "not checked") if line.startswith(f"{how} "))
        found.append((how, line.removeprefix(f"{how} ")))
    kinds = {how for how, _ in found}
    assert run.returncode == (1 if "refuted" in kinds else 0 if kinds == {"proved"} else 2), run.stderr
    return [each for each in found if each not in UNREAD]


def paths_in(document: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The way to each value of a document, but the whole."""
    inside = document.items() if isinstance(document, dict) else enumerate(document)
    for key, value in inside:
        yield (*path, key)
        if isinstance(value, dict | list):
            yield from paths_in(value, (*path, key))


def changed(value: Any, drawn: random.Random, document: Any) -> Any:
    """Another value in the place of one."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, int):
        return drawn.choice((value + 1, value - 1, 0, -3, drawn.randrange(50)))
    if isinstance(value, str):
        return drawn.choice(json.dumps(document).split('"')[1::2])
    made = copy.deepcopy(value)
    if isinstance(made, dict):
        if made and drawn.random() < 0.5:
            made.pop(drawn.choice(list(made)))
        else:
            made["more"] = 1
    elif made:
        at = drawn.randrange(len(made))
        match drawn.randrange(4):
            case 0:
                made.pop(at)
            case 1:
                made.insert(at, copy.deepcopy(drawn.choice(made)))
            case 2:
                made.append(made.pop(at))
            case _:
                made = []
    return made


def mutant(
    entries: dict[str, Any],
    drawn: random.Random,
    names: tuple[str, ...] = ("net.json", "claims.json", "claims.json"),
) -> dict[str, Any]:
    """A certificate of which a value or two are others, in the documents with these names."""
    made = copy.deepcopy(entries)
    for _ in range(drawn.choice((1, 1, 1, 2))):
        document = made[drawn.choice(names)]
        *way, last = drawn.choice(list(paths_in(document)))
        at = document
        for key in way:
            at = at[key]
        at[last] = changed(at[last], drawn, document)
    return made


def is_no_mission(entries: dict[str, Any], *reports: Claims | str) -> bool:
    """Whether both refute claims on the net alone: one neither safe nor confluent is refuted as either."""
    kinds = {claim["key"]: claim["kind"] for claim in entries["claims.json"]["claims"]}
    refuted = [
        {kinds[key] for how, key in report if how == "refuted"} if isinstance(report, list) else {"malformed"}
        for report in reports
    ]
    return all(each and each <= {"safe", "confluent"} for each in refuted)


def test_both_prove_each_claim_on_worked_missions(checker: Path, ulysse: Mission, tmp_path: Path) -> None:
    for path in written(Study(ulysse), tmp_path):
        found = of_the_other(checker, path)
        assert found == of_certcheck(path)
        assert {each[0] for each in found} == {"proved"}


def test_neither_says_that_all_is_proved_where_nothing_is_claimed(
    checker: Path, certificates: list[Path], tmp_path: Path
) -> None:
    entries = entries_of(certificates[0].read_bytes())
    path = tmp_path / "empty"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("net.json", json.dumps(entries["net.json"]))
        archive.writestr("claims.json", json.dumps({**entries["claims.json"], "claims": []}))
    assert subprocess.run([checker, path], check=False, timeout=60).returncode == 2
    assert certcheck.main([str(path)]) == 2


FEW_MUTANTS = 1000
"""Fewer need not show each kind of verdict."""


@pytest.mark.parametrize("count", [40, pytest.param(5000, marks=pytest.mark.slow)])
def test_both_say_the_same_of_changed_certificates(
    checker: Path, certificates: list[Path], fresh_seed: int, tmp_path: Path, count: int
) -> None:
    originals = [entries_of(path.read_bytes()) for path in certificates]
    kinds = Counter[str]()
    for number in range(count):
        drawn = random.Random(f"{fresh_seed} {number}")
        entries = mutant(drawn.choice(originals), drawn)
        path = tmp_path / "mutant"
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, document in entries.items():
                archive.writestr(name, json.dumps(document))
        expected, found = of_certcheck(path), of_the_other(checker, path)
        alike = found == expected or is_no_mission(entries, expected, found)
        assert alike, f"mutant {number} of --seed {fresh_seed}"
        kinds.update({"malformed"} if isinstance(expected, str) else {how for how, _ in expected})
    assert {"malformed", "proved", "refuted"} <= kinds.keys() or count < FEW_MUTANTS
