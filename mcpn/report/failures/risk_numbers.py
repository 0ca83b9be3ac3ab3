"""Numbers of risk on a terminal: to how many digits they are printed, and bounds of them rounded outward."""

from __future__ import annotations

from collections.abc import Mapping
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from typing import TYPE_CHECKING

from mcpn.answers.claims.claim import sentences
from mcpn.answers.claims.of_risk import claims_of_risk
from mcpn.report.failures.sentences import IMPORTANCE, ranked, risk_counts
from mcpn.report.terminal import Terminal
from mcpn.report.text import print_counts

if TYPE_CHECKING:
    from mcpn.answers.causes.ends_by_time import Within
    from mcpn.answers.causes.risk import Risk


def print_risk(numbers: Risk) -> None:
    """Prints probabilities, degraded modes and importances, and which events do not count in them."""
    print_counts({name: f"{value:.6g}" for name, value in risk_counts(numbers)})
    if numbers.importance:
        Terminal().print(IMPORTANCE)
    for said in sentences(claim for claim in claims_of_risk(numbers) if claim.kind == "unrated"):
        Terminal().print(said)


def print_within(numbers: Within, time: str) -> None:
    """Prints how probable each end is by a time, which is given as the user wrote it."""
    ends = {"success": numbers.success, "abort": numbers.abort, "failure": numbers.failure}
    print_counts({f"{end} within {time}": f"{value:.6g}" for end, value in ends.items() if value is not None})
    Terminal().print(f"within {time}: each is off by {numbers.error:.1e} at most")


def print_slopes(numbers: Risk, slopes: Mapping[str, float]) -> None:
    """Prints the derivatives of success where they put the hardware in another order than its importance."""
    order = ranked({name: -slope for name, slope in slopes.items()})
    if order != ranked({name: numbers.importance[name] for name in slopes}):
        Terminal().print(
            "by the derivative of success by their failure rates, per failure an hour, they rank otherwise:"
        )
        told = {f"derivative by {name}": f"{slopes[name]:.6g}" for name in order}
        print_counts(told)


def print_bounds(bounds: Mapping[str, tuple[float, float]], means: str) -> None:
    """Prints bounds of probabilities, rounded outward, and what the other numbers took for intervals."""
    told = ((end, outward(a, ROUND_FLOOR), outward(b, ROUND_CEILING)) for end, (a, b) in bounds.items())
    print_counts({f"{end} for all rates in their intervals": f"{low} .. {high}" for end, low, high in told})
    Terminal().print(f"the other numbers are {means}")


def outward(bound: float, rounding: str) -> str:
    """A bound with 6 digits, which is still one."""
    return f"{float(Context(prec=6, rounding=rounding).create_decimal_from_float(bound)):g}"
