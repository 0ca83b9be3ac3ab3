"""What an editor shows of a mission's states: problems say what is so, and no more."""

from __future__ import annotations

from pathlib import Path

from mcpn.editor.shown_states import findings

TEXT = """<mission name="m" xmlns="urn:mcpn:mission:1">
  <robot name="r"><hardware name="arm"/><activity name="lift" consumes="arm"/><activity name="rest"/>
    <activity name="push"><alternative name="hard" consumes="arm"/><alternative name="soft"/></activity>
  </robot>
  <requirement name="ends" formula="AG EF success"/>
  <parallel name="both">
    <objective name="a" activities="lift"/><objective name="b" activities="{}"/>
  </parallel>
</mission>"""


def told(of: str, tmp_path: Path) -> list[str]:
    (tmp_path / "m.xml").write_text(TEXT.format(of))
    return [each["message"] for each in findings(tmp_path / "m.xml")["problems"]]


def test_a_requirement_that_is_not_decided_is_not_said_to_be_violated(tmp_path: Path) -> None:
    said = told("push", tmp_path)  # who gets the arm first depends on chance
    assert "requirement ends is not decided" in said
    assert not [message for message in said if "not met" in message]


def test_a_requirement_that_is_violated_is_not_met(tmp_path: Path) -> None:
    (tmp_path / "m.xml").write_text(TEXT.format("rest").replace("AG EF success", "G !success"))
    said = [each["message"] for each in findings(tmp_path / "m.xml")["problems"]]
    assert "requirement ends is not met" in said
