"""Many runs of a mission's controller in virtual time, beside the numbers of risk."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mcpn.cli.exit_codes import EXIT_FAILED
from mcpn.cli.options import FILE, FiniteRange, Question, question
from mcpn.cli.printed import emit_json
from mcpn.cli.robot.watching import monitors_for
from mcpn.errors import InputError, LimitError
from mcpn.robot.bench import AGAINST

if TYPE_CHECKING:
    from mcpn.answers.causes.risk import Risk
    from mcpn.robot.bench.generated_code import Difference, Generated
    from mcpn.robot.bench.runs import Bench, BenchRun
    from mcpn.study import Study


@click.command()
@click.argument("mission", type=FILE)
@click.option("--runs", type=click.IntRange(min=1), default=10_000, show_default=True, help="How many.")
@click.option("--seed", type=int, default=0, show_default=True, help="Of what happens in them.")
@click.option(
    "--confidence",
    type=FiniteRange(0.0, 1.0, min_open=True, max_open=True),
    default=0.999,
    show_default=True,
    help="The confidence of the intervals that the numbers of risk must lie in.",
)
@click.option(
    "--duration",
    type=FiniteRange(0.0, min_open=True),
    help="Mean hours where none are given (default: such runs are untimed).",
)
@click.option("--faults", type=FILE, help="Further events that happen: on each line hours and an event.")
@click.option("--against", type=click.Choice(AGAINST), help="Compare generated code on all runs.")
@click.option("--traces", type=FILE, help="Directory for a journal of each of the first ten failures.")
@click.option("--monitors", "watching", is_flag=True, help="Watch the mission's requirements on all runs.")
@question(trees=False)
def bench(
    question: Question,
    mission: Path,
    runs: int,
    seed: int,
    confidence: float,
    duration: float | None,
    faults: Path | None,
    against: str | None,
    traces: Path | None,
    watching: bool,
) -> None:
    """Run the controller of MISSION many times with fake drivers, in virtual time.

    Drivers take the mission's durations, rates and probabilities, exponential as for the numbers of risk
    (causes --rates), which stand beside: exit code 1 where one lies outside of its interval, or where
    generated code does anything else than the runtime.
    """
    from mcpn.controller.chances import chances_of
    from mcpn.controller.document import document
    from mcpn.files import write_folder
    from mcpn.mission.static.interval_rates import at_their_means
    from mcpn.robot.bench.fault_scripts import read_script
    from mcpn.robot.bench.runs import bench as played
    from mcpn.robot.bench.runs import nominal_run_of, one_run_of
    from mcpn.robot.bench.world import World
    from mcpn.robot.runtime.controller_tables import Tables

    study = question.study(mission)
    mission_net = study.mission_net
    untimed = duration is None and any(section.duration is None for section in mission_net.graph.walk())
    controller = study.controller("auto")
    said = document(controller, mission_net)
    world = World(Tables(said), chances_of(mission_net), duration)
    script = [] if faults is None else read_script(faults, world.places.tables.known)
    nominal = nominal_run_of(world)
    started = time.perf_counter()
    found = played(world, runs, seed, script)
    seconds = time.perf_counter() - started
    numbers, why = None, None
    if untimed:
        why = "objectives have no duration (nor --duration is given): the runs are untimed"
    elif script:
        why = "a script of faults is played"
    else:
        numbers, why = _risk(study)
    told = {
        "mission": controller.mission,
        "form": controller.form,
        "runs": runs,
        "seed": seed,
        "confidence": confidence,
        "nominal": {"outcome": nominal.outcome, "events": [e.event for e in nominal.events]},
        **_shares(found, numbers, confidence),
        "hours": None if untimed else found.hours,
        "no_risk": why,
        "coverage": {
            "modes": found.coverage.modes,
            "of_modes": found.coverage.every_mode,
            "edges": found.coverage.edges,
            "of_edges": found.coverage.every_edge,
        },
        "against": None,
        "monitors": None,
        "traces": [],
        "events": found.taken,
        "seconds": seconds,
    }
    if traces is not None:
        files = {f"run_{i}.jsonl": _journal(run) for i, run in enumerate(found.traces, 1)}
        write_folder(traces, files)
        told["traces"] = [str(traces / name) for name in files]
    every = (one_run_of(world, seed, number, script) for number in range(runs))
    if watching:
        from mcpn.robot.bench.monitored_runs import watched

        told["monitors"] = watched(monitors_for(study), every)
    if against is not None:
        from mcpn.robot.bench.generated_code import compare

        with tempfile.TemporaryDirectory() as folder:
            program = _generated(against, said, Path(folder))
            every = (one_run_of(world, seed, number, script) for number in range(runs))
            difference = compare(program, world.places, ([e.event for e in run.events] for run in every))
        told["against"] = _difference(against, difference)
    if question.as_json:
        emit_json(told)
    else:
        if means := at_their_means(mission_net.core):
            click.echo(means)
        _print(told)
    if not _agrees(told):
        click.get_current_context().exit(EXIT_FAILED)


def _generated(target: str, document: dict[str, Any], folder: Path) -> Generated:
    if target == "scxml":
        from mcpn.robot.bench.scxml_replay import Statechart
        from mcpn.robot.runtime.documents import FORMS

        if document["form"] == FORMS[-1]:
            raise LimitError("--against scxml: the controller is modular, and SCXML has no such form")
        return Statechart(document)
    from mcpn.robot.bench.generated_code import Program

    return Program(document, target, folder)


def _risk(study: Study) -> tuple[Risk | None, str | None]:
    """The numbers of risk, or why there are none."""
    if any(study.mission_net.graph.timed):
        return None, "numbers of risk know no timeouts"
    try:
        from mcpn.answers.causes.risk import risk

        return risk(study.causes().prospects), None
    except (LimitError, InputError) as error:
        return None, str(error).partition("\n")[0]


def _shares(found: Bench, numbers: Risk | None, confidence: float) -> dict[str, Any]:
    from statistics import NormalDist

    from mcpn.robot.bench.runs import ENDS, interval

    outcomes = {}
    expected: dict[str, float | None] = {name: getattr(numbers, name, None) for name in ENDS}
    if numbers is not None:
        expected["abort"] = numbers.abort or 0.0
        expected["unfinished"] = max(0.0, 1.0 - sum(expected[name] or 0.0 for name in ENDS))
    for name in (*ENDS, "unfinished"):
        count = found.outcomes[None if name == "unfinished" else name]
        low, high = interval(count, found.runs, confidence)
        outcomes[name] = {"count": count, **_beside(count / found.runs, low, high, expected.get(name))}
    mean, error = found.degraded
    z = NormalDist().inv_cdf(0.5 + confidence / 2)
    half = z * max(error, z / found.runs)  # where it was never seen there is no error to estimate
    whole = numbers is not None and not found.outcomes[None]
    modes = numbers.degraded_modes if numbers is not None and whole else None
    return {"outcomes": outcomes, "degraded_modes": _beside(mean, max(0.0, mean - half), mean + half, modes)}


def _beside(share: float, low: float, high: float, expected: float | None) -> dict[str, Any]:
    rounding = 1e-9
    agrees = None if expected is None else low - rounding <= expected <= high + rounding
    return {"mean": share, "low": low, "high": high, "risk": expected, "agrees": agrees}


def _journal(run: BenchRun) -> str:
    from mcpn.robot.runtime.file_schema import signed_line

    rows = (
        {"time": event.hours * 3600, "event": event.event, "refused": event.refused} for event in run.events
    )
    return "".join(signed_line(row) + "\n" for row in rows)


def _difference(target: str, difference: Difference | None) -> dict[str, Any]:
    if difference is None:
        return {"target": target, "agrees": True, "events": [], "expected": None, "found": None}
    return {
        "target": target,
        "agrees": False,
        "events": list(difference.events),
        "expected": difference.expected,
        "found": difference.found,
    }


def _agrees(told: dict[str, Any]) -> bool:
    each = [*told["outcomes"].values(), told["degraded_modes"], told["against"] or {}]
    return all(figure.get("agrees") is not False for figure in each)


def _print(told: dict[str, Any]) -> None:
    from mcpn.report.text import print_counts

    click.echo(f"{told['form']} controller of {told['mission']}: {told['runs']:,} runs, seed {told['seed']}")
    nominal = told["nominal"]
    ends = f"ends in {nominal['outcome']}" if nominal["outcome"] else "does not end"
    rows = {"nothing fails": f"the run {ends}, after {len(nominal['events']):,} events"}
    for name, figure in (*told["outcomes"].items(), ("degraded modes", told["degraded_modes"])):
        text = f"{figure['mean']:.6g}  [{figure['low']:.6g}, {figure['high']:.6g}]"
        if figure["risk"] is not None:
            text += f"  risk {figure['risk']:.6g}" + ("" if figure["agrees"] else "  OUTSIDE")
        rows[name] = text
    if told["hours"] is not None:
        rows["mean hours"] = f"{told['hours']:.6g}"
    for name in ("modes", "edges"):
        of_all = told["coverage"][f"of_{name}"]
        rows[f"{name} seen"] = f"{told['coverage'][name]:,}" + ("" if of_all is None else f" of {of_all:,}")
    rows["events"] = f"{told['events']:,} in {told['seconds']:.2f} s"
    print_counts(rows)
    for name, counts in (told["monitors"] or {}).items():
        click.echo(f"{name}: " + ", ".join(f"{value} in {n:,}" for value, n in counts.items() if n))
    if told["no_risk"]:
        click.echo(f"no numbers of risk: {told['no_risk']}")
    if told["against"]:
        figure = told["against"]
        if figure["agrees"]:
            click.echo(f"{figure['target']}: does the same on every event")
        else:
            click.echo(f"{figure['target']}: does something else on the last of {' '.join(figure['events'])}")
            click.echo(f"  expected {figure['expected']}\n  found    {figure['found']}")
    for path in told["traces"]:
        click.echo(path)
