"""Claims on losses at the entry of sections, on what the text says, and on hardware that nothing uses."""

from __future__ import annotations

from pathlib import Path

from mcpn.answers.claims import Claim, claims_of, claims_of_causes
from mcpn.mission.xml import read_mission
from mcpn.study import Study

TEXT = (
    '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><hardware name="eye"/>'
    '<hardware name="arm"/><hardware name="frame" faulty="false"/>'
    '<activity name="look" consumes="eye frame"/>'
    '<activity name="grasp" consumes="arm"/></robot>'
    '<objective name="see" activities="look"/><objective name="take" activities="grasp"/></mission>'
)


def of(folder: Path) -> dict[str, Claim]:
    (folder / "m.xml").write_text(TEXT)
    study = Study(read_mission(folder / "m.xml"))
    claims = [*claims_of(study.verdicts()), *claims_of_causes(study.causes())]
    return {claim.key: claim for claim in claims}


def test_what_was_used_before_is_needed_no_more(tmp_path: Path) -> None:
    """From the second section on nothing needs the eye."""
    claims = of(tmp_path)
    so = {key: claim.holds for key, claim in claims.items() if claim.kind == "loss_at_entry_defeats"}
    assert so == {
        "loss_at_entry_defeats: eye, see": True,
        "loss_at_entry_defeats: arm, see": True,
        "loss_at_entry_defeats: eye, take": False,
        "loss_at_entry_defeats: arm, take": True,
    }


def test_what_the_text_grants_and_what_runs_is_said(tmp_path: Path) -> None:
    claims = of(tmp_path)
    assert {name: claims[f"granted: {name}"].holds for name in ("eye", "arm", "frame")} == {
        "eye": False,
        "arm": False,
        "frame": True,
    }
    assert claims["used: frame"].holds
    assert claims["selected: look, look"].holds


def test_where_nothing_may_be_lost_no_number_of_losses_is_claimed(tmp_path: Path) -> None:
    (tmp_path / "m.xml").write_text(TEXT.replace('name="eye"', 'name="eye" faulty="false"'))
    eye = (tmp_path / "m.xml").read_text().replace('name="arm"', 'name="arm" faulty="false"')
    (tmp_path / "m.xml").write_text(eye)
    causes = Study(read_mission(tmp_path / "m.xml")).causes()
    kinds = {claim.kind for claim in claims_of_causes(causes)}
    assert not {kind for kind in kinds if kind.startswith(("any_lost", "most_lost"))}
    assert "losses_lose_objective" in kinds
