"""Finds copies of blocks (rounds, tries, runs) that would have the name of another block."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice, product

from mcpn.errors import Problem
from mcpn.mission.language.datatypes import MAX_ROUNDS
from mcpn.mission.model import Block, Each, Holder, Parallel, walk
from mcpn.mission.rewriting.limits import MAX_OBJECTIVES
from mcpn.mission.rewriting.siblings import recovering, suffixes


def clashes(blocks: tuple[Block, ...]) -> Iterator[Problem]:
    """Copies of a block that would bear the name of another block, or of another's copy, in one text."""
    named: dict[str, Block] = {block.name: block for block in walk(blocks)}
    copied = ((block, name) for block, name in _copies(blocks) if name != block.name)
    for block, name in islice(copied, MAX_OBJECTIVES):  # with more, flattening hits its limit
        other = named.setdefault(name, block)
        if other.name != block.name:  # else it is the same block, or one declared twice
            where = f" ({other.source})" if other.source else ""
            message = f"{name}, a round, a try or a run of {block.name}, would have the name of another block"
            yield Problem(block.source, f"{message}: {other.name}{where}")
            return


def _copies(blocks: tuple[Block, ...]) -> Iterator[tuple[Block, str]]:
    """Every block with the name of each of its copies in its own text."""
    stack: list[tuple[tuple[Block, ...], tuple[str, ...]]] = [(blocks, ("",))]
    while stack:
        siblings, values = stack.pop()
        aside = recovering(siblings)
        for block in reversed(siblings):
            runs = [f"_run{n}" for n in range(1, block.times + 2)] if block.recover else [""]
            rounds = [f"_{n}" for n in range(1, min(block.repeat or 0, MAX_ROUNDS) + 1)] or [""]
            most = min(block.retries, MAX_ROUNDS)
            tries = [f"_try{n}" for n in range(1, most + 2)] if most > 0 else [""]
            runs += [f"_{suffix}" for suffix in suffixes(aside.get(block.name, ()))]
            for value, run, number, attempt in product(values, runs, rounds, tries):
                yield block, f"{block.name}{value}{run}{number}{attempt}"
            if isinstance(block, Holder):
                inner = tuple(f"_{value}" for value in block.values) if isinstance(block, Each) else ("",)
                branches = ((child,) for child in block.blocks)
                stack.extend(
                    (blocks, inner)
                    for blocks in (branches if isinstance(block, Parallel) else (block.blocks,))
                )
