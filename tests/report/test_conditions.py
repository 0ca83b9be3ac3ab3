"""Sentences of failure."""

from __future__ import annotations

from mcpn.report.causes import condition


def test_sentences() -> None:
    assert condition("x", [("A",), ("B", "C", "D")]) == "x fails if A, or if B, C and D"
    assert condition("x", [()]) == "x can never succeed"
