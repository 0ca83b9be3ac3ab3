"""The command line: the one room that sees all others.

Heavy modules are imported inside the commands, so that ``mcpn --help`` answers at once. Exit codes: 0 all
required verdicts hold, 1 some verdict fails, 2 bad input or a limit hit, 130 interrupted.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mcpn import __version__
from mcpn.errors import InputError, McpnError, SemanticsError, Source

if TYPE_CHECKING:
    from mcpn.net.compose import MissionNet
    from mcpn.net.petri import PetriNet
    from mcpn.space.alternatives import AlternativesGraph
    from mcpn.space.graph import StateGraph

EXIT_FAILED, EXIT_BAD_INPUT, EXIT_INTERRUPTED = 1, 2, 130

FILE = click.Path(path_type=Path)
json_option = click.option("--json", "as_json", is_flag=True, help="Print one JSON object and nothing else.")
limit_option = click.option(
    "--max-states", type=click.IntRange(min=1), help="Give up with an error beyond this number of states."
)
import_option = click.option(
    "--import-root",
    type=FILE,
    help="Directory that imports of the mission must stay in (default: the mission's own).",
)


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="mcpn")
def command_line() -> None:
    """Verify robot missions and generate their controllers."""


def main() -> None:
    """Runs the command line; mcpn's errors, Ctrl-C and a closed pipe become messages and exit codes."""
    try:
        command_line.main(standalone_mode=False)
    except click.ClickException as error:
        error.show()
        sys.exit(EXIT_BAD_INPUT)
    except McpnError as error:
        sys.exit(_tell(error))
    except (KeyboardInterrupt, click.Abort):
        click.echo("interrupted", err=True)
        sys.exit(EXIT_INTERRUPTED)
    except BrokenPipeError:
        # The reader has gone: keep the interpreter from flushing into the closed pipe at its end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(EXIT_FAILED)


def _tell(error: McpnError) -> int:
    """Prints an error and says the exit code that goes with it."""
    problems = error.problems if isinstance(error, InputError) else (error,)
    for problem in problems:
        click.echo(f"error: {problem}", err=True)
    if isinstance(error, SemanticsError):
        for number, run in enumerate(error.runs, 1):
            click.echo(f"  run {number}: {' '.join(run)}", err=True)
        return EXIT_FAILED
    return EXIT_BAD_INPUT


# --- commands ------------------------------------------------------------------------------------------


@command_line.command()
@click.argument("mission", type=FILE)
@click.option("--engine", type=click.Choice(["explicit"]), default="explicit", show_default=True)
@limit_option
@import_option
@json_option
def check(
    mission: Path, engine: str, max_states: int | None, import_root: Path | None, as_json: bool
) -> None:
    """Verify MISSION: verdicts with their runs, sizes, functioning modes, warnings."""
    from mcpn.check.properties import check_mission
    from mcpn.mission.validate import find_warnings

    started = time.perf_counter()
    mission_net = _mission_net(mission, import_root)
    with _progress(as_json) as progress:
        found = check_mission(mission_net, max_states=max_states, progress=progress)
    seconds = time.perf_counter() - started
    if as_json:
        _print_json(_check_object(found, engine, seconds))
    else:
        from mcpn.report.text import print_check

        print_check(found, find_warnings(mission_net.mission), seconds)
    if not found.passed:
        sys.exit(EXIT_FAILED)


def _check_object(found: Any, engine: str, seconds: float) -> dict[str, Any]:
    def size(graph: StateGraph | None) -> dict[str, int | None]:
        return {
            "states": None if graph is None else graph.states,
            "edges": None if graph is None else graph.edges,
        }

    net = found.mission_net.net
    return {
        "mission": found.mission_net.mission.name,
        "places": len(net.places),
        "transitions": len(net.transitions),
        "markings": size(found.markings),
        "alternatives": size(found.alternatives),
        "verdicts": {name: verdict.holds for name, verdict in found.verdicts.items()},
        "witnesses": {
            name: [[step.event for step in run] for run in verdict.runs]
            for name, verdict in found.verdicts.items()
            if verdict.runs
        },
        "engine": engine,
        "seconds": seconds,
    }


@command_line.command()
@click.argument("file", type=FILE)
@click.option(
    "--engine", type=click.Choice(["explicit", "symbolic", "pyeda"]), default="explicit", show_default=True
)
@limit_option
@import_option
@json_option
def states(file: Path, engine: str, max_states: int | None, import_root: Path | None, as_json: bool) -> None:
    """Count the reachable markings of FILE, a mission or a net."""
    from dataclasses import asdict

    from mcpn.space.summary import summarise

    net = _net(file, import_root)
    with _progress(as_json) as progress:
        counts = asdict(summarise(net, engine, max_states=max_states, progress=progress))
    _print_counts(counts, as_json)


