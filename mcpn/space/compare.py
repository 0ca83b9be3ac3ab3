"""Every engine on one net, side by side, each in a process of its own so that its memory can be told."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context

from mcpn.errors import LimitError, SemanticsError
from mcpn.net.petri import PetriNet
from mcpn.space.summary import ENGINES, SpaceSummary, summarise

MOST_PLACES_FOR_PYEDA = 24


@dataclass(frozen=True)
class Measurement:
    """What one engine found, and what it took.

    Args:
        engine: One of :data:`mcpn.space.summary.ENGINES`.
        summary: The sizes, or ``None`` where the engine gave up.
        megabytes: Peak memory of its process, the interpreter included.
        reason: Why it gave up.
    """

    engine: str
    summary: SpaceSummary | None
    megabytes: int
    reason: str = ""


def measure(net: PetriNet, *, max_states: int | None = None) -> list[Measurement]:
    """Runs every engine that applies to a net.

    Args:
        net: The net.
        max_states: Limit for the explicit engine.

    Returns:
        A measurement for each engine; see :func:`disagreement`.

    Raises:
        UnsafeError: The net is not 1-safe.
    """
    found = []
    for engine in ENGINES:
        if engine == "pyeda" and len(net.places) > MOST_PLACES_FOR_PYEDA:
            reason = f"left out: more than {MOST_PLACES_FOR_PYEDA} places"
            found.append(Measurement(engine, None, 0, reason))
            continue
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
            found.append(pool.submit(_run, net, engine, max_states).result())
    return found


def _run(net: PetriNet, engine: str, max_states: int | None) -> Measurement:
    import resource

    try:
        summary, reason = summarise(net, engine, max_states=max_states), ""
    except LimitError as error:
        summary, reason = None, str(error)
    return Measurement(engine, summary, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss >> 10, reason)


def disagreement(found: list[Measurement]) -> SemanticsError | None:
    """The error that says how engines disagree, or ``None`` where all agree."""
    sizes = {
        m.engine: replace(m.summary, nodes=None, order=None, engine="", seconds=0) for m in found if m.summary
    }
    if len(set(sizes.values())) < 2:
        return None
    told = "; ".join(
        f"{engine}: {s.states} states, {s.edges} edges, {s.stable_states} stable, {s.dead_states} dead, "
        f"{s.max_tokens} tokens"
        for engine, s in sizes.items()
    )
    return SemanticsError(f"the engines disagree, one of them is wrong: {told}")
