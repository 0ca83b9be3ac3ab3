"""Drivers that end, or tell that hardware fails, as a generator of random numbers says."""

from __future__ import annotations

import asyncio
import random
from collections.abc import Sequence

from mcpn.robot.drivers.functions import Call

DICE = random.Random(0)
WORDS: list[str] = []
LIVE: dict[str, Call] = {}


async def act(call: Call) -> bool | None:
    """Runs for a while, tells something, and may end."""
    assert call.activity not in LIVE, "an activity runs twice"
    LIVE[call.activity] = call
    try:
        for _ in range(DICE.randrange(6)):
            await asyncio.sleep(0)
        if WORDS and DICE.random() < 0.4:
            call.say(DICE.choice(WORDS))
        if call.objective is None:
            await asyncio.Event().wait()
        return DICE.random() < 0.7
    finally:
        del LIVE[call.activity]
    return None


def begin(seed: int, words: Sequence[str]) -> None:
    """Begins anew."""
    DICE.seed(seed)
    WORDS[:] = words
    LIVE.clear()
