"""Formulas and nominal success by sections: what is proved is so in the whole mission, state by state."""

from __future__ import annotations

import copy
import json
import random
from collections import Counter
from typing import Any

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from experiments.faults.core_mutants import DAY, ROUND, study_of
from experiments.growth.growth import FAMILIES
from mcpn.answers.mission_names import MissionNames
from mcpn.certificates import certcheck
from mcpn.certificates.core_entry import core_entry
from mcpn.certificates.formula_entry import formula_entry
from mcpn.certificates.net_entry import net_entry
from mcpn.certificates.sections import sectioncheck, sectionforms
from mcpn.certificates.writing import certificate_of
from mcpn.errors import ConfluenceError, LimitError
from mcpn.logic import syntax
from mcpn.logic.syntax import parse
from mcpn.mission.model import Mission
from mcpn.nets.numbering import Nodes
from mcpn.spaces.stable.alternatives import direct
from mcpn.study import Study
from mcpn.testing import missions
from tests.draws import fewer
from tests.shares import returns_early


def plain(value: Any) -> Any:
    return json.loads(json.dumps(value))


def played(study: Study) -> sectioncheck.PlayedSections:
    core = plain(core_entry(study.mission_net))
    return sectioncheck.PlayedSections(core, sectioncheck.Budget(100_000, float("inf")))


def listed(study: Study) -> certcheck.Listing:
    return certcheck.Listing(certcheck.Net(plain(net_entry(study.mission_net))), 100_000, float("inf"))


def claims_of(study: Study) -> list[dict[str, Any]]:
    """The claims of the certificate of all states, in the form in which sections read them."""
    made = plain(certificate_of(study.verdicts(engine="explicit")).claims)
    for each in made:
        each["evidence"] = {}
        each["kind"] = "formula" if "formula" in each["statement"] else each["kind"]
    return [each for each in made if each["kind"] in sectioncheck.KINDS | sectioncheck.STATED]


def by_sections(sections: sectioncheck.PlayedSections, claim: dict[str, Any]) -> str:
    try:
        sectioncheck.judge(sections, claim)
    except certcheck.Refuted as error:
        return "not shown" if sectionforms.UNSHOWN in str(error) else "refuted"
    return "proved"


def test_most_claims_of_a_mission_are_proved_by_its_sections() -> None:
    study = study_of(ROUND)
    sections, found = played(study), Counter[str]()
    for claim in claims_of(study):
        how = by_sections(sections, claim)
        assert how != "refuted" or claim["kind"] != "formula", claim
        found[f"{claim['key'].partition(':')[0]}: {how}"] += 1
    proved = {key.partition(":")[0] for key in found if key.endswith(": proved")}
    assert {"nominal_success", "outcome_comes", "runs_with", "succeeds_without", "ignored", "used"} <= proved
    assert sum(times for key, times in found.items() if key.endswith(": proved")) > 40


@fewer(0.2)
@given(
    missions(max_hardware=3, max_objectives=3, max_sections=4, events=2, timeouts=1), st.integers(0, 1 << 32)
)
def test_what_sections_prove_is_so_in_the_states(mission: Mission, seed: int) -> None:
    """Each claim and its contrary, and formulas that are changed, against the states of the whole net."""
    study = Study(mission)
    try:
        direct(study.mission_net.net, max_states=1_000)
        claims, sections = claims_of(study), played(study)
    except (LimitError, ConfluenceError, certcheck.Limit) as error:
        return returns_early(type(error).__name__)
    graph, draw = listed(study), random.Random(seed)
    for claim in claims:
        if claim["kind"] == "formula":
            other = copy.deepcopy(draw.choice([each for each in claims if each["kind"] == "formula"]))
            _change(other["statement"]["formula"], claim["statement"]["formula"], draw)
            for one in (claim, {**claim, "holds": not claim["holds"]}, other):
                try:
                    how = by_sections(sections, one)
                    if how == "proved":
                        certcheck.judge(graph, one)
                except certcheck.Malformed:
                    how = "malformed"
                event(how)
        elif by_sections(sections, claim) == "proved" and claim["kind"] == "nominal_success":
            event("nominal success")
    return None


def _change(form: list[Any], other: list[Any], draw: random.Random) -> None:
    """Changes one part of a formula for one of another."""
    parts, others = [*_parts(form)], [*_parts(other)]
    part = draw.choice(parts)
    part[:] = copy.deepcopy(draw.choice(others))


def _parts(form: list[Any]) -> Any:
    yield form
    for each in form:
        if isinstance(each, list) and each and isinstance(each[0], str):
            yield from _parts(each)


NOMINAL = {"fails": [], "endless": [], "meant": ["first", "second", "see", "listen"], "repaired": []}


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({}, None),
        ({"meant": ["first", "nowhere"]}, "is meant to be entered"),
        ({"fails": ["second"]}, "is meant to be entered"),
        ({"fails": ["home"]}, "come back to a section"),
        ({"repaired": ["ear"]}, "do not show it"),
        ({"endless": ["home"]}, "do not show it"),
    ],
)
def test_nominal_runs_enter_what_is_meant(change: dict[str, list[str]], why: str | None) -> None:
    claim = {"key": "n", "kind": "nominal_success", "subject": [], "holds": True, "sentence": "s"}
    sections = played(study_of(ROUND))
    claim |= {"statement": NOMINAL | change, "evidence": {}}
    if why is None:
        sectioncheck.judge(sections, claim)
        return
    with pytest.raises(certcheck.Refuted, match=why):
        sectioncheck.judge(sections, claim)


@pytest.mark.parametrize(
    "formula", [["says", "objective"], ["says", 1, "x"], [["and"]], ["fires", "x"], ["and", "x"]]
)
def test_what_is_no_formula_is_malformed(formula: Any) -> None:
    claim = {"key": "f", "kind": "formula", "subject": [], "holds": True, "sentence": "s", "evidence": {}}
    sections = played(study_of(ROUND))
    with pytest.raises(certcheck.Malformed):
        sectioncheck.judge(
            sections, claim | {"statement": {"text": "x", "formula": ["EU", ["and"], formula]}}
        )


def test_facts_keep_sections_from_being_asked() -> None:
    with pytest.raises(certcheck.Limit, match="not apart"):
        played(study_of(DAY))


def test_formulas_are_read_without_drawing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each of very many claims is read alone: no transition is drawn, nor every objective looked at."""
    mission_net = Study(FAMILIES["sites"][0](60)).mission_net
    copies = mission_net.graph.copies
    names = MissionNames(mission_net)
    name = sorted(copies.objectives)[0]
    said = parse(f"EF E(happens(OBJ_{name}_EV_OK))", names)
    monkeypatch.setattr(Nodes, "__getitem__", None)
    monkeypatch.setattr(copies, "objectives", None)
    assert parse(f"EF E(happens(OBJ_{name}_EV_OK))", names) == said
    assert formula_entry(said, mission_net)[-1] == ["E", ["happens", ["success", name]]]


def test_claims_too_long_to_read_are_trusted(monkeypatch: pytest.MonkeyPatch) -> None:
    """The formula of a claim on all objectives may be longer than what is read: the others are certified."""
    check = Study(FAMILIES["sites"][0](60)).verdicts()
    assert check is not None
    monkeypatch.setattr(syntax, "MAX_LENGTH", 500)
    made = certificate_of(check)
    assert made.claims
    assert any("more than 500 characters" in why for _, why in made.trusted.values())
