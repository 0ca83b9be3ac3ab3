"""Verdicts of a mission or a net: on a terminal, as JSON, as annotations of lines, with a certificate."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NoReturn

import click

from mcpn.cli.exit_codes import EXIT_BAD_INPUT, EXIT_FAILED
from mcpn.cli.options import FILE, Question, engine_option, question
from mcpn.cli.printed import choice_object, emit_json, tell_warnings
from mcpn.errors import InputError, Source

if TYPE_CHECKING:
    from mcpn.answers.verdicts.mission import MissionCheck
    from mcpn.certificates.checked_claims import Verified
    from mcpn.report.annotations import AnnotationForm
    from mcpn.spaces.engine_names import Asked


@click.command()
@click.argument("file", type=FILE)
@click.option("--structure", is_flag=True, help="Report what the net's arcs prove without its markings.")
@engine_option()
@click.option(
    "--internal", is_flag=True, help="Show the firings inside the net between which the outcome is decided."
)
@click.option("--strict", is_flag=True, help="Treat warnings as failures: exit code 1.")
@click.option(
    "--certificate",
    type=FILE,
    metavar="OUT",
    help="Of a mission: write its claims to OUT, with evidence, and have certcheck check it.",
)
@click.option(
    "--format",
    "form",
    type=click.Choice(["text", "sarif", "github"]),
    default="text",
    show_default=True,
    help="Of a mission or a tree: places in its files, as a log of SARIF or as annotations of GitHub.",
)
@question(workers=True)
def check(
    question: Question,
    file: Path,
    structure: bool,
    engine: Asked,
    internal: bool,
    strict: bool,
    certificate: Path | None,
    form: Literal["text", "sarif", "github"],
) -> None:
    """Verify FILE: a mission's verdicts with their runs, or the behaviour of a net from elsewhere."""
    started = time.perf_counter()
    if certificate is not None and (structure or form != "text"):
        what = "--structure" if structure else f"--format {form}"
        raise click.UsageError(f"--certificate is of all that check says, and {what} says something else")
    if form != "text":
        _annotate(question, file, structure, engine, strict, form)
    with question.progress():
        study = question.study(file, engine)
    if certificate is not None:
        study.mission_spaces("a certificate")
        question.keep_apart(file, study, certificate)
    if structure or study.is_net:
        from mcpn.report.nets import net_object, print_net, print_structure, structure_object

        if structure:
            arcs = study.structure()
            emit_json(structure_object(arcs)) if question.as_json else print_structure(arcs)
        else:
            with question.progress():
                does = study.behaviour()
            emit_json(net_object(does)) if question.as_json else print_net(does)
        return

    warned = [] if question.as_json else tell_warnings(study.mission_net)
    with question.work():
        found = study.verdicts()
        seconds = time.perf_counter() - started
        written = None if certificate is None else certified(found, certificate, question.max_states)
    if question.as_json:
        emit_json({**_check_object(found, seconds, internal), **({} if written is None else written.said)})
    else:
        from mcpn.report.certificates import print_certificate, print_unchecked
        from mcpn.report.checked import print_check

        print_check(found, seconds, internal=internal, told=warned, strict=strict)
        print_unchecked() if written is None else print_certificate(written)
    refuted = written is not None and written.keys("refuted")
    if not found.passed or (strict and found.warnings) or refuted:
        sys.exit(EXIT_FAILED)


def certified(found: MissionCheck, out: Path, max_states: int | None) -> Verified:
    """Writes the certificate of a check, and has certcheck check it."""
    from mcpn.certificates.checked_claims import verified
    from mcpn.certificates.writing import certificate_of
    from mcpn.files import write_atomically

    certificate = certificate_of(found, max_states)
    write_atomically(out, certificate.to_bytes())
    return verified(certificate, out)


