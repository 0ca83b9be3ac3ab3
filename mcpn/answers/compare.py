"""Every engine on one mission or net, side by side, each run in a process of its own.

So each run's memory and CPU time are its own, and one that takes too long is ended. An engine that cannot
answer says why in its row, and the others answer.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from multiprocessing import Pipe, get_context
from multiprocessing.connection import Connection
from pathlib import Path
from statistics import linear_regression, median

from mcpn.answers.spaces_by_engine import MissionSpaces, spaces_of
from mcpn.drawing.compose import compose
from mcpn.errors import LimitError, McpnError, SemanticsError
from mcpn.mission.model import Mission
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.spaces.engine_names import LOCAL, SYMBOLIC
from mcpn.spaces.registry import Spaces
from mcpn.spaces.sizes import summarise
from mcpn.spaces.summary import ENGINES

SIZES = ("states", "edges", "stable_states", "dead_states", "max_tokens")
"""What engines must agree on, as far as each counts it."""
DIAGRAM = ("nodes", "peak_nodes")
"""Sizes of a diagram: in the end, and the most at once."""

SECONDS = 60.0
"""Wall-clock seconds that a run may take by default; of pyeda its CPU time is limited, too."""


@dataclass(frozen=True)
class Runs:
    """How engines are run.

    Args:
        max_states: Limit for the explicit engine.
        seconds: Wall-clock limit on each run.
        repeats: How often each engine runs.
        own: Engines of the caller's own, by their names; see :func:`mcpn.spaces.custom_engine.engine_named`.
    """

    max_states: int | None = None
    seconds: float = SECONDS
    repeats: int = 1
    own: Sequence[str] = ()


@dataclass(frozen=True)
class Measurement:
    """What one engine found, and what it took.

    Args:
        engine: One of :data:`mcpn.spaces.summary.ENGINES`, ``local``, or one of the caller's own.
        sizes: By the names of :data:`SIZES` and :data:`DIAGRAM`; a size that the engine does not count is
            ``None``. The whole is ``None`` where the engine gave up.
        seconds: Wall-clock time of the engine, imports apart: the least of all runs.
        megabytes: Peak memory of its process, the interpreter included: the most of all runs; ``None`` where
            the engine was not asked, or its process was ended before it could say.
        reason: Why it gave up.
        order: Name of the diagram's order of places; ``None`` where there is none.
        cpu_seconds: CPU time of the engine, imports apart: the least of all runs.
        median_seconds: Wall-clock time, the median of all runs.
        median_cpu_seconds: CPU time, the median of all runs.
        most_cpu_seconds: CPU time, the most of all runs.
        repeats: How many runs there were.
    """

    engine: str
    sizes: Mapping[str, int | None] | None
    seconds: float
    megabytes: int | None
    reason: str = ""
    order: str | None = None
    cpu_seconds: float = 0.0
    median_seconds: float = 0.0
    median_cpu_seconds: float = 0.0
    most_cpu_seconds: float = 0.0
    repeats: int = 1


@dataclass(frozen=True)
class Measured:
    """All engines on one subject.

    Args:
        name: Its name.
        places: Of its net.
        transitions: Of its net.
        arcs: Of its net: pairs of a transition and a place that it consumes from, produces in or reads.
        engines: What each engine found.
        size: Of a member of a family, its size.
    """

    name: str
    places: int
    transitions: int
    arcs: int
    engines: Sequence[Measurement]
    size: int | None = None


def measure(
    subject: Mission | PetriNet,
    runs: Runs = Runs(),
    *,
    size: int | None = None,
    without: Mapping[str, str] | None = None,
) -> Measured:
    """Runs every engine that applies.

    Args:
        subject: A mission, or a net, to which composition does not apply.
        runs: How.
        size: Of a member of a family, its size.
        without: Engines that are not asked, each with the reason.

    Returns:
        A measurement for each engine; see :func:`disagreement`.

    Raises:
        SemanticsError: No engine answers, and one of them says what is wrong with the net.

    See Also:
        :func:`mcpn.spaces.sizes.sizes`: the counts by one engine.
    """
    net = compose(subject).net if isinstance(subject, Mission) else subject
    subjects: list[tuple[str, Mission | PetriNet]] = [(engine, net) for engine in (*ENGINES, *runs.own)]
    if isinstance(subject, Mission):
        subjects.append((LOCAL, subject))
    found, problems = [], list[McpnError | None]()
    for engine, subject_of in subjects:
        if (reason := (without or {}).get(engine)) is not None:
            found.append(Measurement(engine, None, 0.0, None, reason))
            continue
        ran = list[Measurement]()
        while not ran or (len(ran) < runs.repeats and ran[-1].sizes is not None):
            run, problem = _in_own_process(subject_of, engine, runs)
            ran.append(run)
            problems.append(problem)
        found.append(_joined(ran))
    refused = [problem for problem in problems if isinstance(problem, SemanticsError)]
    if refused and all(m.sizes is None for m in found):
        raise refused[0]
    arcs = sum(len(t.consume) + len(t.produce) + len(t.read) for t in net.transitions)
    return Measured(subject.name, len(net.places), len(net.transitions), arcs, found, size)


def grown(members: Iterator[tuple[int, PetriNet]], runs: Runs) -> Iterator[Measured]:
    """Measures the members of a family; an engine that gave up on one is not asked for larger ones.

    Args:
        members: Sizes and nets, growing.
        runs: How they are measured.

    Yields:
        Each member's measurements.
    """
    without: dict[str, str] = {}
    for size, net in members:
        found = measure(net, runs, size=size, without=without)
        yield found
        gave_up = [m.engine for m in found.engines if m.sizes is None and m.engine not in without]
        without |= dict.fromkeys(gave_up, f"gave up at size {size}")


GROWING: Mapping[str, str] = {"cpu_seconds": "CPU time", "megabytes": "memory", "peak_nodes": "peak of nodes"}
"""What grows with the size, with the words for it."""

LEAST_SECONDS = 0.01
"""Runs that take less measure the clock."""


def grows(m: Measurement) -> dict[str, float]:
    """What of :data:`GROWING` an engine took, as far as it ran and has it; CPU time is the median."""
    if m.sizes is None:
        return {}
    took = {
        "cpu_seconds": m.median_cpu_seconds,
        "megabytes": m.megabytes,
        "peak_nodes": m.sizes.get("peak_nodes"),
    }
    return {what: float(value) for what, value in took.items() if value is not None}


def exponents(members: Sequence[Measured]) -> dict[str, dict[str, float]]:
    """How what each engine takes grows with the size: slopes of lines through the logarithms.

    Left out are runs of less than a hundredth of a second, which measure the clock, and members on which an
    engine holds less than twice its least memory, most of which is the interpreter. What has fewer than three
    sizes left has no exponent.

    Returns:
        By engine, the exponents of :data:`GROWING`.
    """
    slopes: dict[str, dict[str, float]] = {}
    for engine in dict.fromkeys(m.engine for member in members for m in member.engines):
        ran = [(member.size, grows(m)) for member in members for m in member.engines if m.engine == engine]
        least = min((took["megabytes"] for _, took in ran if "megabytes" in took), default=0.0)
        lowest = {"cpu_seconds": LEAST_SECONDS, "megabytes": max(2 * least, 1.0), "peak_nodes": 1.0}
        for what, low in lowest.items():
            points = [
                (math.log(size), math.log(took[what]))
                for size, took in ran
                if size and took.get(what, 0) >= low
            ]
            if len({x for x, _ in points}) >= 3:
                slopes.setdefault(engine, {})[what] = linear_regression(*zip(*points, strict=True)).slope
    return slopes


def _joined(runs: Sequence[Measurement]) -> Measurement:
    """One measurement of several runs; of runs of which one gave up, that one."""
    last = runs[-1]
    wall, cpu = ([getattr(run, name) for run in runs] for name in ("seconds", "cpu_seconds"))
    return Measurement(
        engine=last.engine,
        sizes=last.sizes,
        seconds=min(wall),
        megabytes=max((run.megabytes for run in runs if run.megabytes is not None), default=None),
        reason=last.reason,
        order=last.order,
        cpu_seconds=min(cpu),
        median_seconds=median(wall),
        median_cpu_seconds=median(cpu),
        most_cpu_seconds=max(cpu),
        repeats=len(runs),
    )


def _in_own_process(
    subject: Mission | PetriNet, engine: str, runs: Runs
) -> tuple[Measurement, McpnError | None]:
    here, there = Pipe(duplex=False)
    process = get_context("spawn").Process(target=_run, args=(subject, engine, runs, there), daemon=True)
    process.start()
    there.close()
    try:
        if not here.poll(runs.seconds + STARTING):
            reason = f"more than {runs.seconds:g} s: the limit on a run was hit"
            return Measurement(engine, None, runs.seconds, None, reason), None
        found: tuple[Measurement, McpnError | None] = here.recv()
        return found
    except EOFError:
        reason = "its process was ended, as by a system that is out of memory"
        return Measurement(engine, None, 0.0, None, reason), None
    finally:
        process.kill()
        process.join()


STARTING = 10.0
"""Seconds that a process may take to start, and to read what it is given."""


def _run(subject: Mission | PetriNet, engine: str, runs: Runs, pipe: Connection) -> None:
    sizes: dict[str, int | None] | None = None
    problem: LimitError | SemanticsError | None = None
    order: str | None = None
    wall = cpu = 0.0
    try:
        summarise(NetBuilder("for imports alone").build(), SYMBOLIC if engine == LOCAL else engine)
        spaces = MissionSpaces(compose(subject)) if isinstance(subject, Mission) else Spaces(subject)
        wall, cpu = time.perf_counter(), time.process_time()
        if engine == LOCAL:
            stable = spaces_of(spaces).composite().everything.count()
            sizes = {**dict.fromkeys((*SIZES, *DIAGRAM)), "stable_states": stable}
        else:
            summary = summarise(spaces, engine, max_states=runs.max_states, seconds=runs.seconds)
            sizes = {name: getattr(summary, name) for name in (*SIZES, *DIAGRAM)}
            order = summary.order
    except (LimitError, SemanticsError) as error:
        problem = error
    except Exception as error:
        if engine in (*ENGINES, LOCAL):
            raise
        problem = LimitError(f"its code raised {type(error).__name__}: {error}")
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    reason = str(problem or "").split("\n")[0]
    found = Measurement(
        engine=engine,
        sizes=sizes,
        seconds=wall,
        megabytes=peak_megabytes(),
        reason=reason,
        order=order,
        cpu_seconds=cpu,
        median_seconds=wall,
        median_cpu_seconds=cpu,
        most_cpu_seconds=cpu,
    )
    pipe.send((found, problem))


def peak_megabytes() -> int:
    """The most memory that this process has held.

    ``ru_maxrss`` of a child begins at the size of its parent on Linux, also after exec; the system's
    high-water mark of the resident set is that of the program.
    """
    status = Path("/proc/self/status")
    if status.exists():
        (line,) = (line for line in status.read_text().splitlines() if line.startswith("VmHWM:"))
        return int(line.split()[1]) >> 10
    import resource

    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most >> 20 if sys.platform == "darwin" else most >> 10


class Disagreement(SemanticsError):
    """Engines count differently: one of them is wrong."""

    kind = "disagreement"


def disagreement(measurements: Sequence[Measurement]) -> Disagreement | None:
    """The error that says how engines disagree, or ``None`` where all agree on what they count."""
    for name in SIZES:
        counted = {m.engine: size for m in measurements if m.sizes and (size := m.sizes[name]) is not None}
        if len(set(counted.values())) > 1:
            counts = ", ".join(f"{engine}: {size}" for engine, size in counted.items())
            return Disagreement(f"the engines disagree on {name}, one of them is wrong: {counts}")
    return None
