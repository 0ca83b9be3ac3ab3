"""Moves in columns, and edges of documents as rows: they say what lists of objects would say."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcpn.controller.document import document, document_in_rows
from mcpn.controller.generate import generate
from mcpn.controller.machine import PlannedAction
from mcpn.controller.moves import Move, Moves
from mcpn.drawing.compose import compose
from mcpn.drawing.forgetful import ALWAYS, Guard
from mcpn.mission.xml import read_mission
from mcpn.robot.runtime.file_schema import digest_of
from mcpn.robot.targets.json import canonical, write_json
from mcpn.robot.targets.rows import AT_ONCE, Rows
from tests.conftest import ULYSSE

NAMES = st.text(max_size=3)
MOVES = st.builds(
    Move,
    st.integers(0, 9),
    st.integers(0, 9),
    st.integers(0, 9) | st.sampled_from(("success", "failure")),
    st.sampled_from(((), (PlannedAction("stop", "a"),))),
    st.sampled_from((ALWAYS, Guard(("once",), ()))),
    st.sampled_from(((), ("f=1",))),
)


@given(st.lists(MOVES, max_size=6), st.slices(6))
def test_columns_hold_the_moves(moves: list[Move], some: slice) -> None:
    held = Moves.of(moves)
    assert [*held] == moves
    assert [held[number] for number in range(len(held))] == moves
    assert [*held[some]] == moves[some]
    assert held == moves
    assert (held == moves[1:]) == (not moves)


ROWS = st.lists(st.tuples(st.integers(0, 9) | NAMES, NAMES, st.integers(0, 1)), max_size=4)


@settings(max_examples=25)
@given(ROWS, NAMES)
def test_rows_are_written_as_their_objects(rows: list[tuple[int | str, str, int]], name: str) -> None:
    """Whatever their keys and values hold: what leaves gaps in a text, too."""
    rows *= AT_ONCE // 2  # more than are written together, now and then
    key = f"%s{name}"
    shared: list[dict[str, Any]] = [{key: ["%d"]}, {key: {"b": "ä", "a": 1}}]
    columns: dict[str, list[int | str]] = {"to": [row[0] for row in rows], "from": [row[1] for row in rows]}
    written = Rows(("to", key, "from"), columns, [row[2] for row in rows], shared)
    plain = [*written]
    assert [[*row.items()] for row in plain] == [
        [("to", to), (key, shared[kind][key]), ("from", at)] for to, at, kind in rows
    ]
    assert [*written[1:3]] == plain[1:3]
    assert "".join(canonical({"rows": written, "a": 1})) == json.dumps(
        {"rows": plain, "a": 1}, sort_keys=True, ensure_ascii=False, separators=(",", ":")
    )
    assert write_json({"k": [{"rows": written}]}) == write_json({"k": [{"rows": plain}]})


@pytest.mark.parametrize("form", ["flat", "hierarchical"])
def test_documents_in_rows_are_the_documents(form: str) -> None:
    net = compose(read_mission(ULYSSE))
    found = generate(net, "flat" if form == "flat" else "hierarchical")
    plain, rows = document(found, net), document_in_rows(found, net)
    assert write_json(rows) == write_json(plain)
    assert rows["digest"] == digest_of(plain) == plain["digest"]
    assert json.loads(json.dumps(plain)) == plain
    assert len(plain["types"][0]["edges"]) == len(rows["types"][0]["edges"])
