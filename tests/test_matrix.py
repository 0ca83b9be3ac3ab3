"""The matrix of questions by engines that the README prints: each cell is asked here, none is believed.

``python -m tests.test_matrix`` writes it anew.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from mcpn.check.logic.language import parse
from mcpn.check.logic.questions import Questions
from mcpn.check.nets.behaviour import behaviour
from mcpn.check.spaces import Engine, On, space_of
from mcpn.check.verdicts.mission import INFORMATIVE, REQUIRED, MissionCheck, check
from mcpn.errors import InputError
from mcpn.mission.model import Activity, Alternative, Hardware, Mission, Objective, Parallel, Robot
from mcpn.net.compose import MissionNet, compose

README = Path(__file__).resolve().parents[1] / "README.md"
BEGIN, END = "<!-- matrix -->\n", "<!-- end of matrix -->\n"
ENGINES: tuple[Engine, ...] = ("explicit", "symbolic", "local")


def mission(*, contention: bool) -> MissionNet:
    """Two branches that use hardware, the same one or one each; the spare is never used."""
    robot = Robot(
        name="r",
        hardware=(Hardware(name="H"), Hardware(name="I"), Hardware(name="spare")),
        activities=(
            Activity(name="use", alternatives=(Alternative(name="use", consumes=("H",)),)),
            Activity(
                name="also", alternatives=(Alternative(name="also", consumes=("H" if contention else "I",)),)
            ),
        ),
    )
    branches = Objective(name="x", activities=("use",)), Objective(name="y", activities=("also",))
    return compose(Mission(name="m", robots=(robot,), blocks=(Parallel(name="both", blocks=branches),)))


def decided(found: MissionCheck) -> bool:
    return all(verdict.holds is not None for verdict in found.verdicts.values())


def answers(engine: Engine, on: On, formula: str, *fair: str) -> bool:
    """Whether a formula is answered, with a run that shows it."""
    found = mission(contention=False)
    questions = Questions(found.net, found, on=on, fair=fair, engine=engine)
    answer = questions.answer(formula, questions.core(parse(formula)))
    return bool(answer.witness.steps) or answer.holds


def behaves(engine: Engine) -> bool:
    net = replace(mission(contention=False).net, priorities=False)
    return behaviour(space_of(net, None, engine=engine)).home_markings >= 0


CHECKED: dict[Engine, MissionCheck] = {}


def checked(engine: Engine) -> MissionCheck:
    if engine not in CHECKED:
        CHECKED[engine] = check(mission(contention=False), engine=engine)
    return CHECKED[engine]


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
    "CTL on all markings": lambda e: answers(e, "markings", "A[!oos(H) U success]"),
    "liveness, home markings, deadlock of a net from elsewhere": behaves,
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
    """The matrix, as the README prints it."""
    rows = [["question", *(f"`{engine}`" for engine in ENGINES)], ["---"] * (1 + len(ENGINES))]
    rows += [[question, *(cell(question, engine) for engine in ENGINES)] for question in QUESTIONS]
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


def test_the_readme_s_matrix_of_questions_by_engines() -> None:
    _, _, rest = README.read_text().partition(BEGIN)
    printed, end, _ = rest.partition(END)
    assert end, "the README has the matrix between its two markers"
    assert printed == matrix(), "python -m tests.test_matrix writes it anew"


if __name__ == "__main__":
    before, begin, rest = README.read_text().partition(BEGIN)
    README.write_text(before + begin + matrix() + END + rest.partition(END)[2])
