"""Formulas about missions as clauses in English, in the mission's names."""

from __future__ import annotations

from mcpn.events import Event, What
from mcpn.logic.ltl.formulas import SomePath, normal
from mcpn.logic.writing import show
from mcpn.spaces.formula_names import Names
from mcpn.spaces.search.goal import And, Formula, Not, Or

_WORDS = {
    "objective": ("{0} runs", "{0} does not run"),
    "block": ("{0} runs", "{0} does not run"),
    "pending": ("{0} is about to begin", "{0} is not about to begin"),
    "activity": ("{0} runs", "{0} does not run"),
    "alternative": ("{0} runs as {1}", "{0} does not run as {1}"),
    "waiting": ("{0} waits", "{0} does not wait"),
    "refused": ("{0} has no way to run", "{0} has a way to run"),
    "oos": ("{0} is out of service", "{0} is in service"),
    "available": ("{0} is available", "{0} is not available"),
    "event": ("{0} may come next", "{0} cannot come next"),
    "happens": ("{0} happens", "{0} does not happen"),
    "success": ("the mission has succeeded", "the mission has not succeeded"),
    "failure": ("the mission has failed", "the mission has not failed"),
    "abort": ("the mission has been aborted", "the mission has not been aborted"),
}
"""By word of the mission, what it says of a name, and what its negation says."""
_EVENTS = {
    What.START: "the start of the mission",
    What.SUCCESS: "the success of {0}",
    What.FAILURE: "the failure of {0}",
    What.OUT_OF_SERVICE: "the loss of {0}",
    What.REPAIRED: "the return of {0}",
    What.DETECTED: "the detection of the loss of {0}",
}


def clause(formula: Formula, names: Names) -> str:
    """A formula as a clause; what no word of the mission says stands in quotes, as a formula.

    Args:
        formula: On states, or what the next step is.
        names: Know which words it was written with.
    """
    return _joined(formula, names, "")


def _joined(formula: Formula, names: Names, around: str) -> str:
    """A formula as a clause, in parentheses where it stands in a clause joined by another word."""
    for negated, meant in enumerate((formula, ~formula)):
        if meant in names.said and names.said[meant][0] in _WORDS:
            kind, *about = names.said[meant]
            if kind == "waiting" and len(about) == 2:
                about = [f"{about[0]} as {about[1]}"]
            if kind in ("event", "happens"):
                about = [event_clause(about[0])]
            return _WORDS[kind][negated].format(*about)
    match formula:
        case And(operands) | Or(operands):
            word = "and" if isinstance(formula, And) else "or"
            said = f" {word} ".join(_joined(operand, names, word) for operand in operands)
            return f"({said})" if around and around != word else said
        case Not((SomePath((path,)),)):
            return _joined(normal(path, wanted=False), names, around)
        case Not((And(operands) | Or(operands) as inside,)):
            other = Or if isinstance(inside, And) else And
            return _joined(other(*(~operand for operand in operands)), names, around)
    return f"“{show(formula, names)}”"


def event_clause(text: str) -> str:
    """An event, as it is written in files, as a clause."""
    event = Event.parse(text)
    return _EVENTS[event.what].format(event.element) if event.what in _EVENTS else event.element
