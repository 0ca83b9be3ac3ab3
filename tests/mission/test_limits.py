"""Limits of what is written out: as much as each says is allowed, one more is refused with its line."""

from __future__ import annotations

from pathlib import Path

import pytest

from mcpn.errors import LimitError
from mcpn.mission.rewriting import limits
from mcpn.mission.rewriting.limits import Counted, measure
from tests.mission.test_language import mission


@pytest.mark.parametrize(("attribute", "each"), [("MAX_OBJECTIVES", (0,)), ("MAX_PARAMETERS", (3, 1))])
def test_as_many_as_the_limit_says_are_counted(
    attribute: str, each: tuple[int, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, attribute, sum(each) or len(each))
    counted = Counted()
    for parameters in each:
        counted.add(parameters, None)
    with pytest.raises(LimitError, match="more than"):
        counted.add(1, None)


def test_blocks_stand_in_each_other_as_deep_as_the_limit_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    inner = '<objective name="b"><objective name="o" activities="go"/></objective>'
    found = mission(tmp_path, f'<objective name="a">{inner}</objective>')
    monkeypatch.setattr(limits, "MAX_NESTING", 2)
    measure(found)
    monkeypatch.setattr(limits, "MAX_NESTING", 1)
    with pytest.raises(LimitError, match="nested more than 1 deep"):
        measure(found)


def test_the_objective_that_is_one_too_many_is_named_by_its_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = mission(tmp_path, "".join(f'\n<objective name="o{i}" activities="go"/>' for i in range(4)))
    monkeypatch.setattr(limits, "MAX_OBJECTIVES", 2)
    third = found.blocks[2].source
    assert third is not None
    with pytest.raises(LimitError, match=rf"m\.xml:{third.line}: more than 2 objectives"):
        measure(found)