@command_line.command()
@click.argument("mission", type=FILE)
@click.option("--method", type=click.Choice(["direct", "reduction"]), default="direct", show_default=True)
@click.option("--proof/--no-proof", default=True, help="Prove that internal evolution is confluent and ends.")
@click.option("-o", "--output", type=FILE, help="Write the graph: .json, .graphml, .aut or .dot.")
@limit_option
@import_option
@json_option
def alternatives(
    mission: Path,
    method: str,
    proof: bool,
    output: Path | None,
    max_states: int | None,
    import_root: Path | None,
    as_json: bool,
) -> None:
    """Build the alternatives graph of MISSION: its stable markings and events."""
    mission_net = _mission_net(mission, import_root)
    started = time.perf_counter()
    with _progress(as_json) as progress:
        graph = _alternatives(mission_net, method, proof, max_states, progress)
    seconds = time.perf_counter() - started
    if output is not None:
        from mcpn.report.graphs import save_graph

        save_graph(graph, mission_net, output)
    counts = {
        "states": graph.states,
        "edges": graph.edges,
        "events": len({graph.event(edge) for edge in range(graph.edges)}),
        "method": graph.method,
        "seconds": seconds,
    }
    if not as_json:
        counts["proof"] = graph.proof or "none asked for"
    _print_counts(counts, as_json)


def _alternatives(
    mission_net: MissionNet,
    method: str,
    proof: bool,
    max_states: int | None,
    progress: Callable[[int, int], None] | None,
) -> AlternativesGraph:
    from mcpn.space.alternatives import by_reduction, direct
    from mcpn.space.confluence import direct_with_proof
    from mcpn.space.explicit import explore

    limits = {} if max_states is None else {"max_states": max_states}
    if method == "direct" and proof:
        return direct_with_proof(mission_net.net, progress=progress, **limits)
    if method == "direct":
        return direct(mission_net.net, proof=False, progress=progress, **limits)
    return by_reduction(explore(mission_net.net, progress=progress, **limits))


@command_line.command()
@click.argument("mission", type=FILE)
@click.option("--target", type=click.Choice(["json"]), default="json", show_default=True)
@click.option("-o", "--output", type=FILE, required=True, help="Directory to write the controller to.")
@limit_option
@import_option
def controller(
    mission: Path, target: str, output: Path, max_states: int | None, import_root: Path | None
) -> None:
    """Generate the controller of MISSION as a finite state machine."""
    from mcpn.controller.machine import controller as generate
    from mcpn.controller.targets.json import FILE_NAME, write_json
    from mcpn.files import write_atomically

    mission_net = _mission_net(mission, import_root)
    with _progress(False) as progress:
        graph = _alternatives(mission_net, "direct", True, max_states, progress)
    machine = generate(mission_net, graph)
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError.at(Source(str(output)), f"cannot be made a directory: {error.strerror}") from error
    path = output / FILE_NAME
    write_atomically(path, write_json(machine, mission_net))
    click.echo(f"{path}: {len(machine.states)} states, {len(machine.edges)} edges")


@command_line.command()
@click.argument("source", type=FILE)
@click.argument("target", type=FILE)
@import_option
def convert(source: Path, target: Path, import_root: Path | None) -> None:
    """Convert SOURCE (.xml mission, .pnml, .net, .json) to TARGET (.pnml, .net, .dot, .json)."""
    from mcpn.net.formats import save_net

    warning = save_net(_net(source, import_root), target)
    if warning:
        click.echo(f"warning: {warning}", err=True)


@command_line.command()
@click.argument("file", type=FILE)
@limit_option
@import_option
def compare(file: Path, max_states: int | None, import_root: Path | None) -> None:
    """Run every engine on FILE, a mission or a net, side by side; disagreement is an error."""
    from mcpn.report.text import print_comparison
    from mcpn.space.compare import disagreement, measure

    found = measure(_net(file, import_root), max_states=max_states)
    print_comparison(found)
    error = disagreement(found)
    if error is not None:
        raise error


# --- what commands share -------------------------------------------------------------------------------


def _mission_net(path: Path, import_root: Path | None) -> MissionNet:
    from mcpn.mission.xml import read_mission
    from mcpn.net.compose import compose

    return compose(read_mission(path, import_root=import_root))


def _net(path: Path, import_root: Path | None) -> PetriNet:
    """A net by its file's suffix; anything else is a mission, which its root element must confirm."""
    from mcpn.net.formats import READABLE, read_net

    if path.suffix.lower() in READABLE:
        return read_net(path)
    return _mission_net(path, import_root).net


def _print_json(document: dict[str, Any]) -> None:
    click.echo(json.dumps(document, ensure_ascii=False))


def _print_counts(counts: dict[str, Any], as_json: bool) -> None:
    if as_json:
        _print_json(counts)
    else:
        from mcpn.report.text import print_counts

        print_counts(counts)


@contextmanager
def _progress(quiet: bool) -> Iterator[Callable[[int, int], None] | None]:
    """A line on standard error that tells states and edges, where a person watches."""
    if quiet or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console

    with Console(stderr=True).status("exploring") as status:
        yield lambda found, fired: status.update(f"exploring: {found:,} states, {fired:,} edges")


if __name__ == "__main__":
    main()
