"""Files that are read back are whole: a flipped bit is found, and numbers that Python cannot hold."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from mcpn.cli.play.event_files import events_of_file
from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.controller.monitors.writing import files, monitors_of
from mcpn.drawing.compose import compose
from mcpn.errors import InputError
from mcpn.mission.xml import read_mission
from mcpn.robot.runtime import Controller, DamagedFile, Journal, Monitors
from mcpn.robot.runtime.controller_tables import read
from mcpn.robot.runtime.file_schema import parsed, signed_line
from mcpn.robot.runtime.journal import read_journal
from mcpn.robot.runtime.monitors import watch
from mcpn.robot.runtime.restoring import read_snapshot
from mcpn.robot.targets.json import write_json
from mcpn.study import open_study
from tests.drivers.test_records import LOOP, ONCE


def kinds(folder: Path) -> dict[str, tuple[bytes, Callable[[Path], object]]]:
    """By kind of file, one as it is written, and what it means when it is read back."""
    path = folder / "mission.xml"
    path.write_text(LOOP.format(requirement=ONCE))
    net = compose(read_mission(path))
    controller = Controller.from_document(document(generate(net), net))
    monitors = Monitors(json.loads(files(monitors_of(open_study(path).mission_spaces()))["monitors.json"]))
    log = folder / "log"
    with log.open("w") as stream:
        journal = Journal(stream)
        controller.observe(journal)
        for event in ("MISSION_EV_START", "H_EV_OOS", "OBJ_o_0_EV_FAIL"):
            controller.handle(event)
            monitors.take(event)
        journal.resumed(3)
    beside = {"monitors": {"digest": monitors.digest, "state": monitors.state}}
    text = files(monitors_of(open_study(path).mission_spaces()))["monitors.json"]

    def watched(path: Path) -> object:
        fresh = Monitors(json.loads(text))
        watch(fresh, path.read_text().splitlines())
        return fresh.count, fresh.state

    tables = controller._tables

    def snapshot(path: Path) -> object:
        saved = read_snapshot(path.read_text(), tables)
        return parsed(saved.text(tables.digest))

    return {
        "controller": (write_json(document(generate(net), net)).encode(), lambda path: read(path).digest),
        "monitors": (
            files(monitors_of(open_study(path).mission_spaces()))["monitors.json"].encode(),
            lambda path: Monitors.load(path).digest,
        ),
        "snapshot": (controller.snapshot(beside).encode(), snapshot),
        "journal": (
            log.read_bytes(),
            lambda path: [*map(meant, read_journal(path.read_text().splitlines()))],
        ),
        "journal, replayed": (log.read_bytes(), lambda path: [*events_of_file(path)]),
        "journal, watched": (log.read_bytes(), watched),
    }


def meant(told: Any) -> tuple[str, bool, int | None]:
    return told.event, told.refused, told.number


def flipped(folder: Path, times: int) -> dict[str, int]:
    """Flips bits of each kind of file, one at a time: none is read with another meaning."""
    rng, path, same = random.Random(11), folder / "file", dict[str, int]()
    for kind, (whole, means) in kinds(folder).items():
        path.write_bytes(whole)
        expected = means(path)
        same[kind] = 0
        for bit in (rng.randrange(8 * len(whole)) for _ in range(times)):
            changed = bytearray(whole)
            changed[bit // 8] ^= 1 << bit % 8
            path.write_bytes(changed)
            try:
                found = means(path)
            except (DamagedFile, InputError, UnicodeDecodeError):
                continue
            assert found == expected, (kind, bit)
            same[kind] += 1
    return same


def test_a_flipped_bit_is_found(tmp_path: Path) -> None:
    same = flipped(tmp_path, 200)
    assert all(count < 20 for count in same.values())  # a space, a capital letter of an escape


@pytest.mark.slow
def test_ten_thousand_flipped_bits_are_found(tmp_path: Path) -> None:
    print(flipped(tmp_path, 10_000))  # noqa: T201


def test_numbers_that_python_cannot_hold_are_told(tmp_path: Path) -> None:
    """What is nested for ever, or is no number, is an error of the one tree."""
    monitors = json.loads(kinds(tmp_path)["monitors"][0])
    path = tmp_path / "file"
    for text in (
        "[" * 100_000,
        '{"a":' * 100_000,
        "1" * 5000,
        json.dumps(monitors | {"version": float("inf")}),
    ):
        path.write_text(text)
        for load in (Monitors.load, read):
            with pytest.raises(DamagedFile):
                load(path)
    assert signed_line({"a": 1, "digest": "x"}) == signed_line({"a": 1})
