"""What happens while nothing fails in an imported tree: what conditions answer then, the author says."""

from __future__ import annotations

from pathlib import Path

import pytest

from mcpn.answers.claims.of_check import of_verdict
from mcpn.answers.verdicts.mission import MissionCheck
from mcpn.cli.line import run
from mcpn.study import open_study
from tests.trees.test_import import A, B, C, node

STUCK, LEAVE = "<IsStuck/>", node("Sequence", A, B)


def checked(folder: Path, tree: str, nominal: str = "unknown") -> MissionCheck:
    """The verdicts of a tree, whose author has said something of its condition."""
    path = folder / "tree.xml"
    path.write_text(f'<root BTCPP_format="4"><BehaviorTree ID="M">{tree}</BehaviorTree></root>')
    assert run(["init", str(folder / "m"), "--from", str(path)]) == 0
    mission = folder / "m" / "mission.xml"
    text = mission.read_text()
    assert text.count('nominal="unknown"') == tree.count("<Is")
    mission.write_text(text.replace('nominal="unknown"', f'nominal="{nominal}"'))
    return open_study(mission).verdicts()


def test_a_condition_whose_success_may_be_no_good_news(tmp_path: Path) -> None:
    found = checked(tmp_path, node("Sequence", STUCK, A)).verdicts["nominal_success"]
    assert found.holds
    assert of_verdict(found).sentence.startswith(
        "While nothing fails, and IsStuck succeeds, the mission succeeds"
    )
    assert 'nominal="fails" if by failure' in found.explanation


def test_what_depends_on_it_is_not_known(tmp_path: Path) -> None:
    found = checked(tmp_path, node("Sequence", node("Inverter", STUCK), A)).verdicts["nominal_success"]
    assert found.holds is None
    assert of_verdict(found).sentence == "Whether the mission succeeds while nothing fails is not known."


@pytest.mark.parametrize(
    ("tree", "nominal", "holds"),
    [
        (node("Sequence", STUCK, A), "entered", True),
        (node("Sequence", STUCK, A), "fails", False),
        (node("Sequence", node("Inverter", STUCK), A), "entered", False),
        (node("Sequence", node("Inverter", STUCK), A), "fails", True),
        (node("IfThenElse", STUCK, A, LEAVE), "fails", True),
        (node("ReactiveFallback", STUCK, A), "fails", True),
    ],
)
def test_what_the_author_says(tree: str, nominal: str, holds: bool, tmp_path: Path) -> None:
    found = checked(tmp_path, tree, nominal).verdicts["nominal_success"]
    assert found.holds is holds
    claim = of_verdict(found)
    assert (claim.kind, claim.holds, claim.assumes.given) == ("nominal_success", holds, ())


def test_a_tree_that_never_ends(tmp_path: Path) -> None:
    """It does not succeed, and is not said to."""
    tree = node("Sequence", A, node("KeepRunningUntilFailure", node("Sequence", B, C)))
    verdicts = checked(tmp_path, tree).verdicts
    assert verdicts["nominal_success"].holds
    said = "While nothing fails, the mission goes on for ever, as it is meant to."
    assert of_verdict(verdicts["nominal_success"]).sentence == said
    assert verdicts["success_reachable"].holds is False
