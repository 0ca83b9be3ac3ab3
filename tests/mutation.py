"""Mutated inputs and option values for the command line, and one run of it in this process.

Each case is drawn from a seed of its own, so that a case that fails can be repeated alone.
"""

from __future__ import annotations

import contextlib
import io
import json
import random
import shutil
import signal
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

from mcpn.robot.runtime import Controller, ControllerFileError, SnapshotError
from mcpn.robot.runtime.__main__ import main as watch_log
from tests.commands import Outcome, mcpn

CODES = {0, 1, 2}
SECONDS = 20
"""Of CPU time, the longest that a case may take: the inputs are small and every limit on states is low."""


@contextlib.contextmanager
def at_most(seconds: float) -> Iterator[None]:
    """Raises where the body takes more seconds of CPU time."""

    def late(_signal: int, _frame: FrameType | None) -> None:
        raise TimeoutError(f"longer than {seconds:g} s of CPU time")

    before = signal.signal(signal.SIGPROF, late)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def complaint(arguments: Sequence[object]) -> str | None:
    """What is wrong with how the command line answers, or ``None``.

    Whatever it is given, it ends with a code of its contract, a sentence where it refuses, and one JSON value
    where ``--json`` asks for it and the answer is 0 or 1. ``runtime`` in the place of a command stands for
    what runs on a robot.
    """
    found = answer(arguments)
    told = f"{found.returncode}\n{found.stdout[-500:]}\n{found.stderr[-2000:]}"
    if found.returncode not in CODES:
        return f"exit code {told}"
    if "Traceback" in found.stderr + found.stdout or "internal error" in found.stderr:
        return f"a traceback: {told}"
    # Findings in a format for machines have what is wrong with the input among them.
    said = found.stderr + found.stdout * ("--format" in map(str, arguments))
    if found.returncode == 2 and not said.strip():
        return f"no sentence: {told}"
    paths = [argument for argument in arguments if isinstance(argument, Path)]
    # Or what these import; a ledger of a tree names its file alone.
    files = tuple(f"warning: {said}" for path in paths for said in (path.parent, f"{path.name}:"))
    warned = [line for line in (found.stdout + found.stderr).splitlines() if line.startswith("warning: ")]
    if files and not all(line.startswith(files) for line in warned):
        return f"a warning that names no file: {told}"
    if "--json" in map(str, arguments) and "--" not in arguments and found.returncode != 2:
        try:
            json.loads(found.stdout, parse_constant=_refused)
        except ValueError as error:
            return f"no JSON value ({error}): {told}"
    return None


def answer(arguments: Sequence[object]) -> Outcome:
    """What a command, or what runs on a robot, answers."""
    return _on_robot(*arguments[1:]) if arguments[0] == "runtime" else mcpn(*arguments)


