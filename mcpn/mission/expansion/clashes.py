"""Copies of blocks, rounds and tries, whose names clash with those of other blocks."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice, product

from mcpn.errors import Problem
from mcpn.mission.expansion.scope import MAX_OBJECTIVES
from mcpn.mission.language.datatypes import MAX_ROUNDS
from mcpn.mission.model import Block, Each, Holder, walk


def clashes(blocks: tuple[Block, ...]) -> Iterator[Problem]:
    """Copies of a block that would bear the name of another block, or of another's copy, in one text."""
    named: dict[str, Block] = {block.name: block for block in walk(blocks)}
    names = ((block, name) for block, name in _copies(blocks) if name != block.name)
    for block, name in islice(names, MAX_OBJECTIVES):  # with more, flattening hits its limit
        other = named.setdefault(name, block)
        if other.name != block.name:  # else it is the same, or declared twice
            where = f" ({other.source})" if other.source else ""
            message = f"{name}, a round or a try of {block.name}, would have the name of another block"
            yield Problem(block.source, f"{message}: {other.name}{where}")
            return


def _copies(blocks: tuple[Block, ...]) -> Iterator[tuple[Block, str]]:
    """Every block with the name of each of its copies in its own text."""
    stack: list[tuple[Block, tuple[str, ...]]] = [(block, ("",)) for block in blocks]
    while stack:
        block, values = stack.pop()
        rounds = [f"_{n}" for n in range(1, min(block.repeat or 0, MAX_ROUNDS) + 1)] or [""]
        most = min(block.retries, MAX_ROUNDS)
        tries = [f"_try{n}" for n in range(1, most + 2)] if most > 0 else [""]
        for value, number, attempt in product(values, rounds, tries):
            yield block, f"{block.name}{value}{number}{attempt}"
        if isinstance(block, Holder):
            inner = tuple(f"_{value}" for value in block.values) if isinstance(block, Each) else ("",)
            stack.extend((child, inner) for child in block.blocks)
