"""The net and every controller side by side on random events: the same actions, modes and possible events.

Usage: ``python experiments/judges/lockstep.py [--events N] [--seed S] [--generated G] [--qt N] [--kinds KIND
...] [MISSION.xml ...]``

The net is run to completion event by event (:mod:`mcpn.controller.likelihood`); it knows no machine. Against
it run, flat and hierarchical, minimised and not, and modular: the Python runtime, the compiled C, the
generated Python; on the first ``--qt`` events of each mission SCXML in Qt's interpreter (needs
``mcpn[targets]``; the modular form has none). Compared are actions, mode, possible events and outcome; of
SCXML actions and active states, those of the runtime. A tenth of the events are impossible or unknown.
Missions: those given (the five of this folder by default), generated ones without contention
(:mod:`missions`), and drawn ones that contend, that declared events interrupt, or whose hardware is detected
late (:mod:`mcpn.testing`). A form with more than 20,000 states is left out, and said to be. The first
difference ends it. With its defaults it takes some five minutes.
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
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any, get_args

sys.path.append(str(Path(__file__).resolve().parents[2]))

import mcpn.robot.runtime
from experiments.shared.missions import Parameters
from experiments.shared.missions import generate as generate_mission
from mcpn.composite.composing import composite_space
from mcpn.controller.document import document
from mcpn.controller.generate import Form, generate
from mcpn.controller.hierarchy import TableController
from mcpn.controller.minimise import minimise
from mcpn.controller.modular import AnyController
from mcpn.controller.simulator import Simulation
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.events import Event
from mcpn.mission.xml import read_mission
from mcpn.robot.runtime.controller_tables import Tables
from mcpn.robot.targets import files
from mcpn.robot.targets.identifiers import identifiers
from mcpn.robot.targets.scxml import event_name
from mcpn.testing import missions

HERE = Path(__file__).parents[1]
BESIDE = [HERE / name / "mission.xml" for name in ("ulysse", "courier", "drone", "glider", "rover")]
KINDS = ("given", "contended", "interrupted", "detected late")
MOST_STATES = 20_000
MOST_PLACES = 160
FEWEST_STATES = 20
QT = Path(__file__).parents[2] / "tests" / "controller" / "qt_program.py"


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


def runtime_lines(module: Any, tables: Any, events: list[str]) -> Iterator[str]:
    """What the Python runtime does, in mcpn or in a generated file."""
    rests: dict[Any, str] = {}
    runtime = module.Controller(tables, log=1)
    for event in events:
        if not event:
            runtime = module.Controller(tables, log=1)
            continue
        try:
            head = f"taken: {'; '.join(map(str, runtime.handle(event)))}".strip()
        except module.Refused as refused:
            head = "refused:" if refused.known else "unknown:"
        happened = frozenset(runtime._true)
        place = runtime.section, runtime._state, runtime.out_of_service, happened, runtime.outcome
        if place not in rests:
            mode = " ".join(sorted(f"{a}.{w}" for a, w in runtime.mode.items()))
            rests[place] = f"{mode} | {' '.join(runtime.possible)} | {runtime.outcome or '-'}"
        yield f"{head} | {rests[place]}"


def python_lines(text: str, events: list[str]) -> Iterator[str]:
    """What the generated Python does."""
    module: Any = ModuleType("generated")
    sys.modules["generated"] = module  # dataclasses look their module up there
    exec(compile(text, "generated.py", "exec"), module.__dict__)
    return runtime_lines(module, module.TABLES, events)


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


def qt_lines(text: str, events: list[str], folder: Path) -> Iterator[str]:
    """What Qt's interpreter of SCXML logs, and the active states that have no children."""
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
    for line in run.stdout.splitlines():
        labels, active, _ = json.loads(line)
        yield f"{'; '.join(labels)} | {' '.join(sorted(active))}"


