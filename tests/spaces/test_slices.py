"""A question to a diagram ends when its slice of time is spent; who listened before listens again."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

from mcpn.spaces.diagrams.slices import within_seconds


def test_work_ends_when_its_slice_is_spent() -> None:
    heard = list[int]()
    store = SimpleNamespace(progress=heard.append)
    left = ["not ended"]
    with within_seconds(cast("Any", store), -1):
        store.progress(7)
        left.clear()
    assert left == ["not ended"]
    assert heard == [7]
    assert store.progress == heard.append


def test_work_within_its_slice_is_let_be() -> None:
    store = SimpleNamespace(progress=None)
    done = list[str]()
    with within_seconds(cast("Any", store), 1e9):
        cast("Any", store).progress(7)
        done.append("all")
    assert done == ["all"]
    assert store.progress is None
