"""Pauses are written out: for each objective of a block a copy of the sibling that runs while it pauses.

An event stops what runs in the block, the sibling runs, and the block goes on where it was. Each copy stands
behind the block and says what it ``resumes`` as it succeeds, so the copy that runs says where the block was,
and nothing else has to remember it. A parallel block may be at many places: it has one copy. What a copy
fails by is the failure of the block, or of the last of its runs, for no reason.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from mcpn.errors import InputError, Problem
from mcpn.mission.model import FAIL, UNNAMED, Block, Handler, Mission, Objective, Parallel, Recursive, walk
from mcpn.mission.rewriting.copying import copied
from mcpn.mission.rewriting.handlers_in_effect import in_effect
from mcpn.mission.rewriting.limits import Counted
from mcpn.mission.rewriting.siblings import entered, pausing, recovering
from mcpn.records import record


def pauses(mission: Mission) -> Mission:
    """What runs while blocks pause is written out, a copy for each objective (`pause`)."""
    if not any(handler.pause for block in walk(mission.blocks) for handler in block.handlers):
        return mission
    return replace(mission, blocks=_PauseCopies().series(mission.blocks, mission.handlers))


@record()
class _Stopped:
    """What a pause stops: an objective, or a whole parallel block.

    Args:
        block: The block.
        also: What runs while a block in the one that pauses does, the parallel block staying where it is.
        handlers: Those of events in effect here or in ``also``, each with the name of its block.
    """

    block: Block
    also: list[Block]
    handlers: list[tuple[str, Handler]]


class _PauseCopies:
    def __init__(self) -> None:
        self.made = set[str]()
        """Names of copies."""
        self.helping = set[str]()
        """Names of siblings of which copies are made."""
        self.counted = Counted()

    def series(self, blocks: tuple[Block, ...], around: Sequence[Handler] = ()) -> tuple[Block, ...]:
        """A series with copies of its blocks that run while others pause, under handlers that lead to it."""
        if not pausing(blocks):
            return tuple([self.inside(block) for block in blocks])
        named = {block.name: block for block in blocks}
        aside = {*recovering(blocks), *pausing(blocks)} - entered(blocks, around)
        known = {(block.resumes, runs_for(block)) for block in blocks if block.resumes}
        runs, made = dict[str, tuple[int, set[str]]](), list[Block]()
        for block in sorted(blocks, key=lambda block: block.name in aside):
            if block.name in aside & self.helping:
                continue  # of one that helps none it is said that it is never entered
            begin, names = len(made), set[str]()
            made.append(self.inside(block))
            if not any(handler.pause for handler in block.handlers):
                continue
            last = next((each.fails_as for each in block.handlers if each.fails_as), block.name)
            begin, names = runs.pop(last, (begin, names))
            names.add(block.name)
            if last != block.name:
                runs[last] = begin, names
                continue
            for at in [*_stopped(made[begin:])]:
                _refuse_left_by_facts(at)
                for handler in _pausing(at, names):
                    if (at.block.name, handler.pause) not in known:
                        made.append(self.copy(handler, named, at.block, block))
        return tuple(made)

    def inside(self, block: Block) -> Block:
        """A block with such copies inside."""
        if isinstance(block, Objective):
            self.counted.add(len(block.parameters), block.source)
        elif isinstance(block, Recursive):
            return replace(block, blocks=self.series(block.blocks))
        elif isinstance(block, Parallel):
            return replace(block, blocks=tuple([self.inside(child) for child in block.blocks]))
        return block

    def copy(self, handler: Handler, named: Mapping[str, Block], at: Block, failing: Block) -> Block:
        """What runs while something in a block is stopped; its failure is that of a block.

        Raises:
            InputError: It is not there, or the copy would bear the name of another one.
        """
        by = named.get(handler.pause or "")
        if by is None:
            message = f"{handler.pause} has no copy that resumes {at.name}, and is none of its siblings"
            raise InputError.at(handler.source, f"{message}; expected one of both")
        copy = copied(by, f"at_{at.name.removeprefix(by.prefix).replace('.', '_')}")
        if copy.name in self.made:
            message = f"two copies of {by.written} would be called {copy.name}"
            raise InputError.at(by.source, f"{message}: rename one of the blocks that pause")
        self.made.add(copy.name)
        self.helping.add(by.name)
        unnamed, failure = {FAIL: UNNAMED}, failing.failure or FAIL
        left = [route for route in failing.routes if route.on == "failure" and route.reason is None]
        routes = [replace(route, goto=unnamed.get(route.goto, route.goto)) for route in left]
        routes += [route for route in by.routes if route.on in ("abort", "timeout")]
        failure = unnamed.get(failure, failure)
        return self.inside(
            replace(copy, success=None, failure=failure, routes=tuple(routes), resumes=at.name)
        )


def runs_for(copy: Block) -> str:
    """The name of the sibling that a copy which resumes something is one of, as the handlers name it."""
    return copy.own[: len(copy.own) - len(copy.copy[-1]) - 1] if copy.copy else copy.name


def _stopped(blocks: Iterable[Block], around: Sequence[tuple[str, Handler]] = ()) -> Iterator[_Stopped]:
    """What is stopped at once in blocks, with copies inside, under handlers around them."""
    found = dict[str, _Stopped]()
    for block in blocks:
        if block.resumes in found and isinstance(found[block.resumes].block, Parallel):
            at = found[block.resumes]
            at.also.append(block)
            at.handlers += _in_effect(around)
            continue
        own = [(block.name, handler) for handler in block.handlers if handler.event is not None]
        if isinstance(block, Recursive):
            found |= {at.block.name: at for at in _stopped(block.blocks, (*own, *around))}
        else:
            found[block.name] = _Stopped(block, [], _in_effect((*own, *around)))
    yield from found.values()


def _in_effect(handlers: Iterable[tuple[str, Handler]]) -> list[tuple[str, Handler]]:
    """Those in effect, each with the name of its block."""
    return in_effect(handlers, lambda said: said[1].event, lambda said: said[1].once)


def _pausing(at: _Stopped, runs: Collection[str]) -> list[Handler]:
    """The handlers of a block, or of its runs, by which it pauses there: one for each sibling."""
    own = (handler for name, handler in at.handlers if name in runs and handler.pause)
    found = dict[str | None, Handler]()
    for handler in own:
        found.setdefault(handler.pause, handler)
    return [*found.values()]


def _refuse_left_by_facts(at: _Stopped) -> None:
    """Refuses what pauses as a whole, on an event, if facts may leave it or something in it.

    Raises:
        InputError: It does, with the line of the condition.
    """
    for inner in walk((at.block, *at.also)):
        for handler in inner.handlers:
            if handler.when:
                message = f"{inner.name} is left when facts become so (on when), and an event pauses it"
                reason = "changes of facts in the meantime would be lost: use goto, and a route back"
                raise InputError.at(handler.source, f"{message}: {reason}")


def pause_problems(siblings: Sequence[Block], text: Sequence[Block]) -> Iterator[Problem]:
    """What is wrong with the pauses of sibling blocks.

    Args:
        siblings: The siblings.
        text: The blocks of their text.
    """
    named = {block.name: block for block in siblings}
    resuming = {runs_for(block) for block in siblings if block.resumes}
    for block in siblings:
        for handler in block.handlers:
            if handler.pause is not None and handler.event is not None and handler.pause not in resuming:
                yield from _pause(block, handler, named)
        if block.resumes is not None:
            yield from _resuming(block, siblings)
    for by, blocks in pausing(siblings).items():
        for other in walk(tuple(text)):
            copy = other.copy or other.written != other.name  # in core missions, where they are written out
            if other.name.startswith(f"{by}_") and "_at_" in other.name and not copy:
                message = f"{other.name} could be the name of a copy of {by}, which is run while"
                yield Problem(other.source, f"{message} {blocks[0].name} pauses: rename it")


def no_siblings(owner: str, handlers: Sequence[Handler], remedy: str) -> Iterator[Problem]:
    """Pauses of what has no siblings."""
    for handler in handlers:
        if handler.pause is not None and handler.event is not None:
            message = f"{owner} pauses on the event {handler.event}, though it has no siblings"
            yield Problem(handler.source, f"{message}: {remedy}")


def _pause(block: Block, handler: Handler, named: Mapping[str, Block]) -> Iterator[Problem]:
    what = f"pause of {block.name} on the event {handler.event}"
    by = named.get(handler.pause or "")
    if by is None or by is block:
        others = ", ".join(name for name in named if name != block.name)
        expected = f"expected one of {others}" if others else "expected a sibling, of which there is none"
        yield Problem(handler.source, f"{what} names {handler.pause}; {expected}")
    elif by.recover is not None or any(other.pause is not None for other in by.handlers):
        does = "recovers by a sibling" if by.recover is not None else "pauses, too"
        yield Problem(handler.source, f"{what} runs {by.name}, which itself {does}: only one of them can")


def _resuming(copy: Block, siblings: Sequence[Block]) -> Iterator[Problem]:
    """What is wrong with a copy that resumes something, as core missions have them."""
    before = tuple(siblings[: siblings.index(copy)])
    if copy.success is not None:
        yield Problem(copy.source, f"{copy.name} has success and resumes; expected one of them")
    if not copy.copy or not any(
        block.name == copy.resumes and isinstance(block, Objective | Parallel) for block in walk(before)
    ):
        expected = "expected, with copy, an objective or a parallel block in a sibling before it"
        yield Problem(copy.source, f"resumes of {copy.name} names {copy.resumes}; {expected}")
