"""Snapshots: the state of a controller as a text, and the actions that bring a robot to that state."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from mcpn.robot.runtime.actions import Action
from mcpn.robot.runtime.controller_tables import Inside, Laws, Tables, TableSection
from mcpn.robot.runtime.documents import RUNNING, SAVED, SNAPSHOT, SNAPSHOT_VERSION
from mcpn.robot.runtime.file_schema import DamagedFile, fits, parsed, signed_line

snapshot_text = signed_line
"""The text of a snapshot, from what it says."""


class SnapshotError(DamagedFile):
    """A snapshot is truncated, changed, or of another controller."""


@dataclass(frozen=True)
class Saved:
    """What a snapshot says; ``beside`` is what its writer keeps with it (monitors, processes)."""

    phase: str
    section: TableSection | None
    state: int
    out_of_service: set[str]
    true: set[str]
    count: int
    timers: Mapping[str, float]
    beside: Mapping[str, Any] = field(default_factory=dict)

    def text(self, digest: str) -> str:
        """The snapshot.

        Args:
            digest: The controller's.
        """
        return snapshot_text(
            {
                "format": SNAPSHOT,
                "version": SNAPSHOT_VERSION,
                "controller": digest,
                "phase": self.phase,
                "section": self.section.name if self.section else None,
                "state": self.state,
                "out_of_service": sorted(self.out_of_service),
                "happened": sorted(self.true),
                "count": self.count,
                **({"timers": dict(self.timers)} if self.timers else {}),
                **({"beside": dict(self.beside)} if self.beside else {}),
            }
        )


def read_snapshot(text: str, tables: Tables) -> Saved:
    """Reads a snapshot of a controller.

    Raises:
        SnapshotError: It is truncated, changed, or of another controller.
    """
    if not isinstance(text, str):
        raise SnapshotError(f"expected a text, found {type(text).__name__}")
    document = parsed(text, SnapshotError)
    if not {"format", "version"} <= document.keys():
        raise SnapshotError("the snapshot is not whole: expected the keys format and version")
    if (document["format"], document["version"]) != (SNAPSHOT, SNAPSHOT_VERSION):
        raise SnapshotError("no snapshot of a version that is known here")
    if document.get("controller") != tables.digest:
        raise SnapshotError("the snapshot is of another controller")
    if text.strip() != snapshot_text(document):
        raise SnapshotError("the snapshot has been changed since it was written: its digest is another")
    fits(document, SAVED.shape, SnapshotError)
    phase, name, state = document["phase"], document["section"], document["state"]
    gone, true = set(document["out_of_service"]), set(document["happened"])
    left = {name: float(seconds) for name, seconds in document.get("timers", {}).items()}
    section = None if name is None else tables.sections.get(name)
    whole = (
        (section is not None) == (phase == RUNNING)
        and (name is None) == (section is None)
        and (section is not None or state == 0)
        and gone <= set(tables.hardware)
        and true <= tables.flags
        and all(name in gone for name, flag in tables.late.items() if flag in true)
        and all(tables.value(fact, true) is not None for fact in tables.facts)
    )
    timeouts = tables.laws.timeouts
    running = set[str]()
    if whole and section:
        whole = section.whole(state, gone, true)
        running = tables.laws.timed(section.state(state)) if whole else running
    whole = whole and left.keys() == running
    whole = whole and all(0 <= seconds <= timeouts[name] for name, seconds in left.items())
    if not whole:
        raise SnapshotError("the snapshot says what cannot be")
    return Saved(phase, section, state, gone, true, document["count"], left, document.get("beside", {}))


def actions_to(inside: Inside, laws: Laws) -> Iterator[Action]:
    """The actions that bring a robot of which nothing is known to where a controller is.

    Every activity is stopped, consumers before what they consume; all hardware is released; then the
    alternatives of the functioning mode are selected and their activities started, what is consumed before
    its consumer. Timers are the controller's own: a snapshot holds what they have left.

    Args:
        inside: What the controller runs.
        laws: What the controller's file says of activities and objectives.
    """
    if laws.idle is None:
        laws.idle = tuple(_to_idle(laws))
    yield from laws.idle
    running = {
        name: _consumed([laws.activities[name]["alternatives"][way]]) for name, way in inside.mode.items()
    }
    named = {a: name for name in inside.objectives for a in laws.objectives[name]["activities"]}
    order = _producers_first(running, laws.producers)
    for name in order:
        way, objective = inside.mode[name], named.get(name)
        yield Action("select", name, way, None, objective, laws.of(name, way, objective))
    for name in order:
        yield Action("start", name, objective=named.get(name))


def _to_idle(laws: Laws) -> Iterator[Action]:
    """The actions that stop every activity and release all hardware."""
    every = {name: _consumed(row["alternatives"].values()) for name, row in laws.activities.items()}
    for name in reversed(_producers_first(every, laws.producers)):
        yield Action("stop", name)
    hardware = [what for consumed in every.values() for what in consumed if what not in laws.producers]
    for name in dict.fromkeys(hardware):
        yield Action("release", hardware=name)


def _consumed(alternatives: Iterable[Mapping[str, list[str]]]) -> list[str]:
    return list(dict.fromkeys(what for way in alternatives for what in way["consumes"]))


def _producers_first(consumed: Mapping[str, list[str]], producers: Mapping[str, list[str]]) -> list[str]:
    """Activities, each after those that produce what it consumes.

    Activities in a cycle stand in some order; only alternatives that do not run together can make a cycle.
    """
    order: dict[str, None] = {}
    entered = set[str]()
    stack = [(name, False) for name in reversed(list(consumed))]
    while stack:
        name, done = stack.pop()
        if done:
            order[name] = None
        elif name not in entered:
            entered.add(name)
            stack.append((name, True))
            below = (p for what in consumed[name] for p in producers.get(what, ()) if p in consumed)
            stack += [(p, False) for p in below]
    return list(order)
