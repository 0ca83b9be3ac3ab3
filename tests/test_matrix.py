"""The matrix of questions by engines that docs/engines.md prints: each cell is asked here, none is believed.

``python -m tests.test_matrix`` writes it anew.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from mcpn.answers.causes.effects import Severity
from mcpn.answers.causes.find import Causes
from mcpn.answers.causes.fmeca import fmeca
from mcpn.answers.causes.minimal_cut_sets import CutSet
from mcpn.answers.causes.risk import risk
from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.answers.verdicts.mission import INFORMATIVE, REQUIRED, MissionCheck, check
from mcpn.controller.generate import generate
from mcpn.controller.hierarchy import flat_controller
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import InputError
from mcpn.logic.behaviour import Behaviour
from mcpn.logic.questions import Questions
from mcpn.mission.model import Mission, Objective, Parallel
from mcpn.mission.robot import Activity, Alternative, Hardware, Robot
from mcpn.spaces.engine_names import Engine, On
from mcpn.spaces.registry import Spaces
from mcpn.spaces.stable.written_out import written_out
from tests.logic.asked import Asked

PAGE = Path(__file__).resolve().parents[1] / "docs" / "engines.md"
BEGIN, END = "<!-- matrix -->\n", "<!-- end of matrix -->\n"
ENGINES: tuple[Engine, ...] = ("explicit", "symbolic", "local")


def mission(*, contention: bool) -> MissionNet:
    """Two branches that use hardware, the same one or one each; the spare is never used."""
    robot = Robot(
        name="r",
        hardware=(
            Hardware(name="H", failure_rate=0.5),
            Hardware(name="I", failure_rate=1.0),
            Hardware(name="spare", failure_rate=2.0),
        ),
        activities=(
            Activity(name="use", alternatives=(Alternative(name="use", consumes=("H",)),)),
            Activity(
                name="also", alternatives=(Alternative(name="also", consumes=("H" if contention else "I",)),)
            ),
        ),
    )
    branches = tuple(
        Objective(name=name, activities=(activity,), duration=1.0)
        for name, activity in (("x", "use"), ("y", "also"))
    )
    return compose(Mission(name="m", robots=(robot,), blocks=(Parallel(name="both", blocks=branches),)))


def decided(found: MissionCheck) -> bool:
    return all(verdict.holds is not None for verdict in found.verdicts.values())


def answers(engine: Engine, on: On, formula: str, *fair: str) -> bool:
    """Whether a formula is answered, with a run that shows it."""
    found = mission(contention=False)
    questions = Questions(spaces_of(found), on=on, fair=fair, engine=engine)
    answer = questions.answer(formula)
    return bool(answer.witness.steps) or answer.holds


def behaves(engine: Engine) -> bool:
    net = replace(mission(contention=False).net, priorities=False)
    return Behaviour(Spaces(net).space(engine)).home_markings >= 0


CHECKED: dict[Engine, MissionCheck] = {}


def checked(engine: Engine) -> MissionCheck:
    if engine not in CHECKED:
        CHECKED[engine] = check(mission(contention=False), engine=engine)
    return CHECKED[engine]


ASKED: dict[Engine, Asked] = {}


def causes(engine: Engine) -> Causes:
    if engine not in ASKED:
        ASKED[engine] = Asked(mission(contention=False), engine)
    return ASKED[engine].all


def moments(engine: Engine) -> bool:
    """Both branches must succeed: each resource in use is a cut set, until its branch has ended."""
    single: list[CutSet] = [("H",), ("I",)]
    mission_moments = {"start": single, "whenever": [("H", "I")], "sometime": single}
    found = causes(engine)
    every = {moment: [("H",)] for moment in ("start", "entry", "whenever", "sometime")}
    return found.mission.moments == mission_moments and found.objectives["x"].moments == every


def critical(engine: Engine) -> bool:
    """H fails while x runs: with y, whose resource works, or after y, whose resource may do anything."""
    found = [c for c in causes(engine).mission.critical_with_repairs if str(c.event) == "H_EV_OOS"]
    return {c.objectives: c.edges for c in found} == {("x", "y"): 2, ("x",): 4}


def survives(engine: Engine) -> bool:
    start, entry = causes(engine).survival
    return (start.always, start.at_most, entry.section) == (0, 1, "both") and start.cut_sets == [
        ("H",),
        ("I",),
    ]


def runs_to_failure(engine: Engine) -> bool:
    run = causes(engine).objectives["x"].runs[("H",)]
    assert run is not None
    events = [str(event) for event in run.events]
    return sorted(events) == ["H_EV_OOS", "MISSION_EV_START", "OBJ_x_EV_FAIL"] and events[-1].endswith("FAIL")


def most_failures(engine: Engine) -> bool:
    """The run through a moment to success with the most failures: of the spare, and of what has been used."""
    run = causes(engine).survival[0].run
    assert run is not None
    events = [str(event) for event in run.events]
    return sum(event.endswith("OOS") for event in events) == 2 and events[-1].endswith("EV_OK")


def tabled(engine: Engine) -> bool:
    rows = fmeca(causes(engine).prospects)
    costs = {"H": Severity.MISSION_LOST, "I": Severity.MISSION_LOST, "spare": Severity.NO_EFFECT}
    return {(row.hardware, row.objective): row.severity for row in rows} == {
        (hardware, objective): cost for hardware, cost in costs.items() for objective in "xy"
    }


def numbers(engine: Engine) -> bool:
    """Each branch outlives its resource with probability 1 / (1 + rate * duration)."""
    causes(engine)
    return math.isclose(risk(ASKED[engine].prospects).success, 1 / (1.5 * 2.0))


def controls(engine: Engine) -> bool:
    """A machine with an entry, and a state while x runs alone."""
    found = mission(contention=False)
    space = spaces_of(found).space(engine, "alternatives")
    made = generate(found) if engine == "local" else flat_controller(found, written_out(space, engine))
    return any(state.objectives == ("x",) for machine in made.types for state in machine.states)


QUESTIONS: dict[str, Callable[[Engine], bool]] = {
    "how many markings, and firings between them": lambda e: checked(e).marking_sizes is not None,
    "how many stable states, and events between them": lambda e: checked(e).stable_sizes is not None,
    f"required verdicts ({', '.join(REQUIRED)}), with runs": lambda e: (
        decided(checked(e)) and bool(checked(e).verdicts["success_reachable"].runs)
    ),
    f"informative verdicts ({', '.join(INFORMATIVE)})": lambda e: (
        [p.message for p in checked(e).unselectable] == ["resource spare is never used"]
    ),
    "functioning modes": lambda e: checked(e).modes == {"x": [{"use": "use"}], "y": [{"also": "also"}]},
    "verdicts of a mission that is not confluent": lambda e: (
        {name for name, v in check(mission(contention=True), engine=e).verdicts.items() if v.holds is None}
        == set()
    ),
    "CTL on stable states, with the run that shows why": lambda e: answers(
        e, "alternatives", "A[!oos(H) U success]"
    ),
    "CTL under fairness": lambda e: answers(e, "alternatives", "AF success", "progress"),
    "LTL, with the run and what of it repeats": lambda e: answers(
        e, "alternatives", "success R !(F G oos(H))"
    ),
    "CTL on all markings": lambda e: answers(e, "markings", "A[!oos(H) U success]"),
    "liveness, home markings, deadlock of a net from elsewhere": behaves,
    "cut sets at every moment": moments,
    "critical events, with and without repairs": critical,
    "survival: how many losses, and whichever they are": survives,
    "runs to failure": runs_to_failure,
    "scenarios: the run to success with the most failures": most_failures,
    "FMECA table": tabled,
    "numbers of risk: success, degraded modes, importance": numbers,
    "controller (of the local engine: by sections)": controls,
}

REASONS = {
    "how many markings, and firings between them": "sections hand on stable states only",
    "verdicts of a mission that is not confluent": "no one next state to hand on; it says so, with two runs",
    "CTL on all markings": "sections hand on stable states only",
    "liveness, home markings, deadlock of a net from elsewhere": "a net of no mission has no sections",
}
"""Why composition cannot answer; the other engines answer everything."""


def cell(question: str, engine: Engine) -> str:
    """What the matrix says of a question and an engine."""
    try:
        answered = QUESTIONS[question](engine)
    except InputError:
        answered = False
    assert answered == (engine != "local" or question not in REASONS), (question, engine)
    return "yes" if answered else f"no: {REASONS[question]}"


def matrix() -> str:
    """The matrix, as the page prints it."""
    rows = [["question", *(f"`{engine}`" for engine in ENGINES)], ["---"] * (1 + len(ENGINES))]
    rows += [[question, *(cell(question, engine) for engine in ENGINES)] for question in QUESTIONS]
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


def test_the_matrix_of_questions_by_engines() -> None:
    _, _, rest = PAGE.read_text().partition(BEGIN)
    printed, end, _ = rest.partition(END)
    assert end, "the page has the matrix between its two markers"
    assert printed == matrix(), "python -m tests.test_matrix writes it anew"


if __name__ == "__main__":
    before, begin, rest = PAGE.read_text().partition(BEGIN)
    PAGE.write_text(before + begin + matrix() + END + rest.partition(END)[2])
