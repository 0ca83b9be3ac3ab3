"""The alternatives graph: its sizes, and the graph as a file or a picture."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mcpn.cli.options import FILE, Question, engine_option, question
from mcpn.cli.printed import choice_object, emit_counts
from mcpn.spaces.engine_names import EXPLICIT

if TYPE_CHECKING:
    from mcpn.answers.spaces_by_engine import MissionSpaces
    from mcpn.spaces.algebra import Space
    from mcpn.spaces.engine_names import Asked
    from mcpn.spaces.engines import Choice


@click.command()
@click.argument("mission", type=FILE)
@engine_option()
@click.option(
    "--method",
    type=click.Choice(["direct", "reduction"]),
    help="How --engine explicit goes on: from stable state to stable state, or through all markings.",
)
@click.option("--proof/--no-proof", default=True, help="Prove that internal evolution is confluent and ends.")
@click.option("-o", "--output", type=FILE, help="Write the graph: .json, .graphml, .aut, .dot, .svg or .png.")
@click.option("--section", metavar="NAME", help="The local graph of this section alone.")
@question()
def alternatives(
    question: Question,
    mission: Path,
    engine: Asked,
    method: str | None,
    proof: bool,
    output: Path | None,
    section: str | None,
) -> None:
    """Build the alternatives graph of MISSION: its stable markings and events."""
    from mcpn.composite.clash_sentences import in_mission_words
    from mcpn.spaces.arrays import ArraySpace
    from mcpn.spaces.engines import answered
    from mcpn.spaces.stable.alternatives import AlternativesGraph
    from mcpn.spaces.stable.written_out import written_out

    if method is not None or not proof:
        if engine not in ("auto", EXPLICIT):
            raise click.UsageError("--method and --no-proof need the explicit engine")
        engine = EXPLICIT
    study = question.study(mission)
    spaces = study.mission_spaces("the alternatives graph")
    started = time.perf_counter()
    if section is not None:
        spaces, engine = spaces.section(section), EXPLICIT
    spaces = spaces.bound(engine=engine, max_states=question.max_states)

    def ask(choice: Choice) -> Space[Any]:
        if choice.engine == EXPLICIT and not choice.brief:
            with question.progress():
                return _listed(spaces, method or "direct", proof, choice)
        with question.progress():
            return spaces.space(choice, "alternatives")

    with in_mission_words(spaces.mission):
        space, choice = answered(ask, spaces.choices("alternatives"))
    listed = space.graph if isinstance(space, ArraySpace) else None
    graph = listed if isinstance(listed, AlternativesGraph) else None
    if output is not None:
        from mcpn.report.graphs import save_graph

        whole = graph or written_out(space, choice.engine, question.max_states)
        save_graph(whole, spaces.mission, output, section)
    fired = space.firings(space.everything)
    counts = {
        "states": space.everything.count(),
        "edges": sum(fired.values()),
        "events": len({spaces.net.transitions[t].event for t in fired}),
        "method": choice.engine if graph is None else graph.method,
        **choice_object(choice),
        "seconds": time.perf_counter() - started,
    }
    if graph is not None and not question.as_json:
        counts["proof"] = graph.proof or "none asked for"
    emit_counts(counts, question.as_json)


def _listed(spaces: MissionSpaces, method: str, proof: bool, choice: Choice) -> Space[Any]:
    """The alternatives graph as the user wants it listed."""
    if method == "reduction":
        return spaces.reduced(choice)[0]
    if not proof:
        return spaces.unproved(choice.limit)
    return spaces.space(choice, "alternatives")
