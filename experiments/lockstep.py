"""The net and every controller side by side on random events: the same actions, modes and possible events.

Usage: ``python experiments/lockstep.py [--events N] [--seed S] [--generated G] [--qt N] [MISSION.xml ...]``

The net is run to completion event by event (:mod:`mcpn.controller.simulator`); it knows no machine. Against
it run, flat and hierarchical, minimised and not: the Python runtime, the compiled C, the generated Python;
on the first ``--qt`` events of each mission SCXML in Qt's interpreter (needs ``mcpn[targets]``). A tenth of
the events are impossible or unknown. Missions: those given (Ulysse by default), generated ones without
contention (:mod:`missions`) and drawn ones that may contend (:mod:`mcpn.testing`). The first difference ends
it.
With its defaults it takes some five minutes.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from missions import Parameters
from missions import generate as generate_mission

from mcpn.controller.generate import generate
from mcpn.controller.hierarchy import Controller
from mcpn.controller.minimise import minimise
from mcpn.controller.simulator import Simulation
from mcpn.controller.targets import files
from mcpn.controller.targets.json import document
from mcpn.controller.targets.scxml import event_name
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.xml import read_mission
from mcpn.net.compose import MissionNet, compose
from mcpn.net.events import Event
from mcpn.runtime import Controller as Runtime
from mcpn.runtime import Refused
from mcpn.runtime.tables import Tables
from mcpn.testing import missions as drawn

ULYSSE = Path(__file__).parent / "ulysse" / "mission.xml"
QT = Path(__file__).parents[1] / "tests" / "controller" / "qt_program.py"


def net_lines(
    mission_net: MissionNet, known: list[str], count: int, rng: random.Random
) -> Iterator[tuple[str, str]]:
    """Random events with what the net does on them; an empty event begins again."""
    simulation = Simulation(mission_net)
    taken: dict[tuple[int, str], str] = {}
    rests: dict[int, tuple[str, list[str]]] = {}

    def rest() -> tuple[str, list[str]]:
        at = simulation.marking
        if at not in rests:
            now = simulation.situation
            mode = " ".join(sorted(f"{a}.{w}" for a, w in now.mode.items()))
            possible = sorted(map(str, simulation.possible))
            rests[at] = f"{mode} | {' '.join(possible)} | {now.outcome or '-'}", possible
        return rests[at]

    everything = set(known)
    ended = 0
    for _ in range(count):
        possible = rest()[1]
        ended += simulation.situation.outcome is not None
        if not possible or ended > 3:
            ended = 0
            simulation.restart()
            yield "", ""
            possible = rest()[1]
        text = rng.choice(possible) if rng.random() < 0.9 else rng.choice([*known, "no_such_EV"])
        key = simulation.marking, text
        change = simulation.take(Event.parse(text))
        if key not in taken:
            if change is None:
                taken[key] = "refused:" if text in everything else "unknown:"
            else:
                parts = ((a.verb, a.activity or a.hardware, a.alternative) for a in change.actions)
                said = "; ".join(" ".join(part for part in parts_ if part) for parts_ in parts)
                taken[key] = f"taken: {said}".strip()
        yield text, f"{taken[key]} | {rest()[0]}"


def runtime_lines(said: dict[str, Any], events: list[str]) -> Iterator[str]:
    """What the Python runtime does."""
    tables = Tables(said)
    rests: dict[Any, str] = {}
    runtime = Runtime(tables, log=1)
    for event in events:
        if not event:
            runtime = Runtime(tables, log=1)
            continue
        try:
            head = f"taken: {'; '.join(map(str, runtime.handle(event)))}".strip()
        except Refused as refused:
            head = "refused:" if refused.known else "unknown:"
        place = runtime.section, runtime._state, runtime.out_of_service, runtime.outcome
        if place not in rests:
            mode = " ".join(sorted(f"{a}.{w}" for a, w in runtime.mode.items()))
            rests[place] = f"{mode} | {' '.join(runtime.possible)} | {runtime.outcome or '-'}"
        yield f"{head} | {rests[place]}"


def python_lines(text: str, events: list[str]) -> Iterator[str]:
    """What the generated Python does."""
    module: dict[str, Any] = {"__name__": "generated"}
    exec(compile(text, "generated.py", "exec"), module)
    make, refused, known = module["Controller"], module["EventRefused"], set(module["EVENTS"])
    rests: dict[Any, str] = {}
    controller = make()
    for event in events:
        if not event:
            controller = make()
            continue
        try:
            actions = controller.handle(event)
            said = "; ".join(" ".join(part for part in action[:3] if part) for action in actions)
            head = f"taken: {said}".strip()
        except refused:
            head = "refused:" if event in known else "unknown:"
        place = controller.section, controller.state, frozenset(controller.out_of_service)
        if place not in rests:
            mode = " ".join(sorted(f"{a}.{w}" for a, w in controller.mode.items()))
            rests[place] = f"{mode} | {' '.join(controller.possible())} | {controller.outcome or '-'}"
        yield f"{head} | {rests[place]}"


def c_lines(texts: dict[str, str], events: list[str], folder: Path) -> Iterator[str]:
    """What the compiled C does."""
    for name, text in texts.items():
        (folder / name).write_text(text)
    sources = [str(folder / name) for name in texts if name.endswith(".c")]
    subprocess.run(["gcc", "-std=c99", "-O2", "-o", str(folder / "program"), *sources], check=True)
    (folder / "events").write_text("\n".join(events) + "\n")
    with (folder / "events").open() as given, (folder / "lines").open("w") as out:
        subprocess.run([str(folder / "program"), "all"], stdin=given, stdout=out, check=True)
    with (folder / "lines").open() as out:
        for line in out:
            actions, mode, *rest = (" ".join(part.split()) for part in line.split("|"))
            yield " | ".join((actions, " ".join(sorted(mode.split())), *rest))


def qt_actions(text: str, events: list[str], folder: Path) -> list[list[str]]:
    """What Qt's interpreter of SCXML logs."""
    path = folder / "machine.scxml"
    path.write_text(text)
    run = subprocess.run(
        [sys.executable, str(QT), str(path)],
        input="\n".join(map(event_name, events)) + "\n",
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "QT_LOGGING_RULES": "*.debug=false;*.info=false"},
    )
    return [json.loads(line)[0] for line in run.stdout.splitlines()]


