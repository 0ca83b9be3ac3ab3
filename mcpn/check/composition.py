"""The verdicts of a mission from the local graphs of its sections, without the graph of the whole."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from concurrent.futures import Executor
from itertools import takewhile
from typing import Any

from mcpn.check.journeys import Journeys, Leg, told
from mcpn.check.modes import Mode, diagram_modes, functioning_modes
from mcpn.check.properties import (
    INFORMATIVE,
    REQUIRED,
    Happened,
    MissionCheck,
    Verdict,
    find_unselectable,
    verdict_of,
)
from mcpn.check.runs import Step, what_happens
from mcpn.errors import SemanticsError, UnsafeError
from mcpn.mission.model import FAIL, SUCCEED
from mcpn.net.compose import MissionNet
from mcpn.net.events import START
from mcpn.net.petri import PetriNet
from mcpn.net.sections import Renaming
from mcpn.net.templates import TemplateSet
from mcpn.space.local.composite import Composite, Tear
from mcpn.space.local.diagram import LocalDiagram
from mcpn.space.local.gluing import error_of, glue
from mcpn.space.local.placing import DEFAULT_MAX_STATES, MOST_LISTED, Making, PlacedSection, Progress
from mcpn.space.local.protocol import OUTCOMES


def check_by_composition(
    mission_net: MissionNet,
    *,
    templates: TemplateSet | None = None,
    executor: Executor | None = None,
    max_states: int | None = None,
    most_listed: int | None = MOST_LISTED,
    progress: Progress | None = None,
) -> MissionCheck:
    """Checks a mission by composition: the verdicts are those of :func:`mcpn.check.properties.check_mission`.

    Args:
        mission_net: The mission's net, for its sizes and static facts; it is not explored.
        templates: Those that it was composed with; the paper's by default.
        executor: Where local graphs are made; this process by default.
        max_states: How many states a local graph may list; a section with more has a diagram.
        most_listed: With more hardware that can fail a section has a diagram at once.
        progress: Called after each local space and junction.

    Returns:
        Every verdict with its runs, which go through several sections.

    Raises:
        PremiseError: A section hands on more than the state of its hardware: use another engine.
        LimitError: A limit was hit.
    """
    verdicts = {name: Verdict(name, None, "not known") for name in (*REQUIRED, *INFORMATIVE)}
    limit = DEFAULT_MAX_STATES if max_states is None else max_states
    making = Making(templates, executor, limit, most_listed, progress)
    try:
        composite = glue(mission_net.usage, mission_net.graph, making, strict=False)
    except UnsafeError as error:  # in a section with a diagram
        verdicts["safe"] = Verdict("safe", False, str(error), _firings(error))
        return MissionCheck(mission_net, verdicts)
    tear = composite.tear
    if tear is not None:
        found = error_of(composite, tear, templates)
        name = "safe" if isinstance(found, UnsafeError) else "confluent"
        steps = _steps_to(mission_net, composite, tear, templates)
        runs = tuple((*steps, *_parting(mission_net.net, run)) for run in found.runs)
        verdicts[name] = Verdict(name, False, str(found), runs)
        return MissionCheck(mission_net, verdicts)
    for verdict in _Verdicts(composite, templates).all():
        verdicts[verdict.name] = verdict
    unselectable = find_unselectable(mission_net.usage, _happened(composite))
    text = f"{len(unselectable)} found" if unselectable else "nothing found"
    verdicts["unselectable"] = Verdict("unselectable", bool(unselectable), text)
    modes = _modes(composite)
    return MissionCheck(mission_net, verdicts, None, None, modes, unselectable, composite)


def _firings(error: SemanticsError) -> tuple[tuple[Step, ...], ...]:
    """Runs of a local net, transition by transition."""
    return tuple(tuple(Step(name, "in the section's own net") for name in run) for run in error.runs)


def _steps_to(
    mission_net: MissionNet, composite: Composite, tear: Tear, templates: TemplateSet | None
) -> list[Step]:
    """The mission's run up to the event of a tear, event by event."""
    steps = told(Journeys(composite).to_tear(tear), templates)
    if tear.here.event == START:  # the entry: what begins then is what depends on the interleaving
        return [*steps[:-1], Step(steps[-1].event, steps[-1].words.split(": ")[0])]
    if tear.here.event is None:
        return steps
    return [*steps, Step(tear.here.event, what_happens(tear.here.event, mission_net.mission.name))]


