"""Every engine on one mission or net, side by side, each in a process of its own to measure its memory."""

from __future__ import annotations

import time
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context

from mcpn.check.sizes import summarise
from mcpn.check.spaces import Spaces
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission
from mcpn.net.compose import compose
from mcpn.net.petri import PetriNet
from mcpn.space.summary import ENGINES

SIZES = ("states", "edges", "stable_states", "dead_states", "max_tokens")
"""What engines must agree on, as far as each counts it."""
DIAGRAM = ("nodes", "peak_nodes")
"""Sizes of a diagram: in the end, and the most at once."""


@dataclass(frozen=True)
class Measurement:
    """What one engine found, and what it took.

    Args:
        engine: One of :data:`mcpn.space.summary.ENGINES`, or ``local``.
        sizes: By the names of :data:`SIZES` and :data:`DIAGRAM`; a size that the engine does not count is
            ``None``. The whole is ``None`` where the engine gave up.
        seconds: Wall-clock time of the engine.
        megabytes: Peak memory of its process, the interpreter included.
        reason: Why it gave up.
        order: Name of the diagram's order of places; ``None`` where there is none.
    """

    engine: str
    sizes: Mapping[str, int | None] | None
    seconds: float
    megabytes: int
    reason: str = ""
    order: str | None = None


def measure(subject: Mission | PetriNet, *, max_states: int | None = None) -> list[Measurement]:
    """Runs every engine that applies.

    Args:
        subject: A mission, or a net, to which composition does not apply.
        max_states: Limit for the explicit engine.

    Returns:
        A measurement for each engine; see :func:`disagreement`.

    Raises:
        UnsafeError: The net is not 1-safe.
        SemanticsError: The mission breaks what composition rests on.

    See Also:
        :func:`mcpn.check.sizes.sizes`: the counts by one engine.
    """
    measurements = []
    net = compose(subject).net if isinstance(subject, Mission) else subject
    for engine in ENGINES:
        measurements.append(_in_own_process(net, engine, max_states))
    if isinstance(subject, Mission):
        measurements.append(_in_own_process(subject, "local", max_states))
    return measurements


def _in_own_process(subject: Mission | PetriNet, engine: str, max_states: int | None) -> Measurement:
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(_run, subject, engine, max_states).result()


def _run(subject: Mission | PetriNet, engine: str, max_states: int | None) -> Measurement:
    import resource

    sizes: dict[str, int | None] | None = None
    seconds, reason, order = 0.0, "", None
    try:
        if isinstance(subject, Mission):
            sizes, seconds = _local(subject)
        else:
            summary = summarise(subject, engine, max_states=max_states)
            sizes = {name: getattr(summary, name) for name in (*SIZES, *DIAGRAM)}
            seconds, order = summary.seconds, summary.order
    except LimitError as error:
        reason = str(error)
    megabytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss >> 10
    return Measurement(engine, sizes, seconds, megabytes, reason, order)


def _local(mission: Mission) -> tuple[dict[str, int | None], float]:
    spaces = Spaces(compose(mission))
    started = time.perf_counter()
    stable = spaces.composite().everything.count()
    return {**dict.fromkeys((*SIZES, *DIAGRAM)), "stable_states": stable}, time.perf_counter() - started


class Disagreement(SemanticsError):
    """Engines count differently: one of them is wrong."""

    kind = "disagreement"


def disagreement(measurements: list[Measurement]) -> Disagreement | None:
    """The error that says how engines disagree, or ``None`` where all agree on what they count."""
    for name in SIZES:
        counted = {m.engine: size for m in measurements if m.sizes and (size := m.sizes[name]) is not None}
        if len(set(counted.values())) > 1:
            counts = ", ".join(f"{engine}: {size}" for engine, size in counted.items())
            return Disagreement(f"the engines disagree on {name}, one of them is wrong: {counts}")
    return None
