"""Failure causes: cut sets, critical events, FMECA, fault trees, numbers of risk."""

from __future__ import annotations

import time
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mcpn.cli.options import FILE, Question, engine_option, question
from mcpn.cli.printed import choice_object, emit_json, tell_warnings
from mcpn.errors import InputError, LimitError

if TYPE_CHECKING:
    from mcpn.report.failures.fmeca_table import Classes
    from mcpn.spaces.engine_names import Asked

MOST_TOLD = 50
"""Objectives up to which runs and FMECA rows are printed without being asked for."""


@click.command()
@click.argument("mission", type=FILE)
@engine_option()
@click.option(
    "--objective", "objectives", multiple=True, metavar="NAME", help="Look at this objective alone."
)
@click.option("--fmeca", type=FILE, help="Write the FMECA table: .csv or .json.")
@click.option("--openpsa", type=FILE, help="Write a fault tree in the Open-PSA format (XML).")
@click.option(
    "--certificate",
    type=FILE,
    metavar="OUT",
    help="Write the minimal cut sets to OUT, with --rates how probable the ends are, with evidence, and have "
    "it checked.",
)
@click.option(
    "--rates",
    is_flag=True,
    help="Compute probabilities from the rates and durations of the mission (some need mcpn[risk]).",
)
@click.option(
    "--max-chain",
    type=click.IntRange(1),
    help="With --rates: compute numbers of chains of up to so many states (default: 50,000). Of larger ones "
    "all else is told, and why there are no numbers; the exit code is then 2.",
)
@click.option(
    "--within",
    metavar="DURATION",
    help="With --rates: compute also how probable each end is by this time, for example PT8H.",
)
@click.option(
    "--severity",
    "severities",
    multiple=True,
    metavar="CLASS=NAME",
    help='A name of your own for a severity class, for example "mission lost=I".',
)
@question(workers=True)
def causes(
    question: Question,
    mission: Path,
    engine: Asked,
    objectives: tuple[str, ...],
    fmeca: Path | None,
    openpsa: Path | None,
    certificate: Path | None,
    rates: bool,
    max_chain: int | None,
    within: str | None,
    severities: tuple[str, ...],
) -> None:
    """Tell what makes MISSION fail: minimal sets of lost hardware, critical events, what each loss does.

    Every engine answers every question; local needs no space of the whole mission. Numbers of risk list the
    states of the whole mission, or with local those of each type of section. Of missions with more than 50
    objectives, runs and FMECA rows are of those that --objective names, or of all with --fmeca.
    """
    from mcpn.answers.causes.fmeca import fmeca as table_of
    from mcpn.answers.claims import claims_of_causes
    from mcpn.answers.claims.of_risk import claims_of_risk
    from mcpn.files import write_atomically
    from mcpn.mission.static.interval_rates import at_their_means, interval_rates
    from mcpn.report.failures import fmeca_table, objects, risk_numbers, terminal
    from mcpn.report.failures.openpsa import beside_the_tree, open_psa
    from mcpn.report.terminal import plain
    from mcpn.report.text import print_choice

    started = time.perf_counter()
    classes = _classes(severities)
    hours = None if within is None else _hours(within, rates)
    if fmeca is not None:
        fmeca_table.check_table_name(fmeca)
    study = question.study(mission, engine)
    question.keep_apart(mission, study, fmeca, openpsa, certificate)
    if not question.as_json:
        tell_warnings(study.mission_net)
    with question.progress():
        with question.workers():
            every = study.causes()
        found = every.of(objectives) if objectives else every
        short = len(found.objectives) <= MOST_TOLD
        wanted = None if fmeca is not None else list(found.objectives)
        rows = table_of(found.prospects, wanted) if short or fmeca is not None else []
        numbers = slopes = bounded = by_then = unanswered = None
        if rates:
            from mcpn.answers.causes.interval_bounds import bounds
            from mcpn.answers.causes.risk import risk
            from mcpn.answers.causes.slopes import slopes_of
            from mcpn.answers.causes.whole_chain import whole_chain

            try:
                chained = every.prospects.within(max_chain)
                numbers, slopes = risk(chained), slopes_of(chained)
                if interval_rates(study.mission_net.core):
                    bounded = bounds(every.prospects)
                if hours is not None:
                    from mcpn.answers.causes.ends_by_time import within as ends_within  # an extra

                    by_then = ends_within(whole_chain(every.prospects), hours)
            except LimitError as error:  # all else is answered
                unanswered = LimitError(f"numbers of risk: not computed: {error}")
    written = None
    if certificate is not None:
        from mcpn.certificates.checked_claims import verified
        from mcpn.certificates.writing import certificate_of_causes

        with question.progress():
            told: dict[str, float | None] = {}
            if numbers is not None:
                told = {"success": numbers.success, "failure": numbers.failure, "abort": numbers.abort}
            evidence = certificate_of_causes(
                every, question.max_states, chances=numbers is not None, printed=told
            )
            write_atomically(certificate, evidence.to_bytes())
            written = verified(evidence, certificate)
    if openpsa is not None:
        cut_sets = {name: goal.cut_sets for name, goal in every.objectives.items()}
        safety = None if every.safety is None else every.safety.cut_sets
        usage = study.mission_net.usage
        worst = every.mission.only_at_worst
        tree = open_psa(usage, every.mission.cut_sets, cut_sets, safety, every.unsafe_aborts, worst)
        write_atomically(openpsa, tree)
        tops = (every.mission.cut_sets, *cut_sets.values(), safety or ())
        said = [] if question.as_json else beside_the_tree(usage, chain.from_iterable(tops), worst)
        for sentence in said:
            click.echo(f"{openpsa}: {plain(sentence)}", err=True)
    if fmeca is not None:
        fmeca_table.save_fmeca(rows, fmeca, classes)
    claims = claims_of_causes(found, rows)
    claims += [] if numbers is None else claims_of_risk(numbers)
    left_out = [objects.RUNS] * question.as_json + [objects.EFFECTS] * (fmeca is None)
    missing = [] if short else objects.left_out(len(found.objectives), left_out)
    if question.as_json:
        document: dict[str, Any] = objects.causes_object(found, claims, runs=short)
        document["left_out"] = missing
        if numbers is not None:
            document["risk"] = objects.risk_object(numbers)
        if unanswered is not None:
            document["no_risk"] = str(unanswered)
        if slopes is not None:
            document["slopes"] = slopes
        if bounded is not None:
            document["bounds"] = {end: list(both) for end, both in bounded.items()}
        if by_then is not None:
            document["within"] = objects.given(by_then)
        document |= {} if written is None else written.said
        emit_json(document | choice_object(every.choice) | {"seconds": time.perf_counter() - started})
        if unanswered is not None:
            raise unanswered
        return
    terminal.print_causes(found, claims)
    if written is not None:
        from mcpn.report.certificates import print_certificate

        print_certificate(written)
    if rows:
        asked = [row for row in rows if not objectives or row.objective in found.objectives]
        terminal.print_fmeca(asked, found.mission_net, classes)
    if numbers is not None:
        risk_numbers.print_risk(numbers)
        risk_numbers.print_slopes(numbers, slopes or {})
    if bounded is not None:
        risk_numbers.print_bounds(bounded, at_their_means(study.mission_net.core))
    if by_then is not None and within is not None:
        risk_numbers.print_within(by_then, within.strip())
    terminal.print_left_out(missing)
    print_choice(every.choice)
    if unanswered is not None:
        raise unanswered


def _classes(given: tuple[str, ...]) -> Classes:
    """Severity classes with the names that the user gives."""
    from mcpn.answers.causes.effects import Severity
    from mcpn.report.failures.fmeca_table import STANDARD

    known = {severity.words: severity for severity in Severity}
    classes = dict(STANDARD)
    for text in given:
        words, equals, name = text.partition("=")
        if words not in known or not equals:
            expected = ", ".join(f"{k}=NAME" for k in known)
            raise InputError.at(None, f"found --severity {text!r}, expected one of {expected}")
        classes[known[words]] = name
    return classes


def _hours(text: str, rates: bool) -> float:
    """The time by which ends are asked for."""
    from mcpn.mission.language.datatypes import PERIOD

    if not rates:
        raise InputError.at(None, "found --within, expected --rates with it: it computes probabilities")
    if not PERIOD.matches(text):
        raise InputError.at(None, f"found --within {text[:100]!r}, expected {PERIOD.expected}")
    if not PERIOD.allows(seconds := PERIOD.read(text)):
        raise InputError.at(None, f"found --within {text[:100]!r}, expected {PERIOD.allowed}")
    return float(seconds) / 3600