def _on_robot(*arguments: object) -> Outcome:
    """``python -m mcpn.robot.runtime``; or, with ``restore``, a controller that goes on from a snapshot."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        if arguments[0] != "restore":
            return Outcome(
                watch_log([str(argument) for argument in arguments]), out.getvalue(), err.getvalue()
            )
        controller, snapshot = (Path(str(argument)) for argument in arguments[1:])
        try:
            Controller.load(controller).restore(snapshot.read_text(errors="surrogateescape"))
        except (ControllerFileError, SnapshotError) as error:
            return Outcome(2, "", str(error))
    return Outcome(0, "", "")


def _refused(name: str) -> float:
    raise ValueError(f"{name} is no JSON")


_PRINTED = """
0 1 -1 2 99999999999999999999 1e308 -0.0 NaN inf true false yes a o h x.y ../m.xml http://x/ / . .. ' " < > &
]]> [/] [bold] [link=x] %s {0} \\ é <!-- --> <a/> <!DOCTYPE x> &lt; &#0; &#x1F600; name consumes produces
activities success failure mandatory rate parallel objective hardware software alternative p0 t0 # pr lb tr
pl -> ?-1 *2 ( ) ! & | AG EF A[ U
"""
WORDS = [*_PRINTED.split(), " ", "\t", "\r", "\n", "\x85", "\u202e", "\u0661", "\U0001f680"]
_OPTIONS = """
--max-states --engine --order --save-order --seed --import-root --objective --severity --fmeca --openpsa
--method -o --target --properties --examination --fair --scn --jobs --no-proof --on
--structure
"""


def mutated(data: bytes, draw: random.Random) -> bytes:
    """A text with a few changes: parts cut out, doubled, swapped, replaced by words or by bytes.

    Half of the changes keep XML well-formed: values of attributes, whole lines.
    """
    for _ in range(draw.choice((0, 1, 1, 1, 2, 3, 8))):
        start = draw.randrange(len(data) + 1)
        stop = min(len(data), start + draw.choice((0, 1, 2, 5, 20, 200)))
        match draw.randrange(12):
            case 0:
                data = data[:start] + data[stop:]
            case 1:
                data = data[:start] + data[start:stop] * draw.choice((2, 3, 300)) + data[stop:]
            case 2:
                data = data[:start] + draw.choice(WORDS).encode() + data[stop:]
            case 3:
                data = data[:start] + bytes([draw.randrange(256)]) + data[stop:]
            case 4:
                data = data[:start]
            case 5:
                data = data[:start] + draw.choice(WORDS).encode() * draw.choice((50, 5000)) + data[stop:]
            case 6 | 7:
                data = _lines_moved(data, draw)
            case _:
                data = _value_replaced(data, draw)
    return data


def _lines_moved(data: bytes, draw: random.Random) -> bytes:
    lines = data.split(b"\n")
    line = lines.pop(draw.randrange(len(lines)))
    for _ in range(draw.choice((0, 0, 1, 2))):
        lines.insert(draw.randrange(len(lines) + 1), line)
    return b"\n".join(lines)


def _value_replaced(data: bytes, draw: random.Random) -> bytes:
    """A quoted value becomes another one of the text, a part of it, or a word, at times a very long one."""
    parts = data.split(b'"')
    if len(parts) < 5:
        return data
    to, source = (draw.randrange(len(parts) // 2) * 2 + 1 for _ in range(2))
    word = draw.choice([w for w in WORDS if not set(w) & set('<&"')]).encode()
    parts[to] = draw.choice((parts[source], parts[source], b"", word, word * 5000, parts[to] + b" " + word))
    return b'"'.join(parts)


@dataclass(frozen=True)
class Seeds:
    """Files to mutate, by what they are."""

    missions: tuple[bytes, ...]
    nets: dict[str, tuple[bytes, ...]]
    properties: tuple[bytes, ...]
    formulas: tuple[str, ...]
    made: dict[str, bytes]
    """What mcpn made of the first mission and a robot reads, by its name."""


DRIVERS = b"""never = ["GPS_EV_OOS",
  "IMU_EV_OOS", "arm_EV_OOS"]
[activities]
dive = {process = ["dive", "{depth}"], grace = 2.5, ends = {0 = "success", other = "failure"}}
[activities.locate.alternatives]
by_gps.nothing = true
by_imu.python = "own:locate"
[mqtt]
host = "localhost"
port = 1883
[sources.bus]
mqtt = {says = "robot/#"}
lines = {"lost (?:GPS)" = "GPS_EV_OOS"}
"""
TREES = (
    b"""<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main">
    <Sequence name="top">
      <RetryUntilSuccessful num_attempts="3"><SubTree ID="Dock" where="{goal}"/></RetryUntilSuccessful>
      <ReactiveFallback><IsCharged/><Timeout msec="1000"><Charge speed="1.5"/></Timeout></ReactiveFallback>
      <Parallel success_count="1" failure_count="2"><Look/><Delay delay_msec="5"><Move/></Delay></Parallel>
      <Script code="n := 1"/><ForceSuccess><Wave _skipIf="n == 1" _onSuccess="n = 2"/></ForceSuccess>
    </Sequence>
  </BehaviorTree>
  <BehaviorTree ID="Dock"><Fallback><IfThenElse><Seen/><Move/><Look/></IfThenElse><Inverter><Look/></Inverter>
  </Fallback></BehaviorTree>
  <TreeNodesModel><Action ID="Move"><input_port name="to"/></Action><Condition ID="Seen"/></TreeNodesModel>
</root>
""",
    b"""<root main_tree_to_execute="MainTree"><BehaviorTree ID="MainTree">
  <RecoveryNode number_of_retries="6" name="NavigateRecovery">
    <PipelineSequence name="NavigateWithReplanning">
      <RateController hz="1.0"><ComputePathToPose goal="{goal}" path="{path}"/></RateController>
      <FollowPath path="{path}" controller_id="FollowPath"/>
    </PipelineSequence>
    <ReactiveFallback><GoalUpdated/><RoundRobin><Spin spin_dist="1.57"/><Wait wait_duration="5"/></RoundRobin>
    </ReactiveFallback>
  </RecoveryNode></BehaviorTree></root>
""",
)
ORDER = b"""# the lamp of its net
on
off
broken
"""
RUN = b"""failure by GPS:
  1. mission m starts: first.down begins  [MISSION_EV_START]
  2. GPS fails, then
     locate runs by_imu  [GPS_EV_OOS]
  3. OBJ_first.down_EV_OK
"""
LINES = b"""# what a robot wrote
MISSION_EV_START
GPS_EV_OOS
OBJ_first.down_EV_OK
"""
LISTED = b'["MISSION_EV_START", "GPS_EV_OOS", "OBJ_first.down_EV_OK"]'
JOURNAL = b"""{"resumed": 0}
{"number": 1, "event": "MISSION_EV_START", "refused": false, "actions": [], "section": "first.down"}
{"number": 2, "event": "GPS_EV_OOS", "refused": false, "actions": [], "section": "first.down"}
"""
FAULTS = b"""0.5 GPS_EV_OOS
1e-1 IMU_EV_OOS  # hours
2 GPS_EV_RD
"""
LIMITS = ("--max-states", "200")


def folder_name(draw: random.Random) -> str:
    """A folder for a case: its name may look like markup, an option, or be of no characters that print."""
    return draw.choice(("case", "[bold]", "[/red]", "a b", "-x", "[link=x]", "\U0001f680", ":smile:", "é"))


def a_case(seeds: Seeds, folder: Path, draw: random.Random) -> list[object]:
    """Writes a mutated file and says the arguments that give it to a command."""
    at = folder / folder_name(draw)
    shutil.rmtree(at, ignore_errors=True)
    at.mkdir(parents=True)
    kind = draw.choice((*WRITTEN, *READ))
    arguments = kind(seeds, at, draw)
    if kind is not _runtime_case and draw.random() < 0.5:
        arguments.append("--json")
    return arguments


def _about_a_mission(path: Path, out: Path, draw: random.Random) -> list[object]:
    engine = ("--engine", draw.choice(("auto", "explicit", "symbolic", "local")))
    possible: list[list[object]] = [
        ["check", path, *engine, *LIMITS],
        ["check", path, *engine, *LIMITS],
        ["states", path, *engine, *LIMITS],
        ["alternatives", path, *engine, *LIMITS],
        ["alternatives", path, "--method", draw.choice(("direct", "reduction")), *LIMITS],
        ["alternatives", path, "-o", out / draw.choice(("a.json", "a.aut", "a.dot", "a.txt")), *LIMITS],
        ["causes", path, "--engine", draw.choice(("explicit", "symbolic", "local")), *LIMITS],
        ["causes", path, "--fmeca", out / "f.csv", "--openpsa", out / "o.xml", "--rates", *LIMITS],
        ["controller", path, "-o", out / "made", draw.choice(("--flat", "--hierarchical")), *LIMITS],
        ["convert", path, out / draw.choice(("n.net", "n.pnml", "n.json", "n.dot", "n.txt", "no/n.net"))],
        ["ask", path, "EF failure", *LIMITS],
        ["simulate", path, "--random", "5", "--seed", "1"],
    ]
    if draw.random() < 0.05:  # pictures and pages
        possible = [["report", path, "-o", out / "r.html"], ["convert", path, out / "m.svg"]]
    if draw.random() < 0.01:  # these take seconds
        possible = [["compare", path, *LIMITS, "--seconds", "2"], ["check", path, "--structure"]]
    return draw.choice(possible)


def _mission_case(seeds: Seeds, at: Path, draw: random.Random) -> list[object]:
    path = at / "m.xml"
    path.write_bytes(mutated(draw.choice(seeds.missions), draw))
    return _about_a_mission(path, at, draw)


def _net_case(seeds: Seeds, at: Path, draw: random.Random) -> list[object]:
    suffix = draw.choice(list(seeds.nets))
    path = at / f"n{suffix}"
    path.write_bytes(mutated(draw.choice(seeds.nets[suffix]), draw))
    possible: list[list[object]] = [
        ["check", path, *LIMITS],
        ["states", path, "--engine", draw.choice(("explicit", "symbolic", "pyeda")), *LIMITS],
        ["ask", path, "--examination", draw.choice(("OneSafe", "Liveness", "ReachabilityDeadlock"))],
        ["convert", path, at / draw.choice(("o.net", "o.pnml", "o.json", "o.dot"))],
    ]
    if suffix == ".net" or draw.random() < 0.1:
        possible.append(["check", path, "--structure"])
    return draw.choice(possible)


def _properties_case(seeds: Seeds, at: Path, draw: random.Random) -> list[object]:
    net, path = at / "n.net", at / "p.xml"
    net.write_bytes(seeds.nets[".net"][0])
    path.write_bytes(mutated(draw.choice(seeds.properties), draw))
    return ["ask", net, "--properties", path, "--engine", draw.choice(("explicit", "symbolic")), *LIMITS]


def _drivers_case(seeds: Seeds, at: Path, draw: random.Random) -> list[object]:
    mission, path = at / "m.xml", at / "drivers.toml"
    mission.write_bytes(seeds.missions[0])
    path.write_bytes(mutated(DRIVERS, draw))
    return ["run", mission, "--drivers", path, "--check"]


def _tree_case(_seeds: Seeds, at: Path, draw: random.Random) -> list[object]:
    path = at / "tree.xml"
    path.write_bytes(mutated(draw.choice(TREES), draw))
    possible: list[list[object]] = [
        ["check", path, *LIMITS],
        ["check", path, "--format", draw.choice(("sarif", "github")), *LIMITS],
        ["ask", path, "EF failure", *LIMITS],
        ["init", f"made{draw.randrange(10**9)}", "--from", path],
    ]
    return draw.choice(possible)


def _order_case(seeds: Seeds, at: Path, draw: random.Random) -> list[object]:
    net, path = at / "n.net", at / "order.txt"
    net.write_bytes(seeds.nets[".net"][0])
    path.write_bytes(mutated(ORDER, draw))
    return ["states", net, "--engine", "symbolic", "--order", path]


def _events_case(seeds: Seeds, at: Path, draw: random.Random) -> list[object]:
    mission, path = at / "m.xml", at / "events.txt"
    mission.write_bytes(seeds.missions[0])
    path.write_bytes(mutated(draw.choice((RUN, LISTED, JOURNAL)), draw))
    return ["simulate", mission, "--events", path]


def _log_case(seeds: Seeds, at: Path, draw: random.Random) -> list[object]:
    mission, path = at / "m.xml", at / "robot.log"
    mission.write_bytes(seeds.missions[0])
    path.write_bytes(mutated(draw.choice((LINES, JOURNAL)), draw))
    return ["monitor", mission, "--log", path, *draw.choice(((), ("--within-mission",)))]


def _faults_case(seeds: Seeds, at: Path, draw: random.Random) -> list[object]:
    mission, path = at / "m.xml", at / "faults.txt"
    mission.write_bytes(seeds.missions[0])
    path.write_bytes(mutated(FAULTS, draw))
    return ["bench", mission, "--runs", "2", "--seed", "1", "--faults", path]


def _runtime_case(seeds: Seeds, at: Path, draw: random.Random) -> list[object]:
    """Files that a robot reads, one of them mutated."""
    texts = dict(seeds.made) | {"robot.log": draw.choice((LINES, JOURNAL))}
    changed = draw.choice(list(texts))
    texts[changed] = mutated(texts[changed], draw)
    for name, text in texts.items():
        (at / name).write_bytes(text)
    if changed in ("controller.json", "snapshot"):
        return ["runtime", "restore", at / "controller.json", at / "snapshot"]
    return ["runtime", at / "monitors.json", at / "robot.log"]


def _formula_case(seeds: Seeds, at: Path, draw: random.Random) -> list[object]:
    path = at / "m.xml"
    path.write_bytes(seeds.missions[0])
    texts = [
        mutated(draw.choice(seeds.formulas).encode(), draw).decode(errors="surrogateescape")
        for _ in range(draw.choice((1, 1, 2)))
    ]
    on = ("--on", draw.choice(("markings", "alternatives")))
    fair = ("--fair", draw.choice(("progress", "failure", texts[0]))) if draw.random() < 0.3 else ()
    return ["ask", path, *on, *fair, *LIMITS, *(t for t in texts if not t.startswith("-"))]


def _options_case(seeds: Seeds, at: Path, draw: random.Random) -> list[object]:
    path = at / "m.xml"
    path.write_bytes(seeds.missions[0])
    arguments = _about_a_mission(path, at, draw)
    odd = draw.choice(WORDS) * draw.choice((1, 1, 1, 5000))
    option = draw.choice(_OPTIONS.split())
    match draw.randrange(3):
        case 0:
            return [*arguments, option, odd]
        case 1:
            arguments[draw.randrange(1, len(arguments))] = odd
            return arguments
        case _:
            return [
                *arguments,
                *(("--severity", f"mission lost={odd}") if arguments[0] == "causes" else (odd,)),
            ]


Kind = Callable[[Seeds, Path, random.Random], list[object]]
WRITTEN: tuple[Kind, ...] = (
    _mission_case,
    _net_case,
    _properties_case,
    _formula_case,
    _options_case,
    _drivers_case,
    _tree_case,
)
"""Of what people write, the options of a command among it."""
READ: tuple[Kind, ...] = (_order_case, _events_case, _log_case, _faults_case, _runtime_case)
"""Of what beside a mission is read again: runs, logs, orders, controllers, snapshots."""