def wanted_of_qt(
    controller: TableController, said: dict[str, Any], events: list[str], expected: list[str]
) -> list[str]:
    """The actions of the net, and the states in which the document's own names put the runtime."""
    sections = identifiers([section.name for section in controller.sections], prefix="section_")
    regions = identifiers(controller.hardware, prefix="hardware_")
    handlers = (s.names["once"].get(h, h) for s in controller.sections for h in controller.types[s.type].once)
    once = identifiers(dict.fromkeys(handlers), prefix="once_")
    tables = Tables(said)
    facts = identifiers(sorted(tables.of_facts), prefix="fact_")
    runtime, found, lines = mcpn.robot.runtime.Controller(tables, log=1), [], iter(expected)
    for event in events:
        if not event:
            runtime = mcpn.robot.runtime.Controller(tables, log=1)
            continue
        with suppress(mcpn.robot.runtime.Refused):
            runtime.handle(event)
        at = runtime.outcome or "before"
        if runtime.section is not None:
            at = f"{sections[runtime.section]}.{runtime._state}"
        gone = runtime.out_of_service
        active = [at, *(f"{i}.{'out' if h in gone else 'ready'}" for h, i in regions.items())]
        active += [f"{i}.{'happened' if h in runtime.happened else 'open'}" for h, i in once.items()]
        true = {said for name, value in runtime.facts.items() for said in tables.facts[name][value]}
        true |= {known for h, known in tables.late.items() if h in runtime.out_of_service - runtime.unnoticed}
        active += [f"{i}.{'on' if name in true else 'off'}" for name, i in facts.items()]
        actions = next(lines).split("|")[0].partition(":")[2].strip()
        found.append(f"{actions} | {' '.join(sorted(active))}")
    return found


def compare(what: str, events: list[str], expected: list[str], found: Iterator[str]) -> None:
    """Ends with the first difference."""
    given = [event for event in events if event]
    for count, (event, wanted, line) in enumerate(zip(given, expected, found, strict=True), 1):
        if " ".join(wanted.split()) != " ".join(line.split()):
            sys.exit(f"{what}: event {count}, {event}:\n  net        {wanted}\n  controller {line}")


def variants(mission_net: MissionNet, max_states: int) -> tuple[dict[str, AnyController], dict[str, str]]:
    """The controllers that a mission has, and why a form is left out."""
    found, left_out = dict[str, AnyController](), dict[str, str]()
    forms: tuple[Form, ...] = get_args(Form)
    for form in forms:
        try:
            if form == "flat" and composite_space(mission_net).everything.count() > max_states:
                raise LimitError("the composite has counted its states")
            controller = generate(mission_net, form, max_states=max_states)
        except (SemanticsError, LimitError) as error:
            left_out[form] = type(error).__name__
            continue
        found[form] = controller
        if isinstance(controller, TableController):
            found[f"{form}, minimised"] = minimise(controller)
    return found, left_out


def run(name: str, mission_net: MissionNet, count: int, qt: int, seed: int) -> tuple[int, int]:
    """One mission; says how many events were compared, and how many in SCXML.

    Both are 0 if it has no controller, or none of some size.
    """
    controllers, left_out = variants(mission_net, MOST_STATES)
    tables = [controller for controller in controllers.values() if isinstance(controller, TableController)]
    if max((controller.states for controller in tables), default=FEWEST_STATES) < FEWEST_STATES:
        return 0, 0
    if not controllers:
        return 0, 0
    started = time.process_time()
    in_qt = 0
    known = sorted(Tables(document(next(iter(controllers.values())), mission_net)).known)
    pairs = list(net_lines(mission_net, known, count, random.Random(seed)))
    events = [event for event, _ in pairs]
    expected = [line for event, line in pairs if event]
    for form, controller in controllers.items():
        what = f"{name}, {form}"
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            said = document(controller, mission_net)
            compare(
                f"{what}, runtime", events, expected, runtime_lines(mcpn.robot.runtime, Tables(said), events)
            )
            compare(f"{what}, C", events, expected, c_lines(files(said, "c"), events, folder))
            ((_, text),) = files(said, "python").items()
            compare(f"{what}, Python", events, expected, python_lines(text, events))
            if qt and find_spec("PySide6") and isinstance(controller, TableController):
                ((_, text),) = files(document(controller, mission_net), "scxml").items()
                some = events[:qt]
                wanted = wanted_of_qt(controller, said, some, expected)
                compare(f"{what}, Qt", some, wanted, qt_lines(text, some, folder))
                in_qt += len(wanted)
    counts = {f: c.states if isinstance(c, TableController) else c.rules for f, c in controllers.items()}
    sizes = ", ".join(f"{form} {count}" for form, count in counts.items())
    sizes += "".join(f"; no {form} one ({error})" for form, error in left_out.items())
    seconds = time.process_time() - started
    print(f"{name}: {len(expected)} events each; states, or rules: {sizes}; {seconds:.1f} s", flush=True)
    return len(expected), in_qt


