"""A mission or a net in another format: nets, pictures, the mission after a pass, its Markov chain."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from mcpn.cli.options import FILE, Question, question
from mcpn.cli.printed import emit_json
from mcpn.errors import InputError, Source

if TYPE_CHECKING:
    from mcpn.study import Study


def _list_passes(context: click.Context, _: click.Parameter, asked: bool) -> None:
    """Lists the passes, each with what it does."""
    if not asked or context.resilient_parsing:
        return
    from mcpn.mission.passes import PASSES

    width = max(len(rewrite.__name__) for rewrite in PASSES) + 2
    for rewrite in PASSES:
        click.echo(f"{rewrite.__name__:<{width}}{(rewrite.__doc__ or '').strip()}")
    context.exit()


@click.command()
@click.argument("source", type=FILE)
@click.argument("target", type=FILE, required=False)
@click.option(
    "--pass",
    "until",
    metavar="NAME",
    help="Print the mission after this pass towards the core mission, and write no TARGET.",
)
@click.option(
    "--passes",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_list_passes,
    help="List the passes in their order, and exit.",
)
@click.option(
    "--draw",
    type=click.Choice(["mission", "objectives", "net", "alternatives", "controller", "run"]),
    help="What a picture of a mission shows (default: the mission as it is written).",
)
@click.option("--section", metavar="NAME", help="Draw the net, alternatives or controller of one section.")
@click.option(
    "--rates",
    is_flag=True,
    help="Write to a .drn file the chain of a mission that has rates and durations.",
)
@question()
def convert(
    question: Question,
    source: Path,
    target: Path | None,
    until: str | None,
    draw: str | None,
    section: str | None,
    rates: bool,
) -> None:
    """Convert SOURCE (.xml mission, .pnml, .net, .json) to TARGET (.pnml, .net, .dot, .json, .svg, .png).

    TARGET is a picture where it ends in .svg or .png: of a mission that which --draw names, of a net its
    places and transitions. With --rates TARGET ends in .drn: the chain of the mission as a Markov automaton,
    for the model checker Storm. --draw run is the first counterexample that check shows, or the run without
    failures, as a sequence diagram; where TARGET ends in .mmd, as a text for Mermaid.

    With --pass NAME there is no TARGET: the mission is printed as it is after that pass, which has written
    something out that its author says in short; what is printed reads again as the same mission.
    """
    if until is not None:
        _print_pass(question, source, until, [target, draw, section, rates or None])
        return
    if target is None:
        raise click.UsageError("Missing argument 'TARGET', or --pass NAME.")
    study = question.study(source)
    question.keep_apart(source, study, target)
    from mcpn.nets.formats import WRITABLE, save_net
    from mcpn.report.pictures.drawing import KNOWN

    if rates or target.suffix.lower() == ".drn":
        if not rates or target.suffix.lower() != ".drn":
            found = "--rates" if rates else f"the suffix {target.suffix!r} without --rates"
            expected = "a file .drn with --rates, which holds the chain of a mission"
            raise InputError.at(Source(str(target)), f"found {found}, expected {expected}")
        _write_chain(study, target, question)
        return
    if draw == "run" and target.suffix.lower() == ".mmd":
        from mcpn.files import write_atomically
        from mcpn.report.pictures.runs import mermaid, run_of

        write_atomically(target, mermaid(run_of(study.mission_spaces("a run"))))
        if question.as_json:
            emit_json({"file": str(target), "warnings": []})
        return
    if target.suffix.lower() in KNOWN:
        study.picture(draw, section).save(target)
        if question.as_json:
            emit_json({"file": str(target), "warnings": []})
        return
    if draw or section:
        expected = "--draw and --section are for pictures: expected " + " or ".join(KNOWN)
        raise InputError.at(Source(str(target)), f"found the suffix {target.suffix!r}; {expected}")
    if target.suffix.lower() not in WRITABLE:
        expected = ", ".join((*WRITABLE, *KNOWN))
        raise InputError.at(Source(str(target)), f"found the suffix {target.suffix!r}, expected {expected}")
    net = study.net
    warning = save_net(net, target)
    if question.as_json:
        sizes = {"places": len(net.places), "transitions": len(net.transitions)}
        emit_json({"file": str(target), **sizes, "warnings": [warning] if warning else []})
    elif warning:
        click.echo(f"warning: {warning}", err=True)


def _print_pass(question: Question, source: Path, until: str, others: list[object]) -> None:
    """Prints a mission after a pass."""
    from mcpn.mission.passes import PASSES, core
    from mcpn.mission.writer import write_mission

    names = [rewrite.__name__ for rewrite in PASSES]
    if until not in names:
        raise click.UsageError(f"found --pass {until}, expected one of {', '.join(names)}")
    if question.as_json or any(other is not None for other in others):
        raise click.UsageError("--pass prints a mission: expected no TARGET, nor --draw, --rates or --json")
    mission = question.study(source).mission
    click.echo(write_mission(core(mission, until=until)).decode(), nl=False)


def _write_chain(study: Study, target: Path, question: Question) -> None:
    """Writes the chain of a mission with rates as a Markov automaton."""
    from mcpn.answers.causes.chain import decimal
    from mcpn.answers.causes.prospects import Prospects
    from mcpn.answers.causes.whole_chain import whole_chain
    from mcpn.files import write_atomically
    from mcpn.report.failures.drn import drn

    prospects = Prospects(study.mission_net, study.alternatives(), study.spaces.max_states)
    chain = whole_chain(prospects, decimal)
    write_atomically(target, drn(chain))
    if question.as_json:
        emit_json({"file": str(target), "states": chain.states, "edges": len(chain.sources), "warnings": []})
