"""Engines side by side, on a file or along a family of nets; two sets of templates, or two missions."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mcpn.cli.exit_codes import EXIT_FAILED
from mcpn.cli.options import FILE, FiniteRange, Question, question
from mcpn.cli.printed import emit_json

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mcpn.answers.compare import Measured, Runs
    from mcpn.answers.spaces_by_engine import MissionSpaces


@click.command()
@click.argument("file", type=FILE, required=False)
@click.argument("other", type=FILE, required=False)
@click.option(
    "--family",
    nargs=2,
    metavar="NAME SIZES",
    help="Instead of FILE, the nets of a family that grow: philosophers 5..100, or 5..100..5 in steps of 5.",
)
@click.option(
    "--format",
    "form",
    type=click.Choice(["text", "csv", "latex", "json"]),
    default="text",
    help="How the table is written.",
)
@click.option(
    "--repeat",
    type=click.IntRange(1, 1000),
    default=1,
    help="Run each engine this many times; the minimum and the median are reported.",
)
@click.option(
    "--seconds",
    type=FiniteRange(0.001, 86400),
    default=60.0,
    show_default=True,
    help="Wall-clock limit on each run.",
)
@click.option(
    "--engine",
    "own",
    multiple=True,
    metavar="MODULE:CLASS",
    help="Run an engine of your own beside the others; may be given several times.",
)
@click.option(
    "--plot",
    type=FILE,
    help="Write a plot of seconds, memory and nodes: .svg or .png (needs mcpn[experiments]).",
)
@click.option(
    "--templates",
    "sets",
    nargs=2,
    metavar="SET SET",
    help="Compare two sets of templates on a mission, instead of engines: paper, compact, or MODULE:NAME.",
)
@question(templates=False)
def compare(
    question: Question,
    file: Path | None,
    other: Path | None,
    family: tuple[str, str] | None,
    form: str,
    repeat: int,
    seconds: float,
    own: tuple[str, ...],
    plot: Path | None,
    sets: tuple[str, str] | None,
) -> None:
    """Run every engine on FILE, a mission or a net, side by side; exit code 1 if they disagree.

    With a family: on its nets as they grow, with how CPU time grows. With two sets of templates: whether the
    mission behaves the same with both, event by event. With a second mission, OTHER: what it loses or gains
    over FILE in claims, verdicts, cut sets and modes; exit code 1 if something differs.
    """
    from mcpn.answers.compare import Runs, disagreement, measure

    form = "json" if question.as_json else form
    if (file is None) == (family is None):
        raise click.UsageError("expected a FILE, or --family NAME SIZES, and not both")
    if other is not None:
        assert file is not None
        if sets or plot is not None or own or form not in ("text", "json"):
            raise click.UsageError(
                "two missions take neither --templates, --plot, --engine nor a table's --format"
            )
        _compare_missions(file, other, question, form == "json")
        return
    if sets:
        if file is None or plot is not None or own or form not in ("text", "json"):
            raise click.UsageError(
                "--templates takes a mission, and neither --plot, --engine nor a table's --format"
            )
        _compare_sets(file, sets, question, form == "json")
        return
    if plot is not None:
        from mcpn.report.pictures.plots import ready

        ready(plot)
    if own:
        from mcpn.spaces.custom_engine import engine_named

        for name in own:
            engine_named(name)
    runs = Runs(question.max_states, seconds, repeat, own)
    if family is not None:
        members = _members(*family, runs)
    else:
        assert file is not None
        study = question.study(file)
        subject = study.net if study.is_net else study.mission_net.mission
        members = [measure(subject, runs)]
    if plot is not None:
        from mcpn.report.pictures.plots import save_engines

        save_engines(plot, members)
    error = next((e for member in members if (e := disagreement(member.engines)) is not None), None)
    from mcpn.report.comparison import comparison_object, print_comparison, table

    if form == "json":
        emit_json(comparison_object(members, error))
    elif form == "text":
        print_comparison(members)
    else:
        click.echo(table(members, form), nl=False)
    if error is not None:
        if form == "json":
            sys.exit(EXIT_FAILED)
        raise error


def _members(name: str, sizes: str, runs: Runs) -> Sequence[Measured]:
    from mcpn.answers.compare import grown
    from mcpn.testing.nets import FAMILIES

    if (family := FAMILIES.get(name)) is None:
        raise click.UsageError(f"found the family {name!r}, expected one of {', '.join(sorted(FAMILIES))}")
    if (found := re.fullmatch(r"(\d{1,9})(?:\.\.(\d{1,9})(?:\.\.(\d{1,9}))?)?", sizes)) is None:
        raise click.UsageError(f"found the sizes {sizes!r}, expected FIRST..LAST or FIRST..LAST..STEP")
    first, last, step = int(found[1]), int(found[2] or found[1]), int(found[3] or 1)
    if first < family.least or last < first or step < 1:
        raise click.UsageError(
            f"found the sizes {sizes!r}, expected sizes of {name} that grow from {family.least}"
        )
    nets = ((size, family.net(size)) for size in range(first, last + 1, step))
    return list(grown(nets, runs))


def _compare_missions(file: Path, other: Path, question: Question, as_json: bool) -> None:
    from mcpn.answers.versions import compared
    from mcpn.errors import InputError, Source
    from mcpn.report.versions import difference_object, print_difference

    def mission(path: Path) -> MissionSpaces:
        study = question.study(path)
        if study.is_net:
            raise InputError.at(
                Source(str(path)), "found a net, expected a mission: two missions are compared"
            )
        return study.mission_spaces()

    with question.work():
        found = compared(mission(file), mission(other))
    if as_json:
        emit_json(difference_object(found, str(file), str(other)))
    else:
        print_difference(found, str(file), str(other))
    if not found.same:
        sys.exit(EXIT_FAILED)


def _compare_sets(file: Path, names: tuple[str, str], question: Question, as_json: bool) -> None:
    from dataclasses import asdict, replace

    from mcpn.answers.template_equivalence import likeness_of
    from mcpn.drawing.templates.named import templates_named
    from mcpn.report.text import print_likeness

    sets = [templates_named(name) for name in names]
    studies = [replace(question, templates=templates).study(file) for templates in sets]
    one, other = (study.mission_spaces() for study in studies)
    found = likeness_of(one, other, names=names)
    if as_json:
        parted = found.difference
        sizes = [{"templates": name} | asdict(size) for name, size in zip(names, found.sizes, strict=True)]
        told = parted and {
            "events": [str(event) for event in parted.events],
            "message": parted.message,
            "firings": parted.firings,
        }
        emit_json({"sets": sizes, "same": parted is None, "isomorphic": found.isomorphic, "difference": told})
    else:
        print_likeness(found, names, studies[0].mission_net.mission.name)
    if found.difference is not None:
        sys.exit(EXIT_FAILED)