def drawn_missions(number: int, seed: int, **bounds: int) -> list[MissionNet]:
    """Drawn missions, small enough that both forms can be built; of nets of one size the first alone."""
    from experiments.shared.drawing import drawn

    found: dict[tuple[int, int], MissionNet] = {}
    for mission in drawn(missions(max_objectives=4, max_depth=2, **bounds), 40 * number + 1, seed):
        net = compose(mission)
        found.setdefault((len(net.net.places), len(net.net.transitions)), net)
    small = [net for net in found.values() if len(net.net.places) <= MOST_PLACES]
    return sorted(small, key=lambda net: -len(net.net.places))


def interruptions(mission_net: MissionNet) -> int:
    """How many exits the sections of a mission have for declared events."""
    return sum(len(section.interruptions) for section in mission_net.graph.sections)


def contentions(mission_net: MissionNet) -> int:
    """How many resources may be contended for."""
    return len(mission_net.usage.contentions)


def main() -> None:
    """Runs them all."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("missions", type=Path, nargs="*", default=BESIDE)
    parser.add_argument("--events", type=int, default=100_000, help="in all, for each controller")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS, help="equal shares of the events")
    parser.add_argument("--generated", type=int, default=8, help="missions of each generator")
    parser.add_argument("--qt", type=int, default=300, help="events of each mission for SCXML")
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    import logging

    logging.getLogger("mcpn.robot.runtime").setLevel(logging.ERROR)
    nets = {path.parent.name: compose(read_mission(path)) for path in arguments.missions}
    for i in range(arguments.generated):
        parameters = Parameters(sections=4 + i % 5, types=3, hardware=4, depth=1 + i % 2)
        nets[f"generated {i}"] = compose(generate_mission(parameters, arguments.seed + i))
    share = arguments.events // len(KINDS)
    total = total_qt = 0
    for name, net in nets.items() if "given" in arguments.kinds else ():
        done, in_qt = run(name, net, share // len(nets), arguments.qt, arguments.seed)
        total, total_qt = total + done, total_qt + in_qt
    for kind, bounds, measure in (
        ("contended", {"outputs": 3}, contentions),
        ("interrupted", {"events": 2}, interruptions),
        ("detected late", {"late": True}, lambda net: len(net.core.late)),
    ):
        if kind not in arguments.kinds:
            continue
        kept = 0
        for net in drawn_missions(arguments.generated, arguments.seed, **bounds):
            if kept == arguments.generated:
                break
            if measure(net):
                name = f"{kind} {kept}, {contentions(net)} contentions, {interruptions(net)} exits by events"
                done, in_qt = run(name, net, share // arguments.generated, arguments.qt, arguments.seed)
                kept += bool(done)
                total, total_qt = total + done, total_qt + in_qt
        print(f"{kept} drawn missions are {kind}")
    print(f"{total} events to each controller, {total_qt} to Qt's SCXML: no divergence")


if __name__ == "__main__":
    main()
