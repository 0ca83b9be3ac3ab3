"""The node for behaviour trees: does what the runtime does, in a stand-in and in BehaviorTree.CPP itself.

Tests compile it against ``tests/controller/btcpp``, which has the signatures that are used; where ``--btcpp``
names the library's sources, against the library, too.
"""

from __future__ import annotations

import random
import subprocess
from pathlib import Path

import pytest

from mcpn.controller.document import document
from mcpn.controller.generate import Form, generate
from mcpn.controller.monitors.writing import files as monitor_files
from mcpn.controller.monitors.writing import monitors_of
from mcpn.drawing.compose import MissionNet
from mcpn.robot.runtime.controller_tables import Tables
from mcpn.robot.targets import files
from mcpn.study import open_study
from tests.controller.small import WATCH, composed
from tests.controller.traces import canonical
from tests.controller.treed import FORMS, Modelled
from tests.natives import LIBRARY, cpp_compiler, library_of

HERE = Path(__file__).parent
STRICT = ["-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror"]


@pytest.fixture(scope="module", params=["stand-in", LIBRARY])
def against(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Options of the compiler for what the node is compiled against."""
    if request.param == LIBRARY:
        return library_of(request.config, tmp_path_factory)
    return ["-I", str(HERE / "btcpp")]


def compiled(texts: dict[str, str], folder: Path, against: list[str], *, main: str = "") -> Path:
    """The example among the files of the target, or a program in its place."""
    compiler = cpp_compiler()
    folder.mkdir(exist_ok=True, parents=True)
    for name, text in texts.items():
        (folder / name).write_text(text)
    (example,) = [name for name in texts if name.endswith("_tree.cpp")]
    if main:
        (folder / example).write_text(main)
    strict = [flag if flag != "-I" else "-isystem" for flag in against]  # warnings of ours alone
    source = example.replace("_tree.cpp", ".c")
    made = [str(folder / "controller.o"), str(folder / "program")]
    _run(["cc", "-std=c99", "-c", str(folder / source), "-o", made[0]])
    _run([*compiler, *STRICT, str(folder / example), made[0], "-o", made[1], *strict])
    return folder / "program"


def _run(command: list[str]) -> None:
    run = subprocess.run(command, capture_output=True, text=True)
    assert (run.returncode, run.stderr) == (0, ""), run.stderr


def lockstep(mission_net: MissionNet, form: Form, folder: Path, against: list[str], steps: int) -> None:
    controller = generate(mission_net, form)
    program = compiled(files(document(controller, mission_net), "btcpp"), folder, against)
    model = Modelled(mission_net.mission, Tables(document(controller, mission_net)))
    events: list[str] = []
    expected: list[str] = []
    for event in model.events(random.Random(7), steps):
        events.append(event)
        expected.append(model.line(event))
    run = subprocess.run([program, "all"], input="\n".join(events) + "\n", capture_output=True, text=True)
    assert (run.returncode, run.stderr) == (0, "")
    found = [canonical(line if "|" in line else f"{line} |") for line in run.stdout.splitlines()]
    wrong = next((i for i, pair in enumerate(zip(found, expected, strict=True)) if pair[0] != pair[1]), None)
    assert wrong is None, (events[max(0, wrong - 5) : wrong + 1], found[wrong], expected[wrong])


@pytest.mark.parametrize(
    "form", [pytest.param(form, marks=[pytest.mark.slow] * (form != "hierarchical")) for form in FORMS]
)
def test_a_tree_in_lockstep_with_the_runtime(
    form: Form, ulysse_net: MissionNet, against: list[str], tmp_path: Path
) -> None:
    lockstep(ulysse_net, form, tmp_path, against, 20_000 if form == "hierarchical" else 5_000)


@pytest.fixture(scope="module")
def twice(tmp_path_factory: pytest.TempPathFactory) -> MissionNet:
    return composed(WATCH, tmp_path_factory.mktemp("twice"))


@pytest.mark.parametrize("form", FORMS)
def test_faults_crashes_facts_timers_and_aborts(
    form: Form, twice: MissionNet, against: list[str], tmp_path: Path
) -> None:
    lockstep(twice, form, tmp_path, against, 5_000)


def compiled_to_play(
    net: MissionNet, folder: Path, against: list[str], bodies: dict[str, str], **parts: str
) -> Path:
    """A program that plays the node as one of some bodies says; it is given its name and the tree.

    Each action is a line, refused events and outcomes too.
    """
    played = "".join(f'if (asked == "{name}") {{ {body} }}\n' for name, body in bodies.items())
    main = PROGRAM.replace("BODIES", played)
    for part in ("MORE", "WATCHED"):
        main = main.replace(part, parts.get(part, ""))
    return compiled(files(document(generate(net, "hierarchical"), net), "btcpp"), folder, against, main=main)


def played(program: Path, body: str, tree: str = "") -> list[str]:
    """What a body prints."""
    tree = tree or (
        "<twice_mission events='{events}' mode='{mode}' outcome='{outcome}'"
        " fact_door='{door}' service_camera='{camera}' service_gps='{gps}'/>"
    )
    run = subprocess.run([program, body, tree.replace("'", '"')], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    return run.stdout.splitlines()


PROGRAM = """
#include <iostream>
#include "twice_node.hpp"
MORE
static void line(const std::string &verb, const char *what)
{
    std::cout << verb << what << '\\n';
}
int main(int, char **arguments)
{
    const std::string asked = arguments[1], played = arguments[2];
    BT::BehaviorTreeFactory factory;
    auto robot = std::make_shared<twice_bt::Robot>();
    auto time = std::chrono::steady_clock::time_point();
    robot->now = [&] { return time; };
    robot->act = [](const twice_action &action) {
        if (action.verb == TWICE_START) { line("start ", twice_activity_name(action.subject)); }
        if (action.verb == TWICE_STOP) { line("stop ", twice_activity_name(action.subject)); }
        if (action.verb == TWICE_RELEASE) { line("release ", twice_hardware_name(action.subject)); }
    };
    robot->refused = [](const std::string &event) { std::cout << "refused " << event << '\\n'; };
    robot->taken = [](const std::string &event) { std::cout << "taken " << event << '\\n'; };
    twice_bt::register_node(factory, robot);
    WATCHED
    BT::Tree tree = factory.createTreeFromText(
        "<root BTCPP_format=\\"4\\"><BehaviorTree ID=\\"Main\\">" + played + "</BehaviorTree></root>");
    const auto board = tree.rootBlackboard();
    const auto tick = [&] { std::cout << BT::toStr(tree.tickOnce()) << '\\n'; };
    const auto tell = [&](const char *events) { board->set("events", std::string(events)); tick(); };
    const auto text = [&](const char *key) { std::string found; (void)board->get(key, found); return found; };
    (void)tell; (void)text;
    BODIES
}
"""


BODIES = {
    "ports": """
    board->set("door", std::string("open")); board->set("camera", false); tick();
    board->set("camera", true); tick();
    board->set("door", std::string("closed")); tick();
    board->set("door", std::string("ajar")); tick(); tick();
    board->set("gps", false); tick(); board->set("gps", true); tick();
    tell("OBJ_watch_EV_SUCC ; nothing;; leak");
    std::cout << text("outcome") << '[' << text("events") << ']' << text("mode") << '\\n';
    """,
    "time": """
    const auto pass = [&](int microseconds) { time += std::chrono::microseconds(microseconds); tick(); };
    tick();
    pass(4999999); pass(1);
    for (int i = 0; i < 9; i++) { pass(555555); }
    pass(5);
    """,
    "at once": """
    auto act = robot->act;
    robot->act = [&](const twice_action &action) {
        act(action);
        if (action.verb == TWICE_START) { robot->tell("leak"); }
    };
    for (int i = 0; i < 2; i++) { std::cout << BT::toStr(tree.tickExactlyOnce()) << '\\n'; }
    """,
    "halt": """
    tick(); robot->tell("gps_EV_OOS"); std::cout << "halt\\n"; tree.haltTree();
    std::cout << text("outcome") << '[' << text("mode") << "]\\n"; tree.haltTree(); tick();
    """,
    "no entry": """
    try { tick(); } catch (const BT::RuntimeError &error) { std::cout << error.what() << '\\n'; }
    """,
}


@pytest.fixture(scope="module")
def player(twice: MissionNet, against: list[str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    return compiled_to_play(twice, tmp_path_factory.mktemp("player"), against, BODIES)


def test_ports_tell_events(player: Path) -> None:
    camera = ["taken camera_EV_OOS", "taken MISSION_EV_START"]
    found = played(player, "ports")
    assert found[:2] == camera
    assert "taken camera_EV_RD" in found
    assert [line for line in found if "fact" in line or "service" in line] == [
        "refused fact_door=ajar",
        "refused service_gps=true",
    ]
    assert "taken closes" in found
    assert "taken gps_EV_OOS" in found
    assert "refused nothing" in found
    assert found[-2:] == ["FAILURE", "abort[]"]


def test_time_passes_between_ticks(player: Path) -> None:
    """The timers are the controller's: 5 s for each of two tries, and a part of a millisecond is not lost."""
    found = played(player, "time")
    late = [i for i, line in enumerate(found) if line.startswith("taken OBJ_watch")]
    assert [found[i] for i in late] == ["taken OBJ_watch_try1_EV_TIMEOUT", "taken OBJ_watch_try2_EV_TIMEOUT"]
    ticks = [sum(line in ("RUNNING", "FAILURE") for line in found[:i]) for i in late]
    assert ticks == [2, 12]


def test_what_a_driver_tells_at_once_is_for_the_next_tick(player: Path) -> None:
    found = played(player, "at once")
    assert found.index("RUNNING") < found.index("taken leak")
    assert found[-1] == "FAILURE"


def test_halt_gives_the_mission_up(player: Path) -> None:
    """What was started last is stopped first; hardware is released; the next start knows what is lost."""
    found = played(player, "halt")
    started = [line.removeprefix("start ") for line in found[: found.index("RUNNING")] if "start" in line]
    assert started
    after = found[found.index("halt") + 1 :]
    assert after[: len(started)] == [f"stop {each}" for each in reversed(started)]
    outcome = after.index("halted[]")
    assert sorted(after[len(started) : outcome]) == ["release camera", "release gps"]
    assert after[outcome + 1 : outcome + 3] == ["taken gps_EV_OOS", "taken MISSION_EV_START"]


def test_a_port_of_no_entry_is_an_error(player: Path) -> None:
    found = played(player, "no entry", "<twice_mission events='leak'/>")
    assert found[-1].endswith("port events must name an entry of the blackboard: {events}")


def test_monitors_are_conditions(twice: MissionNet, against: list[str], tmp_path: Path) -> None:
    """The mission is halted as soon as a requirement is violated; a run that begins anew is watched anew."""
    (tmp_path / "required.xml").write_text(
        WATCH.replace(
            "<on event", '<requirement name="stays_open" formula="G !happens(closes_EV)"/><on event'
        )
    )
    (tmp_path / "made").mkdir()
    of = monitors_of(open_study(tmp_path / "required.xml").mission_spaces("what it requires"))
    for name, text in monitor_files(of, btcpp=True).items():
        (tmp_path / "made" / name).write_text(text)
    _run(
        ["cc", "-std=c99", "-c", str(tmp_path / "made/twice_monitors.c"), "-o", str(tmp_path / "monitors.o")]
    )
    tree = (
        "<ReactiveSequence><twice_requirement requirement='stays_open'/><twice_mission events='{events}'/>"
        "</ReactiveSequence>"
    )
    body = """
    tick(); tell("closes"); std::cout << "halts\\n"; tell(""); tell("");
    monitors->begin(); tell(""); std::cout << (monitors->value(0) == TWICE_OPEN) << '\\n';
    """
    watching = "auto monitors = std::make_shared<twice_bt::Monitors>(); monitors->watch(*robot);"
    watching += " twice_bt::register_monitors(factory, monitors);"
    options = [*against, "-I", str(tmp_path / "made"), str(tmp_path / "monitors.o")]
    more = {"MORE": '#include "twice_monitors_node.hpp"', "WATCHED": watching}
    program = compiled_to_play(twice, tmp_path / "node", options, {"all": body}, **more)
    found = played(program, "all", tree)
    assert sorted(found[: found.index("RUNNING")][-2:]) == ["start go", "start look"]
    violated = found.index("taken closes")
    assert found[violated + 1 : found.index("halts")] == ["stop go", "release gps", "RUNNING"]
    again = found.index("FAILURE") + 1
    assert found[found.index("halts") + 1 : again] == ["stop look", "release camera", "FAILURE"]
    assert found[again : again + 2] == ["FAILURE", "taken MISSION_EV_START"]
    assert found[found.index("RUNNING", again) + 1] == "1"


def test_names_that_are_keywords(tmp_path: Path, against: list[str]) -> None:
    """Of C++: that of the mission, and those of its elements."""
    text = """<mission name="class" xmlns="urn:mcpn:mission:1"><robot name="r"><hardware name="_if"/>
      <fact name="template" values="new delete"/>
      <event name="operator"><sets fact="template" to="new"/></event>
      <activity name="namespace" consumes="_if" requires="template=new"/></robot>
      <objective name="while" activities="namespace"/></mission>"""
    lockstep(composed(text, tmp_path), "hierarchical", tmp_path, against, 500)