def compare(what: str, events: list[str], expected: list[str], found: Iterator[str]) -> None:
    """Ends with the first difference."""
    given = [event for event in events if event]
    for count, (event, wanted, line) in enumerate(zip(given, expected, found, strict=True), 1):
        if " ".join(wanted.split()) != " ".join(line.split()):
            sys.exit(f"{what}: event {count}, {event}:\n  net        {wanted}\n  controller {line}")


def variants(mission_net: MissionNet, max_states: int) -> dict[str, Controller]:
    """The controllers that a mission has."""
    found = {}
    for form in ("flat", "hierarchical"):
        try:
            controller = generate(
                mission_net, "flat" if form == "flat" else "hierarchical", max_states=max_states
            )
        except (SemanticsError, LimitError):
            continue
        found[form] = controller
        found[f"{form}, minimised"] = minimise(controller)
    return found


def run(name: str, mission_net: MissionNet, count: int, qt: int, seed: int) -> int:
    """One mission; says how many events were compared, 0 where it has no controller."""
    controllers = variants(mission_net, 20_000)
    if not controllers:
        return 0
    started = time.perf_counter()
    known = sorted(Tables(document(next(iter(controllers.values())), mission_net)).known)
    pairs = list(net_lines(mission_net, known, count, random.Random(seed)))
    events = [event for event, _ in pairs]
    expected = [line for event, line in pairs if event]
    for form, controller in controllers.items():
        what = f"{name}, {form}"
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            said = document(controller, mission_net)
            compare(f"{what}, runtime", events, expected, runtime_lines(said, events))
            compare(
                f"{what}, C", events, expected, c_lines(files(controller, mission_net, "c"), events, folder)
            )
            ((_, text),) = files(controller, mission_net, "python").items()
            compare(f"{what}, Python", events, expected, python_lines(text, events))
            if qt and find_spec("PySide6"):
                ((_, text),) = files(controller, mission_net, "scxml").items()
                logged = qt_actions(text, events[:qt], folder)
                for line, labels in zip(expected, logged, strict=False):
                    wanted = line.split("|")[0].partition(":")[2].strip()
                    if wanted != "; ".join(labels):
                        sys.exit(f"{what}, Qt: {line} against {labels}")
    sizes = ", ".join(f"{form} {c.states}" for form, c in controllers.items())
    seconds = time.perf_counter() - started
    print(f"{name}: {len(expected)} events each; states: {sizes}; {seconds:.1f} s", flush=True)
    return len(expected)


def contended(number: int, seed: int) -> list[MissionNet]:
    """Drawn missions; some may contend for resources."""
    from hypothesis import HealthCheck, Phase, given, settings
    from hypothesis import seed as seeded

    found: list[MissionNet] = []

    @seeded(seed)
    @settings(
        max_examples=60 * number,
        database=None,
        deadline=None,
        phases=(Phase.generate,),
        suppress_health_check=list(HealthCheck),
    )
    @given(drawn(max_objectives=4, max_depth=2, outputs=3))
    def collect(mission: Any) -> None:
        found.append(compose(mission))

    collect()
    found.sort(key=lambda net: (not net.usage.contentions, -len(net.net.places)))
    return found


def main() -> None:
    """Runs them all."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("missions", type=Path, nargs="*", default=[ULYSSE])
    parser.add_argument("--events", type=int, default=100_000, help="in all, for each controller")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--generated", type=int, default=8, help="missions of each generator")
    parser.add_argument("--qt", type=int, default=300, help="events of each mission for SCXML")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    import logging

    logging.getLogger("mcpn.runtime").setLevel(logging.ERROR)
    nets = {path.parent.name: compose(read_mission(path)) for path in arguments.missions}
    for i in range(arguments.generated):
        parameters = Parameters(sections=4 + i % 5, types=3, hardware=4, depth=1 + i % 2)
        nets[f"generated {i}"] = compose(generate_mission(parameters, arguments.seed + i))
    share = arguments.events // (2 * len(nets) or 1)
    total = 0
    for name, net in nets.items():
        total += run(name, net, share, arguments.qt, arguments.seed)
    some = kept = 0
    each = arguments.events // (2 * arguments.generated or 1)
    for number, net in enumerate(contended(arguments.generated, arguments.seed)):
        if kept == arguments.generated:
            break
        label = f"drawn {number}, {len(net.usage.contentions)} contentions"
        done = run(label, net, each, arguments.qt, arguments.seed)
        total += done
        kept += bool(done)
        some += bool(done and net.usage.contentions)
    print(f"{total} events, no divergence; {some} of the drawn missions contend")


if __name__ == "__main__":
    main()
