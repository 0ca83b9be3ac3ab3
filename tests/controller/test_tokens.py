"""The token game: by the net's own rule, back and forward, at a prompt and from a pipe."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from hypothesis import given
from hypothesis import strategies as st

from mcpn.cli.line import command_line
from mcpn.drawing.compose import MissionNet
from mcpn.errors import DivergenceError, InputError, LimitError, McpnError
from mcpn.nets import game as module
from mcpn.nets.game import TokenGame
from mcpn.nets.petri import NetBuilder, PetriNet
from tests.conftest import ULYSSE
from tests.drawing.settling import stabilise
from tests.nets.nets import pt_nets

WEIGHTED = "net n\npl p (3)\ntr t p*2 r?1 -> q\ntr u q -> p*2\npl r (1)\n"


def play(file: Path, *arguments: str, typed: str = "") -> Result:
    return CliRunner().invoke(command_line, ["simulate", str(file), *arguments], input=typed)


@given(
    pt_nets(), st.lists(st.sampled_from(["fire", "fire", "fire", "back", "forward"]), max_size=20), st.data()
)
def test_back_and_forward_go_along_the_run(net: PetriNet, moves: list[str], data: st.DataObject) -> None:
    game = TokenGame(net)
    markings, at = [net.initial], 0
    for move in moves:
        if move == "fire" and game.enabled:
            assert game.enabled == net.enabled(markings[at])
            chosen = data.draw(st.sampled_from(game.enabled))
            game.fire(chosen)
            markings, at = [*markings[: at + 1], net.fire(markings[at], chosen)], at + 1
        elif move == "back":
            assert (game.back() is None) == (at == 0)
            at = max(at - 1, 0)
        elif move == "forward":
            assert (game.forward() is None) == (at == len(markings) - 1)
            at = min(at + 1, len(markings) - 1)
        assert game.marking == markings[at]
        assert len(game.run) == at
    game.restart()
    assert game.marking == net.initial


def test_it_settles_where_the_net_does(ulysse_net: MissionNet) -> None:
    game = TokenGame(ulysse_net.net)
    for _ in range(12):
        events = game.enabled
        assert not any(ulysse_net.net.transitions[t].internal for t in events)
        game.fire(events[-1])
        expected, before = stabilise(ulysse_net.net, game.marking), len(game.run)
        fired = game.settle()
        assert game.marking == expected
        assert game.run[before:] == fired


@pytest.mark.parametrize(
    ("produced", "error", "said"),
    [
        (["p"], DivergenceError, "never ends: firing 1 comes back"),
        (["p", "more"], LimitError, "no stable marking after 10 internal firings"),
    ],
)
def test_what_does_not_settle_is_an_error(
    produced: list[str], error: type[McpnError], said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "MOST_FIRED", 10)
    builder = NetBuilder("endless", priorities=True)
    builder.place("p", initial=1)
    builder.place("more")
    builder.transition("again", consume=["p"], produce=produced)
    game = TokenGame(builder.build())
    with pytest.raises(error, match=said):
        game.settle()
    assert (game.run, game.forward()) == ((), None)


def test_a_missions_net_is_played_firing_by_firing() -> None:
    told = play(ULYSSE, "--tokens", typed="GPS_sensor\nback\nforward\nsettle\nrun\nrestart\n").stdout
    assert "GPS_sensor_EV_OOS_f: GPS_sensor_free 1 -> 0, GPS_sensor_failing 0 -> 1" in told
    assert "   1  GPS_sensor_3: GPS_sensor_failing + GPS_sensor_available -> GPS_sensor_OOS" in told
    assert "> run\n    GPS_sensor_EV_OOS_f\n    GPS_sensor_3\n" in told
    assert told.rstrip().endswith("manual_moving_Start + OBJ_coral_head.manual_moving")


def test_a_net_from_elsewhere_is_played_so(tmp_path: Path) -> None:
    (tmp_path / "n.net").write_text(WEIGHTED)
    told = play(tmp_path / "n.net", typed="1\n").stdout
    assert "marked  p 3, r" in told
    assert "   1  t: 2 p ?r -> q" in told
    assert "t: p 3 -> 1, q 0 -> 1" in told
    found = json.loads(play(tmp_path / "n.net", "--random", "3", "--json").stdout)
    assert [step["transition"] for step in found["fired"]] == ["t", "u", "t"]
    assert found["marking"] == {"p": 1, "q": 1, "r": 1}


@pytest.mark.parametrize(
    ("typed", "told"),
    [
        ("9\n", "found the number 9, expected one from 1 to 1"),
        ("t\nt\n", "found 't', expected a possible transition"),
        ("back\n", "nothing to go back to"),
        ("forward\n", "nothing to go forward to"),
    ],
)
def test_what_cannot_be_done_in_a_pipe_is_an_error(typed: str, told: str, tmp_path: Path) -> None:
    (tmp_path / "n.net").write_text(WEIGHTED)
    result = play(tmp_path / "n.net", typed=typed)
    assert isinstance(result.exception, InputError)
    assert told in str(result.exception)
    assert "standard input:" in str(result.exception)


def test_events_of_a_file_are_of_a_mission(tmp_path: Path) -> None:
    (tmp_path / "n.net").write_text(WEIGHTED)
    result = play(tmp_path / "n.net", "--events", str(tmp_path / "n.net"))
    assert result.exit_code == 2
    assert "--events are of a mission" in result.output
