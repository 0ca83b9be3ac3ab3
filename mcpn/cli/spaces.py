"""State spaces: sizes, the alternatives graph, engines side by side."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from mcpn.cli.shared import (
    EXIT_FAILED,
    FILE,
    composite_of,
    emit_counts,
    emit_json,
    import_option,
    is_net,
    json_option,
    limit_option,
    mission_net_of,
    net_of,
    progress_line,
)

if TYPE_CHECKING:
    from mcpn.net.compose import MissionNet
    from mcpn.net.petri import PetriNet
    from mcpn.space.alternatives import AlternativesGraph
    from mcpn.space.summary import SpaceSummary


@click.command()
@click.argument("file", type=FILE)
@click.option(
    "--engine",
    type=click.Choice(["explicit", "symbolic", "local", "pyeda"]),
    default="explicit",
    show_default=True,
)
@click.option("--markings", is_flag=True, help="With --engine local: count markings too, on the whole net.")
@click.option("--order", type=FILE, help="Read the diagram's order of places instead of racing several.")
@click.option(
    "--seed",
    type=click.IntRange(0, (1 << 63) - 1),
    help="Draw one more order for the race; the same seed, the same race.",
)
@click.option("--save-order", type=FILE, help="Write the order of places that was used.")
@limit_option
@import_option
@json_option
def states(
    file: Path,
    engine: str,
    markings: bool,
    order: Path | None,
    seed: int | None,
    save_order: Path | None,
    max_states: int | None,
    import_root: Path | None,
    as_json: bool,
) -> None:
    """Count the reachable markings of FILE, a mission or a net."""
    from dataclasses import asdict

    from mcpn.space.summary import summarise

    chosen = order is not None or save_order is not None or seed is not None
    if chosen and engine != "symbolic":
        raise click.UsageError("--order, --seed and --save-order are of the symbolic engine")
    if markings and engine != "local":
        raise click.UsageError("--markings is of the local engine; the others count markings anyway")
    if engine == "local":
        counts = _local_counts(mission_net_of(file, import_root), max_states, as_json, markings=markings)
        emit_counts(counts, as_json)
        return
    net = net_of(file, import_root)
    if chosen:
        emit_counts(asdict(_in_order(net, order, seed, save_order)), as_json)
        return
    with progress_line(as_json) as progress:
        counts = asdict(summarise(net, engine, max_states=max_states, progress=progress))
    emit_counts(counts, as_json)


def _in_order(net: PetriNet, order: Path | None, seed: int | None, save_order: Path | None) -> SpaceSummary:
    from mcpn.space.order import read_order, write_order
    from mcpn.space.summary import summary_of
    from mcpn.space.symbolic import reach

    started = time.perf_counter()
    space = reach(net, order=read_order(order, net) if order else None, seed=seed)
    if save_order:
        write_order(save_order, net, space.places, space.order)
    return summary_of(space, started)


def _local_counts(
    mission_net: MissionNet, max_states: int | None, quiet: bool, *, markings: bool
) -> dict[str, object]:
    """Stable states are exact; what local spaces do not tell is null, or asked of the whole net's diagram."""
    from mcpn.space.summary import summarise

    started = time.perf_counter()
    composite = composite_of(mission_net, max_states, quiet=quiet)
    names = ("states", "edges", "dead_states", "max_tokens", "nodes")
    whole = summarise(mission_net.net, "symbolic") if markings else None
    return {
        "places": len(mission_net.net.places),
        "transitions": len(mission_net.net.transitions),
        **{name: getattr(whole, name, None) for name in names},
        "stable_states": composite.everything.count(),
        "engine": "local",
        "seconds": time.perf_counter() - started,
    }


def _limits(max_states: int | None) -> dict[str, int]:
    return {} if max_states is None else {"max_states": max_states}


