"""The one small tree of errors that mcpn raises on purpose, and where in a file they point."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple


@dataclass(frozen=True, slots=True, order=True)
class Source:
    """A place in an input file.

    Args:
        file: The file's path as the user gave it, or as an import names it.
        line: Line number from 1, or ``None`` where the format has no lines.
    """

    file: str
    line: int | None = None

    def __str__(self) -> str:
        return self.file if self.line is None else f"{self.file}:{self.line}"


class Problem(NamedTuple):
    """One thing wrong in an input: where, and what was found and expected.

    Args:
        source: Where, or ``None`` where the input has no file.
        message: What was found, what was expected.
    """

    source: Source | None
    message: str

    def __str__(self) -> str:
        return self.message if self.source is None else f"{self.source}: {self.message}"


class McpnError(Exception):
    """Base of all errors that mcpn raises on purpose; pickling keeps their attributes."""

    def __reduce__(self) -> tuple[Any, ...]:
        return _unpickled, (type(self), self.args, vars(self))


def _unpickled(kind: type[McpnError], args: tuple[Any, ...], attributes: dict[str, Any]) -> McpnError:
    error = kind.__new__(kind, *args)
    vars(error).update(attributes)
    return error


class InputError(McpnError):
    """Bad input: one or several located problems, reported in one go (exit code 2).

    Args:
        problems: What is wrong, in the order of the files and lines.
    """

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems: tuple[Problem, ...] = tuple(problems)
        super().__init__("\n".join(str(problem) for problem in self.problems))

    @classmethod
    def at(cls, source: Source | None, message: str) -> InputError:
        """One problem at one place."""
        return cls([Problem(source, message)])


class LimitError(McpnError):
    """A bound was hit (states, memory, time, size of a template): the message says which one."""


class WorkersError(McpnError):
    """Worker processes or machines have gone, or none could be reached."""


class SemanticsError(McpnError):
    """The net breaks a premise of the analysis; carries the runs that show it.

    Args:
        message: What was broken.
        runs: Sequences of transition names from the initial marking.
    """

    kind: ClassVar[str] = "semantics"
    """What is broken, in a word that does not change: what programs read."""

    def __init__(self, message: str, runs: Sequence[Sequence[str]] = ()) -> None:
        super().__init__(message)
        self.runs: tuple[tuple[str, ...], ...] = tuple(tuple(run) for run in runs)


class UnsafeError(SemanticsError):
    """A firing puts a second token in a place, or the initial marking has one.

    Args:
        place: Name of the place that would hold two tokens.
        transition: Name of the transition whose firing does it; empty where the initial marking does.
        marking: Names of the marked places before that firing.
        run: Transitions from the initial marking to ``marking`` (without ``transition``).
    """

    kind = "unsafe"

    def __init__(self, place: str, transition: str, marking: Iterable[str], run: Sequence[str]) -> None:
        self.place = place
        self.transition = transition
        self.marking = frozenset(marking)
        self.run: tuple[str, ...] = tuple(run)
        if not transition:
            super().__init__(f"not 1-safe: the initial marking holds several tokens in {place}")
            return
        super().__init__(
            f"not 1-safe: firing {transition} would put a second token in {place}, "
            f"after {len(self.run)} firings",
            [(*self.run, transition)],
        )


class UnboundedError(SemanticsError):
    """A net has no bound on its tokens.

    Args:
        places: Names of places that can hold any number of tokens.
        run: Transitions from the initial marking on,
        pump: and those that can then be repeated for ever, each time leaving more tokens.
        bounds: By place, the most tokens it holds, -1 where there is no such number; ``None`` where that is
            not known.
    """

    kind = "unbounded"

    def __init__(
        self,
        places: Sequence[str],
        run: Sequence[str],
        pump: Sequence[str],
        bounds: tuple[int, ...] | None = None,
    ) -> None:
        self.bounds = bounds
        self.places = tuple(places)
        self.run: tuple[str, ...] = tuple(run)
        self.pump: tuple[str, ...] = tuple(pump)
        super().__init__(
            f"unbounded: {places[0]} can hold any number of tokens: after {len(self.run)} firings, "
            f"{', '.join(self.pump[:3])}{' ...' if len(self.pump) > 3 else ''} can be repeated for ever",
            [(*self.run, *self.pump)],
        )


class ConfluenceError(SemanticsError):
    """Internal evolution ends in two different stable markings, depending on the interleaving.

    Args:
        message: What was broken.
        runs: Two sequences of transition names from the initial marking. They are the same up to a marking
            where each takes another transition, and this choice decides the stable marking.
        events: Texts of the events of both runs, which are the same.
    """

    kind = "nonconfluent"

    def __init__(self, message: str, runs: Sequence[Sequence[str]] = (), events: Sequence[str] = ()) -> None:
        super().__init__(message, runs)
        self.events: tuple[str, ...] = tuple(events)


class DivergenceError(SemanticsError):
    """Internal evolution need not end: an infinite internal run exists."""

    kind = "divergent"


class PremiseError(SemanticsError):
    """A section hands on more than the state of its hardware, so local graphs do not give the mission's.

    Args:
        section: The section's name.
        place: A place that differs at the section's exit from what it was at its entry.
        run: The events of a run of the local net that shows it.
    """

    def __init__(self, section: str, place: str, run: Sequence[str]) -> None:
        self.section = section
        self.place = place
        super().__init__(
            f"section {section} does not leave the place {place} as it was at its entry, so local graphs do "
            "not give the mission's: use --engine explicit or symbolic",
            [run],
        )
