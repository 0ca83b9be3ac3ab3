"""Two missions compared: what the second loses or gains."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from mcpn.answers.claims import Claim
from mcpn.answers.versions import Apart, VersionDifference, compared
from mcpn.errors import InputError
from mcpn.mission.xml import read_mission
from mcpn.report.versions import print_difference
from mcpn.study import Study
from tests.commands import mcpn
from tests.conftest import ULYSSE

TEXT = (
    '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r">{hardware}<event name="low"/>{film}'
    '<activity name="rest"/></robot>'
    '<objective name="survey" activities="film" success="succeed">{inside}</objective>'
    '<objective name="home" activities="rest" success="abort" failure="home"/></mission>'
)
BOTH = '<hardware name="camera"/><hardware name="sonar"/>'
EYE, EAR = '<alternative name="eye" consumes="camera"/>', '<alternative name="ear" consumes="sonar"/>'
TWO, ONE = (f'<activity name="film">{ways}</activity>' for ways in (EYE + EAR, EYE))
GOES = '<on event="low" goto="home"/>'


def write(folder: Path, name: str, **parts: str) -> Path:
    path = folder / name
    path.write_text(TEXT.format(**{"hardware": BOTH, "film": TWO, "inside": GOES, **parts}))
    return path


def of(first: Path, second: Path) -> VersionDifference:
    before, after = (Study(read_mission(path)).mission_spaces() for path in (first, second))
    return compared(before, after)


def keys(changed: object) -> set[str]:
    assert isinstance(changed, list)
    return {each.after.key for each in changed}


def test_a_mission_is_like_itself() -> None:
    assert of(ULYSSE, ULYSSE).same


def test_an_alternative_less_is_a_loss_and_one_more_a_gain(tmp_path: Path) -> None:
    two, one = write(tmp_path, "two.xml"), write(tmp_path, "one.xml", film=ONE)
    forth, back = of(two, one), of(one, two)
    assert "loss_defeats: camera" in keys(forth.lost)
    assert keys(forth.lost) == keys(back.gained)
    assert keys(forth.gained) == keys(back.lost)
    assert forth.cut_sets["success, lost before the start"] == ([("camera", "sonar")], [("camera",)])
    assert forth.modes["survey"] == (["film: ear"], [])
    assert back.modes["survey"] == ([], ["film: ear"])


def test_an_event_that_nothing_handles_any_more_is_a_loss(tmp_path: Path) -> None:
    found = of(write(tmp_path, "a.xml"), write(tmp_path, "b.xml", inside=""))
    assert "ignored: low, survey" in keys(found.lost)
    assert "can_be_aborted" in {claim.key for claim in found.claims.first}


def test_what_only_one_has_is_no_loss(tmp_path: Path) -> None:
    """Nothing is said of hardware that the other mission does not have."""
    more = write(tmp_path, "more.xml", hardware=f'{BOTH}<hardware name="lamp"/>')
    found = of(write(tmp_path, "a.xml"), more)
    assert found.gained == found.lost == []
    assert {claim.subject[0] for claim in found.claims.second} == {"lamp"}


def test_missions_that_have_nothing_in_common_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no objective and no hardware in common with m"):
        of(write(tmp_path, "a.xml"), ULYSSE)


def test_the_command_says_what_differs(tmp_path: Path) -> None:
    two, one = write(tmp_path, "two.xml"), write(tmp_path, "one.xml", film=ONE)
    assert mcpn("compare", two, two).returncode == 0
    run = mcpn("compare", two, one)
    assert run.returncode == 1
    said = " ".join(run.stdout.split())
    assert "The loss of camera alone, at its worst moment, leaves no way to success." in said
    assert f"survey: only in {two}: film: ear" in said
    found = json.loads(mcpn("compare", two, one, "--json").stdout)
    assert not found["same"]
    assert found["modes"] == {"survey": {"first": ["film: ear"], "second": []}}


def requiring(folder: Path, name: str, requirement: str) -> Path:
    path = write(folder, name)
    path.write_text(path.read_text().replace("</robot>", f"</robot>{requirement}"))
    return path


@pytest.mark.parametrize(
    ("now", "asks"),
    [
        ('formula="EF success"', "EF success"),
        ('formula="AG EF success" expected="fails"', "AG EF success (must not hold)"),
        ('formula="AG EF success" severity="advice"', "AG EF success (advice)"),
        ('formula="AG EF success" fair="true"', "AG EF success (of fair runs alone)"),
    ],
)
def test_a_requirement_that_asks_something_else_differs(tmp_path: Path, now: str, asks: str) -> None:
    """Both may be met, or both not: that the second asks less is a difference all the same."""
    first = requiring(tmp_path, "a.xml", '<requirement name="r" formula="AG EF success"/>')
    second = requiring(tmp_path, "b.xml", f'<requirement name="r" {now}/>')
    found = of(first, second)
    assert found.requirements == {"r": ("AG EF success", asks)}
    assert not found.same
    run = mcpn("compare", first, second)
    assert run.returncode == 1
    assert f"r: AG EF success; then: {asks}" in " ".join(run.stdout.split())
    described = requiring(
        tmp_path, "c.xml", '<requirement name="r" formula="AG EF success" description="d"/>'
    )
    assert of(first, described).same


def test_a_requirement_of_one_alone_that_is_not_met_is_told(tmp_path: Path) -> None:
    plain = write(tmp_path, "a.xml")
    for severity in ("required", "advice"):
        more = requiring(
            tmp_path, "b.xml", f'<requirement name="r" formula="AG success" severity="{severity}"/>'
        )
        for files in ((plain, more), (more, plain)):
            run = mcpn("compare", *files)
            assert run.returncode == 1
            assert f"what is said of {more} alone" in run.stdout
            assert "Requirement r is not met." in run.stdout


def test_a_difference_is_never_told_by_no_line(capsys: pytest.CaptureFixture[str]) -> None:
    claim = Claim("ignored", ("low", "survey"), False)
    print_difference(VersionDifference(claims=Apart((), (claim,))), "a.xml", "b.xml")
    assert "--json lists it" in capsys.readouterr().out


def test_what_cannot_be_compared_is_an_error_with_its_file(tmp_path: Path) -> None:
    net = tmp_path / "n.net"
    net.write_text("net n\npl p (1)\ntr t p -> p\n")
    run = mcpn("compare", write(tmp_path, "a.xml"), net)
    assert run.returncode == 2
    assert "n.net" in run.stderr
    assert "found a net, expected a mission" in run.stderr
    assert mcpn("compare", ULYSSE, ULYSSE, "--format", "csv").returncode == 2
    run = mcpn("compare", ULYSSE, write(tmp_path, "a.xml"))
    assert run.returncode == 2
    assert "in common with" in run.stderr