def _annotate(
    question: Question, file: Path, structure: bool, engine: Asked, strict: bool, form: AnnotationForm
) -> NoReturn:
    """Prints what is wrong with a mission or a tree by its places, and ends the command."""
    from mcpn.report.annotations import annotated, of_ledger, of_problems, written

    if structure or question.as_json:
        raise click.UsageError(f"--format {form} is of the check of a mission or a tree, and stands alone")
    whole, code = Source(str(file), 1), 0
    try:
        with question.work():
            study = question.study(file, engine)
            if study.is_net:
                raise InputError.at(
                    whole,
                    f"expected a mission or a tree: --format {form} names places in it",
                )
            found = study.verdicts()
        said = [*annotated(found, str(file))]
        if study.ledger is not None:
            said += of_ledger(found, study.ledger, whole)
        code = 0 if found.passed and not (strict and found.warnings) else EXIT_FAILED
    except InputError as error:
        said, code = [*of_problems(error.problems, "error", whole)], EXIT_BAD_INPUT
    if text := written(form, said):
        click.echo(text)
    sys.exit(code)


def _requirements_object(found: MissionCheck) -> list[dict[str, Any]]:
    from mcpn.cli.ask import witness_object

    net = found.mission_net.net
    return [
        {
            **answer.asked.said,
            "holds": answer.holds,
            "met": answer.met,
            "vacuous": list(answer.vacuous),
            "ignored": [each.event for each in found.changing_nothing if each.event in answer.asked.events],
            "witness": None if answer.witness is None else witness_object(answer.witness, net),
        }
        for answer in found.requirements
    ]


def _translated_object(found: MissionCheck) -> dict[str, Any]:
    """What the mission says of behaviour trees that it was made of, if it was."""
    translated = found.mission_net.mission.translated
    if not translated:
        return {}
    from mcpn.trees.ledger import of_translated

    return {
        "translated": [
            {
                "from": each.tree,
                **({"library": each.library} if each.library else {}),
                "exact": each.exact,
                "approximations": [
                    {"node": a.node, "line": a.line, "kind": a.kind, "why": a.description or ""}
                    for a in each.approximations
                ],
                "survives": of_translated(each)[1],
            }
            for each in translated
        ]
    }


def _check_object(found: MissionCheck, seconds: float, internal: bool) -> dict[str, Any]:
    from mcpn.answers.claims import claims_of
    from mcpn.answers.claims.unasked import DEFEATING, UNASKED, runs_of_unasked

    net, claims = found.mission_net.net, claims_of(found)
    shown = {each.claim.key: each for each in runs_of_unasked(claims, (*DEFEATING, *UNASKED)).values()}
    return {
        "mission": found.mission_net.mission.name,
        "places": len(net.places),
        "transitions": len(net.transitions),
        "markings": dict(zip(("states", "edges"), found.sizes_seen or (None, None), strict=True)),
        "alternatives": dict(zip(("states", "edges"), found.stable_sizes or (None, None), strict=True)),
        **({"requirements": _requirements_object(found)} if found.requirements else {}),
        "verdicts": {name: verdict.holds for name, verdict in found.verdicts.items()},
        "undecided": found.undecided,
        "claims": [claim.to_json() for claim in claims],
        "runs": {
            key: {"events": [*map(str, each.events)], "repeats": each.repeats} for key, each in shown.items()
        },
        "warnings": [
            {"file": at and at.file, "line": at and at.line, "message": problem.message}
            for problem in found.warnings
            for at in (problem.source,)
        ],
        "witnesses": {
            name: [[*map(str, run.events), *run.tail] for run in runs]
            for name, verdict in found.verdicts.items()
            if (runs := verdict.runs if internal else verdict.runs_of_events)
        },
        "ignored": [
            {
                "event": each.event,
                "objectives": list(each.objectives),
                "answering": list(each.answering),
                "required": each.required,
            }
            for each in found.changing_nothing
        ],
        "late": [
            {
                "hardware": each.hardware,
                "unnoticed": list(each.unnoticed),
                "unnoticed_later": list(each.unnoticed_later),
                "in_time": list(each.in_time),
            }
            for each in found.late
        ],
        "nominal": {
            "left_out": list(found.verdicts["nominal_success"].left_out),
            "cycle": found.verdicts["nominal_success"].cycle,
        },
        **_translated_object(found),
        **({"skipped": list(skipped)} if (skipped := found.verdicts["success_reachable"].skipped) else {}),
        **choice_object(found.choice),
        "seconds": seconds,
    }
