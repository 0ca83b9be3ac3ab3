"""Datatypes of attributes: the texts that files may hold, their values, and which values are allowed."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace
from typing import Annotated, Any, NamedTuple

from mcpn.records import record

MAX_ROUNDS = 100_000
"""The largest number of rounds or tries that a block may ask for."""


@record(frozen=True, slots=True)
class Datatype:
    """The datatype of an attribute.

    Args:
        name: Its name in the schema.
        words: Its name for people.
        pattern: What its texts match, a regular expression of Python and of XML Schema; ``None`` for any.
            What follows a repetition begins with other characters, so that matching takes linear time.
        expected: What an error expects in the place of another text.
        read: From a text that matches to the value.
        write: From a value to its text.
        allows: Whether a value is allowed.
        allowed: What an error expects in the place of a value that is not allowed.
        refers: The kind of element that the value names: ``resource``, ``activity``, ``block``,
            ``protocol``, ``event``, ``fact``, ``objective``, or ``condition`` and ``formula``, which name
            several (:mod:`mcpn.mission.language.references`).
    """

    name: str
    words: str
    pattern: str | None = None
    expected: str = ""
    read: Callable[[str], Any] = str
    write: Callable[[Any], str] = str
    allows: Callable[[Any], bool] = lambda value: True
    allowed: str = ""
    refers: str = ""

    def matches(self, text: str) -> bool:
        """Whether a text can be read as a value."""
        return self.pattern is None or re.fullmatch(self.pattern, text, re.ASCII) is not None

    def to(self, kind: str) -> Datatype:
        """This datatype, its values being names of elements of one kind."""
        return replace(self, refers=kind)

    def within(self, allowed: str, allows: Callable[[Any], bool]) -> Datatype:
        """This datatype with fewer values: those that ``allows`` accepts, which ``allowed`` describes."""
        return replace(self, allowed=allowed, allows=allows)


def _split(text: str) -> tuple[str, ...]:
    return tuple(text.split())


_LETTER, _CHARACTER = "[A-Za-z_]", "[A-Za-z0-9_]"

TEXT = Datatype("text", "text")
FORMULA = TEXT.to("formula")
"""Of temporal logic; it is parsed when the mission has its net, whose places it may name."""
NAME = Datatype(
    "name",
    "name",
    f"{_LETTER}{_CHARACTER}{{0,254}}",
    "letters, digits and _, no digit first, at most 255 characters",
)
CORE_NAME = replace(
    NAME,
    pattern=rf"{_LETTER}{_CHARACTER}*(\.{_CHARACTER}+)*|timed out"
    rf"|fail (without reason|{_LETTER}{_CHARACTER}*)|done\({_LETTER}[A-Za-z0-9_.]*\)",
    expected="letters, digits and _, no digit first, perhaps qualified by other names: visit_12.travel",
)
"""A name in core missions, or what no author names: exits (time is over, a reason or none), `done(x)`."""
NAMES = Datatype(
    "names",
    "names",
    rf"\s*({_LETTER}{_CHARACTER}*\s+)*({_LETTER}{_CHARACTER}*)?",
    "names of letters, digits and _, separated by spaces",
    _split,
    " ".join,
)
CORE_NAMES = replace(
    NAMES,
    pattern=rf"\s*({_LETTER}[A-Za-z0-9_.]*\s+)*({_LETTER}[A-Za-z0-9_.]*)?",
    expected="names of letters, digits and _, separated by spaces, perhaps qualified: localise.by_scan",
)
"""Names in core missions."""
LOCATIONS = Datatype(
    "objectives",
    "objectives",
    rf"\s*({_LETTER}[A-Za-z0-9_.]*\s+)*({_LETTER}[A-Za-z0-9_.]*)?",
    "names of objectives, separated by spaces",
    _split,
    " ".join,
    refers="objective",
)
"""Objectives by their names in formulas, which uses of protocols qualify."""
_NO_REASON = frozenset(("EV", "EARLIER"))
REASON = replace(NAME, name="reason", refers="reason").within(
    "letters, digits and _, no digit first, with none of the words EV and EARLIER between its _",
    lambda name: _NO_REASON.isdisjoint(name.split("_")),
)
"""Why an objective fails: the end of the text of an event, in which no other event may be read."""
REASONS = replace(NAMES, name="reasons", refers="reason")
VALUES = Datatype(
    "values",
    "values",
    rf"\s*({_CHARACTER}+\s+)*{_CHARACTER}+\s*",
    "values of letters, digits and _, separated by spaces",
    _split,
    " ".join,
)
"""Values of rounds: they become parts of names."""
BOOLEAN = Datatype(
    "boolean",
    "true or false",
    r"\s*(true|false|1|0)\s*",
    "true or false",
    lambda text: text.strip() in ("true", "1"),
    lambda value: "true" if value else "false",
)
_DECIMAL = r"[0-9]+(\.[0-9]+)?"
_NUMBER = rf"{_DECIMAL}([eE][+\-]?[0-9]+)?"
NUMBER = Datatype(
    "number",
    "number",
    rf"\s*{_NUMBER}\s*",
    "a decimal number of at least 0, for example 12 or 2.5e-4",
    float,
)


class Interval(float):
    """A rate of which only bounds are known; as a number it is the geometric mean of the two.

    Args:
        low: The lowest that it may be.
        high: The highest.

    Examples:
        >>> rate = Interval(1e-5, 1e-3)
        >>> f"{rate:.6f}", str(rate)
        ('0.000100', '1e-05 .. 0.001')
    """

    __slots__ = ("high", "low")
    low: float
    high: float

    def __new__(cls, low: float, high: float) -> Interval:  # noqa: D102 - the class says it
        mean = math.sqrt(low) * math.sqrt(high)  # of whose product nothing overflows
        found = super().__new__(cls, min(max(mean, low), high))
        found.low, found.high = low, high
        return found

    def __getnewargs__(self) -> tuple[float, float]:  # type: ignore[override]
        return self.low, self.high

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Interval) and (self.low, self.high) == (other.low, other.high)

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __hash__(self) -> int:
        return hash((self.low, self.high))

    def __str__(self) -> str:
        return f"{self.low} .. {self.high}"

    def __repr__(self) -> str:
        return f"Interval({self.low}, {self.high})"


def _rate(text: str) -> float:
    low, dots, high = text.partition("..")
    return Interval(float(low), float(high)) if dots else float(low)


def _is_rate(rate: float) -> bool:
    if isinstance(rate, Interval):
        return 0 < rate.low <= rate.high < math.inf
    return 0 <= rate < math.inf


RATE = Datatype(
    "rate",
    "number or interval",
    rf"\s*{_NUMBER}\s*(\.\.\s*{_NUMBER}\s*)?",
    "a decimal number of at least 0, for example 12 or 2.5e-4, or an interval, for example 1e-5 .. 1e-4",
    _rate,
    allows=_is_rate,
    allowed="a finite number per hour, at least 0, or an interval that begins above 0 and ends no lower",
)
HOURS = NUMBER.within(
    "a finite number of hours above 0", lambda hours: 0 < hours < math.inf and not isinstance(hours, Interval)
)
PROBABILITY = NUMBER.within(
    "a number from 0 to 1", lambda share: 0 <= share <= 1 and not isinstance(share, Interval)
)
_SHARE = rf"{_LETTER}{_CHARACTER}*(={_NUMBER})?"
SHARES = Datatype(
    "shares",
    "names, each perhaps with a probability",
    rf"\s*({_SHARE}\s+)*({_SHARE})?",
    "names of letters, digits and _, each perhaps with a probability: no_path=0.02 blocked",
    _split,
    " ".join,
    refers="reason",
)
"""Reasons of an objective, each perhaps with its part of the probability that it fails."""
_MINUTES = f"([0-9]+M({_DECIMAL}S)?|{_DECIMAL}S)"
_CLOCK = f"T([0-9]+H({_MINUTES})?|{_MINUTES})"


def _seconds(text: str) -> float:
    """Seconds of a number of them, or of an ISO 8601 duration."""
    if "P" not in text:
        return float(text)
    return sum(float(number) * _UNITS[unit] for number, unit in _PART.findall(text))


_PART = re.compile(r"(?<![0-9.])([0-9.]++)([A-Z])")
_UNITS = {"W": 604_800.0, "D": 86_400.0, "H": 3_600.0, "M": 60.0, "S": 1.0}
_PERIOD = f"(P[0-9]+W|P[0-9]+D({_CLOCK})?|P{_CLOCK})"
SECONDS = Datatype(
    "seconds",
    "seconds or duration",
    rf"\s*({_NUMBER}|{_PERIOD})\s*",
    "seconds, for example 90 or 0.5, or a duration of ISO 8601 in weeks, or in days, hours, minutes and "
    "seconds, for example PT1M30S",
    _seconds,
    lambda seconds: str(seconds).removesuffix(".0"),
).within(
    "from 0.001 to 2592000 seconds (30 days)",
    lambda s: 0.001 <= s <= 2_592_000 and not isinstance(s, Interval),
)
PERIOD = Datatype(
    "period",
    "duration",
    rf"\s*{_PERIOD}\s*",
    "a duration of ISO 8601 in weeks, or in days, hours, minutes and seconds, for example PT8H or P2DT30M",
    _seconds,
).within("a duration above 0 that is finite", lambda seconds: 0 < seconds < math.inf)
"""Seconds that options of commands give: beside rates per hour a number without a unit would be misread."""
COUNT = Datatype("count", "whole number", r"\s*[0-9]{1,6}\s*", "a whole number of at most 6 digits", int)
TRIES = COUNT.within(f"a whole number from 0 to {MAX_ROUNDS}", lambda tries: 0 <= tries <= MAX_ROUNDS)
ROUNDS = COUNT.within(f"a whole number from 1 to {MAX_ROUNDS}", lambda rounds: 1 <= rounds <= MAX_ROUNDS)
ENTRIES = COUNT.within("a whole number from 1 to 9", lambda times: 1 <= times <= 9)
"""How often something may happen; a formula says each time once more."""
TIMES = COUNT.within(f"a whole number from 1 to {MAX_ROUNDS}", lambda times: 1 <= times <= MAX_ROUNDS)
ROUTE = replace(NAME.to("block"), words="target")


def _one_of(name: str, *choices: str) -> Datatype:
    """One of some words."""
    said = " or ".join(filter(None, (", ".join(choices[:-1]), choices[-1])))
    return Datatype(
        name,
        said,
        rf"\s*({'|'.join(choices)})\s*",
        said,
        str.strip,
        allows=choices.__contains__,
        allowed=said,
    )


IMPOSSIBLE = _one_of("impossible", "waits", "fails")
QUORUM = Datatype(
    "quorum",
    "any, all or a number",
    r"\s*(any|all|[0-9]{1,6})\s*",
    "any, all or a whole number",
    str.strip,
    allows=lambda text: text in ("any", "all") or (text.isascii() and text.isdigit() and int(text) > 0),
    allowed="any, all or a whole number above 0",
)
TRUTH = _one_of("truth", "holds", "fails")
OUTCOME = _one_of("outcome", "success", "failure")
CORE_OUTCOME = _one_of("outcome", "success", "failure", "abort", "timeout")
"""What facts choose routes on in core missions."""
STATUS = _one_of("status", "service", "oos")
DETECTION = _one_of("detection", "at_once", "late")
NOMINAL = _one_of("nominal", "entered", "endless", "optional", "fails", "unknown")
FAITH = _one_of("faith", "time", "more", "left_out")
OCCASION = _one_of("occasion", "success", "failure", "start")
_LITERAL = rf"!?({_LETTER}{_CHARACTER}*|done\({_LETTER}[A-Za-z0-9_.]*\))(={_CHARACTER}+)?"
CONDITION = Datatype(
    "condition",
    "condition",
    rf"\s*({_LITERAL}\s+)*{_LITERAL}\s*",
    "facts with their values, such as door=open !holding, separated by spaces, all of which must be so",
    _split,
    " ".join,
    refers="condition",
)
"""Facts that must have some values, all at once (:mod:`mcpn.mission.fact_conditions`)."""
VALUE = Datatype("value", "value", rf"\s*{_CHARACTER}+\s*", "a value of letters, digits and _", str.strip)
SEVERITY = _one_of("severity", "required", "advice")
ORDER = _one_of("order", "any", "sequenced", "ordered", "strict", "fair")
REACTION = _one_of("reaction", "instantaneous", "prompt", "delayed", "bound", "bound_delay")

Name = Annotated[str, NAME]
FactName = Annotated[str, NAME.to("fact")]
When = Annotated[tuple[str, ...], CONDITION]
EventName = Annotated[str | None, NAME.to("event")]
ProtocolName = Annotated[str, NAME.to("protocol")]
Route = Annotated[str | None, ROUTE]
Resources = Annotated[tuple[str, ...], NAMES.to("resource")]
ReasonName = Annotated[str | None, REASON]
Reasons = Annotated[tuple[str, ...], REASONS]
Shares = Annotated[tuple[str, ...], SHARES]
Activities = Annotated[tuple[str, ...], NAMES.to("activity")]
Values = Annotated[tuple[str, ...], VALUES]
Rate = Annotated[float | None, RATE]
Hours = Annotated[float | None, HOURS]
Seconds = Annotated[float | None, SECONDS]
Probability = Annotated[float | None, PROBABILITY]
Tries = Annotated[int, TRIES]
Rounds = Annotated[int | None, ROUNDS]
Times = Annotated[int, TIMES]

BY_CLASS = {str: TEXT, bool: BOOLEAN}
"""The datatype of a field that is annotated with its Python type alone."""


class Called(NamedTuple):
    """Says that an attribute has another name in files than its field.

    Args:
        name: The name in files.
    """

    name: str


class Core(NamedTuple):
    """Says that a field belongs to core missions (:mod:`mcpn.mission.passes`): no author writes it."""


class Children(NamedTuple):
    """What the annotation of a field says of the elements that hold it in a file, if there is more to say.

    Args:
        inside: The class of an element around them, with a field of the same name.
        without: Names in files of elements that a file does not allow here.
        short: A field of theirs. Its attribute may stand on the element around instead of a single element
            inside that has the same name as the one around and sets no other field.
        words: What that attribute means on the element around.
    """

    inside: type | None = None
    without: tuple[str, ...] = ()
    short: str = ""
    words: str = ""