def _parting(net: PetriNet, run: Sequence[str]) -> list[Step]:
    """The internal firings at the end of a run."""
    internal = list(takewhile(lambda name: _is_internal(net, name), reversed(run)))
    return [Step(name, f"internal: {name}") for name in reversed(internal)]


def _is_internal(net: PetriNet, name: str) -> bool:
    return name in net.transition_index and net.transitions[net.transition_index[name]].internal


class _Verdicts:
    def __init__(self, composite: Composite, templates: TemplateSet | None) -> None:
        self.composite = composite
        self.templates = templates
        self.journeys = Journeys(composite)

    def all(self) -> list[Verdict]:
        proof = "each type of section, and each junction of two that share activities, proved on its own net"
        return [
            Verdict("safe", True, "no firing puts a second token in a place of a section"),
            Verdict("bounded", True, "a 1-safe net is bounded"),
            Verdict("confluent", True, proof),
            verdict_of("deadlock_free", self.run(self.dead())),
            verdict_of("success_reachable", self.run(self.journeys.find([SUCCEED]))),
            verdict_of("can_always_finish", self.run(self.stuck())),
            verdict_of("failure_reachable", self.run(self.journeys.find([FAIL]))),
        ]

    def run(self, legs: list[Leg] | None) -> list[Step] | None:
        return None if legs is None else told(legs, self.templates)

    def dead(self) -> list[Leg] | None:
        """A run to a state that is no end and allows no event."""
        composite = self.composite
        dead = {
            name: reached & composite.by_name[name].local.dead
            for name, reached in composite.reached.items()
            # Else some other hardware can always change.
            if len(composite.by_name[name].faulty) == len(composite.faulty)
        }
        return self.journeys.find(states=dead) if any(dead.values()) else None

    def stuck(self) -> list[Leg] | None:
        """A run to where no end is reached any more."""
        composite = self.composite
        stuck = composite.losing(OUTCOMES)
        if not any(stuck.values()):
            return None
        if not composite.hopeful(OUTCOMES)[composite.graph.entry]:
            # No start, whatever hardware is out of service, leads to an end: it is lost before any event.
            return []
        return self.journeys.find(states=stuck)


def _happened(composite: Composite) -> Happened:
    selected, entered = set[str](), set[str]()
    for name, reached in composite.reached.items():
        placed = composite.by_name[name]
        local, renaming = placed.local, placed.renaming
        for kind, names, found in (
            ("active", renaming.alternatives, selected),
            ("objective", renaming.objectives, entered),
        ):
            said = local.net.saying(kind).items()
            found.update(names[what] for place, what in said if local.marks(place, reached))
    return Happened(frozenset(selected), frozenset(entered), composite.events)


def _modes(composite: Composite) -> dict[str, list[Mode]]:
    known: dict[tuple[int, Hashable], dict[str, list[Mode]]] = {}
    found: dict[str, list[Mode]] = {}
    for placed in composite.sections:
        if placed.section.name in composite.reached:
            reached = composite.reached[placed.section.name]
            key = id(placed.local), reached
            if key not in known:
                known[key] = _modes_of(placed, reached)
            renaming = placed.renaming
            for objective, modes in known[key].items():
                found[renaming.objectives[objective]] = [_renamed(mode, renaming) for mode in modes]
    return found


def _modes_of(placed: PlacedSection, reached: Any) -> dict[str, list[Mode]]:
    local = placed.local
    if isinstance(local, LocalDiagram):
        return diagram_modes(local.net, local.space.encoding, reached)
    return dict(functioning_modes(local.net, placed.listed.graph, reached.mask))


def _renamed(mode: Mode, renaming: Renaming) -> Mode:
    return dict(renaming.alternatives[f"{a}.{alternative}"].split(".", 1) for a, alternative in mode.items())