@click.command()
@click.argument("mission", type=FILE)
@click.option(
    "--method", type=click.Choice(["direct", "reduction", "local"]), default="direct", show_default=True
)
@click.option("--proof/--no-proof", default=True, help="Prove that internal evolution is confluent and ends.")
@click.option("-o", "--output", type=FILE, help="Write the graph: .json, .graphml, .aut, .dot, .svg or .png.")
@click.option("--section", metavar="NAME", help="The local graph of this section alone.")
@limit_option
@import_option
@json_option
def alternatives(
    mission: Path,
    method: str,
    proof: bool,
    output: Path | None,
    section: str | None,
    max_states: int | None,
    import_root: Path | None,
    as_json: bool,
) -> None:
    """Build the alternatives graph of MISSION: its stable markings and events."""
    mission_net = mission_net_of(mission, import_root)
    started = time.perf_counter()
    if section is not None:
        from mcpn.report.pictures.sections import local_graph

        mission_net, graph = local_graph(mission_net, section, max_states)
    elif method == "local" and output is None:
        emit_counts(_local_sizes(mission_net, max_states, as_json), as_json)
        return
    elif method == "local":
        graph = _written_out(mission_net, max_states, as_json)
    else:
        with progress_line(as_json) as progress:
            graph = _alternatives(mission_net, method, proof, max_states, progress)
    seconds = time.perf_counter() - started
    if output is not None:
        from mcpn.report.graphs import save_graph

        save_graph(graph, mission_net, output, section)
    counts = {
        "states": graph.states,
        "edges": graph.edges,
        "events": len({graph.event(edge) for edge in range(graph.edges)}),
        "method": graph.method,
        "seconds": seconds,
    }
    if not as_json:
        counts["proof"] = graph.proof or "none asked for"
    emit_counts(counts, as_json)


def _local_sizes(mission_net: MissionNet, max_states: int | None, quiet: bool) -> dict[str, object]:
    """Sizes of the alternatives graph of the whole by arithmetic, without writing it out."""
    started = time.perf_counter()
    composite = composite_of(mission_net, max_states, quiet=quiet)
    fired = composite.firings(composite.everything)
    return {
        "states": composite.everything.count(),
        "edges": sum(fired.values()),
        "events": len({mission_net.net.transitions[t].event for t in fired}),
        "method": "local",
        "seconds": time.perf_counter() - started,
    }


def _written_out(mission_net: MissionNet, max_states: int | None, quiet: bool) -> AlternativesGraph:
    """The alternatives graph of the whole from its sections."""
    from mcpn.space.alternatives import DEFAULT_MAX_STATES
    from mcpn.space.listing import written_out

    composite = composite_of(mission_net, None, quiet=quiet)
    limit = DEFAULT_MAX_STATES if max_states is None else max_states
    return written_out(composite, "local", "each type of section proved confluent on its own net", limit)


def _alternatives(
    mission_net: MissionNet,
    method: str,
    proof: bool,
    max_states: int | None,
    progress: Callable[[int, int], None] | None,
) -> AlternativesGraph:
    from mcpn.space.alternatives import DEFAULT_MAX_STATES, by_reduction, direct
    from mcpn.space.clash import in_mission_words
    from mcpn.space.confluence import direct_with_proof
    from mcpn.space.explicit import explore

    limits = _limits(max_states)
    with in_mission_words(mission_net):
        if method == "direct" and proof:
            return direct_with_proof(mission_net.net, progress=progress, **limits)
        if method == "direct":
            return direct(
                mission_net.net, proof=False, progress=progress, max_states=max_states or DEFAULT_MAX_STATES
            )
        return by_reduction(explore(mission_net.net, progress=progress, **limits))


@click.command()
@click.argument("file", type=FILE)
@limit_option
@import_option
@json_option
def compare(file: Path, max_states: int | None, import_root: Path | None, as_json: bool) -> None:
    """Run every engine on FILE, a mission or a net, side by side; exit code 1 if they disagree."""
    from dataclasses import asdict

    from mcpn.space.compare import disagreement, measure

    subject = net_of(file, import_root) if is_net(file) else mission_net_of(file, import_root).mission
    found = measure(subject, max_states=max_states)
    error = disagreement(found)
    if as_json:
        emit_json(
            {
                "engines": [asdict(m) for m in found],
                "agree": error is None,
                "message": str(error or "") or None,
            }
        )
        if error is not None:
            sys.exit(EXIT_FAILED)
        return
    from mcpn.report.text import print_comparison

    print_comparison(found)
    if error is not None:
        raise error
