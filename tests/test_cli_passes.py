"""``mcpn convert --pass`` and ``--passes``: missions printed after a pass, and the list of passes."""

from __future__ import annotations

from pathlib import Path

import pytest

from mcpn.mission.passes import PASSES, core
from mcpn.mission.xml import read_mission
from tests.commands import mcpn
from tests.conftest import ROOT, ULYSSE

GLIDER = ROOT / "experiments" / "glider" / "mission.xml"


def test_passes_are_listed_in_their_order_each_with_what_it_does() -> None:
    lines = mcpn("convert", "--passes").stdout.splitlines()
    assert [line.split()[0] for line in lines] == [rewrite.__name__ for rewrite in PASSES]
    assert all(line.split(maxsplit=1)[1].endswith(").") for line in lines)


@pytest.mark.parametrize("rewrite", PASSES, ids=lambda rewrite: rewrite.__name__)
def test_a_printed_mission_is_the_mission_after_the_pass(rewrite: object, tmp_path: Path) -> None:
    name = getattr(rewrite, "__name__", "")
    (tmp_path / "core.xml").write_text(mcpn("convert", GLIDER, "--pass", name).stdout)
    assert read_mission(tmp_path / "core.xml") == core(read_mission(GLIDER), until=name)


def test_a_printed_core_mission_is_answered_as_the_mission(tmp_path: Path) -> None:
    printed = mcpn("convert", ULYSSE, "--pass", PASSES[-1].__name__).stdout
    assert 'core="true"' in printed
    assert 'name="transect.diving"' in printed
    (tmp_path / "core.xml").write_text(printed)
    asked = ("AG EF (success | failure)", "EF objective(diving)")
    assert mcpn("ask", tmp_path / "core.xml", *asked) == mcpn("ask", ULYSSE, *asked)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--pass", "none"), "found --pass none, expected one of done, "),
        (("--pass", "uses", "out.xml"), "expected no TARGET"),
        (("--pass", "uses", "--json"), "expected no TARGET"),
        ((), "Missing argument 'TARGET'"),
    ],
)
def test_what_does_not_fit_is_refused(options: tuple[str, ...], said: str) -> None:
    found = mcpn("convert", ULYSSE, *options)
    assert (found.returncode, said in found.stderr) == (2, True)
