"""Faults seeded in mcpn itself: each stands in its file still, and of one a certificate is refuted."""

from __future__ import annotations

import pytest

from experiments.faults.seeded_faults import PACKAGE, changed, compared, outcome, table
from experiments.faults.seeded_list import ENDS_AT_ONE_MOMENT, FAULTS, Seeded
from experiments.faults.seeded_missions import Answered, answered


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_what_a_fault_replaces_stands_in_its_file_once(fault: Seeded) -> None:
    text = (PACKAGE / fault.path).read_text(encoding="utf-8")
    assert changed(fault, PACKAGE) != text
    compile(changed(fault, PACKAGE), fault.path, "exec")


def test_a_fault_that_has_rotten_is_told() -> None:
    rotten = ENDS_AT_ONE_MOMENT._replace(old="what nobody has ever written")
    with pytest.raises(ValueError, match=r"ranks\.py has 0 times 'what nobody has ever written'"):
        changed(rotten, PACKAGE)


def test_faults_have_names_of_their_own_and_are_of_all_areas() -> None:
    areas = {"templates", "big steps", "composition", "causes", "minimiser", "controller", "risk"}
    assert len({fault.name for fault in FAULTS}) == len(FAULTS)
    assert {fault.area for fault in FAULTS} == areas


def test_ends_at_one_moment_are_refuted_by_the_interpreter_of_missions_alone() -> None:
    right = {asked: answered(asked) for asked in ENDS_AT_ONE_MOMENT.asks}
    assert outcome(ENDS_AT_ONE_MOMENT, right)[:2] == ("refuted", "corecheck")


RIGHT = Answered([{"success": 0.5}], "", {"a": "proved by certcheck"}, {"success": ("0.4", "0.6")})


@pytest.mark.parametrize(
    ("wrong", "how"),
    [
        (RIGHT, "same"),
        (RIGHT._replace(said=[{"success": 0.45}]), "unseen"),
        (RIGHT._replace(said=[{"success": 0.7}]), "contradicted"),
        (RIGHT._replace(found={"a": "refuted by certcheck"}), "refuted"),
        (RIGHT._replace(found={"a": "not checked by certcheck"}), "not proved"),
        (Answered(None, "KeyError"), "mcpn stops"),
        (Answered(RIGHT.said, "no certificate: KeyError"), "not written"),
    ],
)
def test_how_a_fault_is_noticed(wrong: Answered, how: str) -> None:
    assert compared(RIGHT, wrong)[0] == how
    assert f"| {how} |" in table([]) or how == "same"
