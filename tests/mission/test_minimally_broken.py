"""Drawn missions with one fault each: told in its line, by its words, and nothing is told of sound ones."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, event, given, settings

from mcpn.errors import InputError
from mcpn.testing import Shape
from mcpn.testing.broken import FAULTS, BrokenMission, broken_missions
from tests.commands import mcpn

LARGE = Shape(events=1, facts=1, early=2, timeouts=2, aborts=2, recovers=2, text=True)


@given(broken_missions() | broken_missions(LARGE))
def test_a_fault_is_told_in_its_line(broken: BrokenMission) -> None:
    event(broken.fault)
    told(broken)


def told(broken: BrokenMission) -> None:
    """It is refused, with what is wrong and where."""
    with pytest.raises(InputError) as caught:
        broken.read()
    assert broken.is_told(caught.value), f"{broken!r}\n{caught.value}"


@pytest.mark.parametrize("fault", FAULTS)
def test_every_fault_is_told(fault: str) -> None:
    drawn: list[BrokenMission] = []

    @settings(
        max_examples=4,
        derandomize=True,
        database=None,
        deadline=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(broken_missions(LARGE, fault=fault))
    def draws(broken: BrokenMission) -> None:
        drawn.append(broken)
        told(broken)

    draws()
    assert {broken.fault for broken in drawn} == {fault}


def test_the_command_line_says_the_same(tmp_path: Path) -> None:
    found: list[BrokenMission] = []

    @settings(max_examples=1, derandomize=True, database=None, phases=[Phase.generate])
    @given(broken_missions())
    def draws(broken: BrokenMission) -> None:
        found.append(broken)

    draws()
    file = tmp_path / "m.xml"
    file.write_text(found[0].text)
    answer = mcpn("check", file)
    assert answer.returncode == 2
    assert f"{file}:{found[0].line}: " in answer.stderr
    assert found[0].message in answer.stderr
