"""What blocks a text leads to by anything but success: whoever writes that means no blocks that always run.

This is asked of what an author wrote, of nothing else: in a core mission failures lead to the next try, and
copies stand behind what pauses, though nobody wrote a route there.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from mcpn.mission.core.copies import Written
from mcpn.mission.model import ABORT, Block, Holder, Mission, Use, walk


def led_to_by_events(mission: Mission) -> Mapping[str, frozenset[Written]]:
    """By declared event the blocks that its handlers lead to: by their names, or by an abort that is caught.

    Where a handler says ``succeed`` or ``fail``, what follows is what follows without the event, too.

    Examples:
        >>> from mcpn.mission.model import Handler, Mission, Objective
        >>> see = Objective(name="see", activities=("film",), handlers=(Handler(event="storm", goto="hide"),))
        >>> led_to_by_events(Mission(name="m", blocks=(see, Objective(name="hide", activities=("drift",)))))
        {'storm': frozenset({('', 'hide')})}
    """
    texts: dict[str, tuple[Block, ...]] = {"": mission.blocks}
    texts |= {protocol.name: protocol.blocks for protocol in mission.protocols}
    around: dict[Written, Written] = {}
    users: dict[str, list[Written]] = {}
    blocks: dict[Written, Block] = {}
    for text, roots in texts.items():
        for block in walk(roots):
            blocks[text, block.name] = block
            if isinstance(block, Holder):
                around |= {(text, inner.name): (text, block.name) for inner in block.blocks}
            if isinstance(block, Use):
                users.setdefault(block.protocol, []).append((text, block.name))

    def caught(block: Written) -> Iterator[Written]:
        """Where an abort of the parent of a block is caught."""
        outer, seen = [around[block]] if block in around else list(users.get(block[0], ())), set[Written]()
        while outer:
            here = outer.pop()
            if here in seen:
                continue
            seen.add(here)
            to = (here[0], blocks[here].abort or ABORT)
            if to in blocks:
                yield to
            elif to[1] == ABORT:
                outer += [around[here]] if here in around else users.get(here[0], ())

    found: dict[str, set[Written]] = {}
    owners = [(name, block.handlers) for name, block in blocks.items()]
    for owner, handlers in (*owners, (("", ""), mission.handlers)):
        for handler in handlers:
            if handler.event is None:
                continue
            leads = found.setdefault(handler.event, set())
            for target in handler.targets or (handler.pause or "",):
                if (owner[0], target) in blocks:
                    leads.add((owner[0], target))
                elif target == ABORT and owner[1]:
                    leads.update(caught(owner))
    return {event: frozenset(leads) for event, leads in found.items()}


def helpers_of(mission: Mission) -> Iterator[Written]:
    """The blocks that a text leads to by anything but success, and those that are run for others."""
    yield from (("", target) for handler in mission.handlers for target in handler.targets)
    for text, blocks in (("", mission.blocks), *((p.name, p.blocks) for p in mission.protocols)):
        for block in walk(blocks):
            late = block.timeout_goto
            events = (target for handler in block.handlers for target in (*handler.targets, handler.pause))
            chosen = (
                *(guard.otherwise for guard in block.guards),
                *(route.goto for route in block.routes),
            )
            for target in (block.failure, block.abort, late, block.recover, *events, *chosen):
                if target is not None:
                    yield text, target
