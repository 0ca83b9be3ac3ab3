"""Campaigns of mutants from the command line: how many, from which seed, of what, and by which checkers."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Callable, Iterable
from typing import TypeAlias

Campaign: TypeAlias = Callable[[str, int, int, bool], tuple[Counter[str], list[str]]]
"""Of what, how many mutants, from which seed, and whether the checkers in C++ are asked, too."""


def ran(words: str, kinds: Iterable[str], campaign: Campaign, arguments: list[str] | None = None) -> int:
    """Runs the campaigns that the command line asks for, and prints what became of the mutants.

    Args:
        words: What is changed.
        kinds: What there are campaigns of.
        campaign: Runs one.
        arguments: The command line.

    Returns:
        The exit code: 1 if something false was accepted.
    """
    parser = argparse.ArgumentParser(description=words)
    parser.add_argument("--mutants", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--second", action="store_true", help="ask the checkers in C++, too")
    parser.add_argument("--of", choices=[*kinds], action="append")
    asked, every = parser.parse_args(arguments), list[str]()
    for of in asked.of or kinds:
        found, wrong = campaign(of, asked.mutants, asked.seed, asked.second)
        for how, times in sorted(found.items()):
            print(f"{times:6} {how}")
        print(f"{of}: {asked.mutants} mutants, {len(wrong)} wrongly accepted")
        every += wrong
    print("\n".join(every))
    return 1 if every else 0


def is_so(judge: Callable[[dict[str, object]], bool], claim: dict[str, object]) -> bool:
    """Whether a claim is true; one that says nothing which can be understood is not."""
    try:
        return judge(claim)
    except (KeyError, IndexError, TypeError, ValueError, AttributeError):
        return False
