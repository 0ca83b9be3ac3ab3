"""Sets of templates on the command line: every command that composes a mission draws with them."""

from __future__ import annotations

from pathlib import Path

import pytest

from mcpn.spaces.engine_names import SPACE_ENGINES
from tests.commands import mcpn, output
from tests.conftest import ULYSSE

MINE = '''
from mcpn.events import What
from mcpn.drawing.templates import PaperTemplates

class Unrepaired(PaperTemplates):
    """Hardware that stays out of service."""

    def hardware(self, canvas, resource):
        draw = canvas.transition
        canvas.transition = lambda name, *, event=None, **arcs: (
            event and event.what is What.REPAIRED or draw(name, event=event, **arcs)
        )
        super().hardware(canvas, resource)
        del canvas.transition

WRONG = 3
'''
RETURNS = "GPS_sensor_EV_RD"


@pytest.fixture
def mine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    Path("mine_of_test_cli.py").write_text(MINE)
    return "mine_of_test_cli:Unrepaired"


def test_missions_are_checked_with_them(mine: str) -> None:
    usual = output("check", ULYSSE)
    assert output("check", ULYSSE, "--templates", "paper")["alternatives"] == usual["alternatives"]
    for engine in ("explicit", "symbolic", "local"):
        found = output("check", ULYSSE, "--templates", mine, "--engine", engine)
        assert found["transitions"] == usual["transitions"] - 3
        assert found["alternatives"]["edges"] < usual["alternatives"]["edges"]
        assert found["verdicts"]["can_always_finish"]


def test_questions_are_asked_with_them(mine: str) -> None:
    asked = ("ask", ULYSSE, f"E F happens({RETURNS})")
    assert output(*asked)[0]["holds"]
    assert mcpn(*asked, "--templates", mine).returncode == 2  # there is no such event
    assert not output("ask", ULYSSE, "AG EF !oos(GPS_sensor)", "--templates", mine, code=1)[0]["holds"]


@pytest.mark.parametrize("engine", SPACE_ENGINES)
def test_spaces_are_built_with_them(mine: str, engine: str) -> None:
    given = ("--engine", engine, "--templates", mine)
    found = output("alternatives", ULYSSE, *given)
    assert found["edges"] < 1332
    assert output("states", ULYSSE, "--on", "alternatives", *given)["stable_states"] == found["states"]
    assert output("states", ULYSSE, "--order", _order(), "--templates", mine)["transitions"] == 147


def _order() -> Path:
    assert mcpn("states", ULYSSE, "--save-order", "order.json").returncode == 0
    return Path("order.json")


def test_a_section_is_drawn_with_them(mine: str) -> None:
    section = ("--section", "coral_head.manual_moving")
    for kind in ("net", "alternatives", "controller"):
        asked = ("convert", ULYSSE, "part.svg", "--draw", kind, *section)
        assert mcpn(*asked).returncode == 0
        usual = Path("part.svg").read_text()
        assert mcpn(*asked, "--templates", mine).returncode == 0
        found = Path("part.svg").read_text()
        word = "EV_RD" if kind == "net" else "works again"
        assert word in usual, kind
        assert word not in found, kind


@pytest.mark.parametrize("form", ["flat", "hierarchical", "modular"])
def test_controllers_are_made_with_them(mine: str, form: str) -> None:
    asked = ("controller", ULYSSE, "--form", form, "-o", "build")
    assert mcpn(*asked).returncode == 0
    assert RETURNS in Path("build/controller.json").read_text()
    assert mcpn(*asked, "--templates", mine).returncode == 0
    assert RETURNS not in Path("build/controller.json").read_text()


def test_nets_and_reports_are_written_with_them(mine: str) -> None:
    assert mcpn("convert", ULYSSE, "net.pnml", "--templates", mine).returncode == 0
    assert RETURNS not in Path("net.pnml").read_text()
    assert mcpn("report", ULYSSE, "-o", "page.html", "--templates", mine).returncode == 0
    assert "<td>event edges<td>751" in Path("page.html").read_text()


def test_missions_are_played_with_them(mine: str) -> None:
    Path("events.txt").write_text("MISSION_EV_START\nGPS_sensor_EV_OOS\n")
    for how in (("--events", "events.txt"), ("--random", "400", "--tokens")):
        asked = ("simulate", ULYSSE, *how)
        assert "EV_RD" in mcpn(*asked).stdout
        found = mcpn(*asked, "--templates", mine)
        assert found.returncode == 0
        assert "EV_RD" not in found.stdout


def test_causes_and_tests_are_found_with_them(mine: str) -> None:
    usual, found = output("causes", ULYSSE), output("causes", ULYSSE, "--templates", mine)
    assert found["mission"]["cut_sets"] == usual["mission"]["cut_sets"]
    assert found["mission"]["critical"] != usual["mission"]["critical"]
    assert mcpn("tests", ULYSSE, "-o", "sequences", "--templates", mine).returncode == 0
    assert RETURNS not in Path("sequences/events.txt").read_text()


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("no_such_module:X", "templates no_such_module:X cannot be loaded: ModuleNotFoundError"),
        ("mine_of_test_cli:NoSuch", "cannot be loaded: AttributeError"),
        ("mine_of_test_cli:WRONG", "found no hardware, software, activity, control"),
        ("papers", "found the templates 'papers', expected "),
    ],
)
def test_what_is_no_set_is_refused(mine: str, name: str, told: str) -> None:
    for command in (("check", ULYSSE), ("controller", ULYSSE, "-o", "build"), ("convert", ULYSSE, "n.net")):
        found = mcpn(*command, "--templates", name)
        assert (found.returncode, found.stdout) == (2, "")
        assert told in found.stderr
        assert found.stderr.startswith("error: ")
    assert not Path("build").exists()
    assert not Path("n.net").exists()


def test_templates_draw_missions_and_no_nets(mine: str) -> None:
    assert mcpn("convert", ULYSSE, "net.pnml").returncode == 0
    found = mcpn("check", "net.pnml", "--templates", mine)
    assert found.returncode == 2
    assert "net.pnml: found a net, expected a mission: templates draw missions" in found.stderr
