"""How many states a net or a mission has, by whichever engine counts them."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mcpn.cli.options import FILE, Question, engine_option, question
from mcpn.cli.printed import choice_object, emit_counts
from mcpn.spaces.engine_names import PYEDA, SYMBOLIC

if TYPE_CHECKING:
    from mcpn.spaces.engine_names import Counting, On
    from mcpn.spaces.registry import Spaces
    from mcpn.spaces.summary import SpaceSummary


@click.command()
@click.argument("file", type=FILE)
@engine_option(PYEDA)
@click.option(
    "--on",
    "graph",
    type=click.Choice(["markings", "alternatives"]),
    help="Count all markings, or stable states alone (by default those of a mission with many markings).",
)
@click.option("--order", type=FILE, help="Read the diagram's order of places instead of racing several.")
@click.option(
    "--seed",
    type=click.IntRange(0, (1 << 63) - 1),
    help="Draw one more order for the race; the same seed, the same race.",
)
@click.option("--save-order", type=FILE, help="Write the order of places that was used.")
@question()
def states(
    question: Question,
    file: Path,
    engine: Counting,
    graph: On | None,
    order: Path | None,
    seed: int | None,
    save_order: Path | None,
) -> None:
    """Count the reachable states of FILE: the markings of a net, the stable states of a large mission."""
    from dataclasses import asdict

    chosen = order is not None or save_order is not None or seed is not None
    if chosen and (engine not in ("auto", SYMBOLIC) or graph == "alternatives"):
        raise click.UsageError("--order, --seed and --save-order need the symbolic engine, on markings")
    with question.progress():
        study = question.study(file)
    if chosen:
        found = _in_order(study.spaces, order, seed, save_order)
        emit_counts(asdict(found) | {"why": None}, question.as_json)
        return
    with question.progress():
        found, choice = study.sizes(engine=engine, on=graph)
    emit_counts(
        asdict(found) | ({"why": None} if choice is None else choice_object(choice)), question.as_json
    )


def _in_order(spaces: Spaces, order: Path | None, seed: int | None, save_order: Path | None) -> SpaceSummary:
    from mcpn.spaces.diagrams.order import read_order, write_order
    from mcpn.spaces.summary import summary_of

    started, net = time.perf_counter(), spaces.net
    space = spaces.ordered(read_order(order, net) if order else None, seed)
    if save_order:
        write_order(save_order, net, space.places, space.order)
    return summary_of(space, started)
