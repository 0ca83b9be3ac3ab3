"""Missions written from the language page alone; what was wrong at the first try is told there now."""

from __future__ import annotations

from pathlib import Path

import pytest

import mcpn

HERE = Path(__file__).parent


@pytest.mark.parametrize(
    ("name", "formulas"),
    [
        # It docks, or comes up; a strong current is waited out, and the approach goes on.
        ("auv", ["AG (success -> fact(docked))", "EF (block(wait) & EF (objective(lock) & EF success))"]),
        # It sleeps at dusk whatever it is doing, and goes on with the site where it was.
        (
            "rover",
            ["EF block(hibernate_at_go_c_try1)", "AG (block(hibernate_at_go_c_try1) -> !EF objective(go_a))"],
        ),
        # A person stops the tour, which goes on where it was; a lost lidar stops it for good.
        (
            "guard",
            [
                "AG (block(stand_at_drive_out) -> !EF objective(look))",
                "EF (block(stand_at_drive_out) & EF (objective(drive_out) & EF success))",
                "AG (objective(drive_in) & oos(lidar) -> refused(watch))",
            ],
        ),
    ],
)
def test_what_a_reader_wrote_means_what_he_meant(name: str, formulas: list[str]) -> None:
    study = mcpn.open(HERE / f"{name}.xml")
    found = study.verdicts()
    assert found.passed
    assert all(answer.met for answer in found.requirements)
    assert found.warnings == []
    for formula in formulas:
        assert study.ctl(formula).holds, formula
