"""Controllers in C beside the interpreter, which draws no net: the same modes, possible events and ends.

A campaign (``tests/draws.py``) says how many controllers were compiled, and of which form::

    MCPN_CAMPAIGN=300 python -m pytest -m slow -s tests/judge/test_compiled.py
"""

from __future__ import annotations

import random
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import get_args

import pytest
from hypothesis import strategies as st

from mcpn.controller.document import document
from mcpn.controller.generate import Form, generate
from mcpn.drawing.compose import compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission, Objective
from mcpn.robot.runtime.controller_tables import Tables
from mcpn.robot.targets import files
from mcpn.testing.elements import WIDEST
from mcpn.testing.judge.interpreter import Happening, Interpreter, Undetermined
from tests.controller.test_c import build, run_lines
from tests.draws import campaign
from tests.judge.players import named
from tests.small import activity, hw, mission, robot

MOST_TRANSITIONS = 500
EVENTS = 500
"""That one controller is told."""

Said = tuple[str, frozenset[str], frozenset[Happening], str]
"""Whether an event was taken, the alternatives that run, the events that are possible, the mission's end."""


def played(of: Mission, known: dict[Happening, str], rng: random.Random) -> Iterator[tuple[str, Said | None]]:
    """Events at random, a tenth of them any event, and what the interpreter says; an empty one begins again.

    Raises:
        Undetermined: Two activities ask for one thing at the same moment.
    """
    judge = Interpreter(of)
    state, ended = judge.initial, 0
    for _ in range(EVENTS):
        possible = sorted(judge.possible(state))
        ended += state.outcome is not None
        if ended > 3 or not possible:
            state, ended = judge.initial, 0
            yield "", None
            continue
        happened = rng.choice(possible if rng.random() < 0.9 else sorted(known))
        taken = happened in possible
        state = judge.after(state, happened) if taken else state
        mode = frozenset(f"{name}.{way}" for name, way in judge.seen(state).mode)
        said = "taken" if taken else "refused", mode, frozenset(judge.possible(state)), state.outcome or "-"
        yield known[happened], said


def read(line: str) -> Said:
    """A line of the program."""
    took, mode, possible, outcome = (part.strip() for part in line.split("|"))
    events = frozenset(map(named, possible.split()))
    return took.partition(":")[0], frozenset(mode.split()), events, outcome


def agreed(of: Mission, form: Form, seed: int) -> str:
    """Holds a compiled controller against the interpreter; says of which form it is, or why it is left."""
    try:
        net = compose(of)
        if len(net.net.transitions) > MOST_TRANSITIONS:
            return "too large"
        made = document(generate(net, form, max_states=2000), net)
        known = {named(text): text for text in Tables(made).known}
        run = [*played(of, known, random.Random(seed))]
    except (SemanticsError, LimitError, Undetermined) as error:
        return type(error).__name__
    with tempfile.TemporaryDirectory() as folder:
        lines = run_lines(build(files(made, "c"), Path(folder)), [text for text, _ in run])
    for number, (line, said) in enumerate(zip(lines, (said for _, said in run if said), strict=True)):
        assert read(line) == said, [text for text, _ in run if text][: number + 1]
    return form


FORMS = get_args(Form)


@pytest.mark.slow
def test_campaign() -> None:
    drawn = st.tuples(WIDEST, st.sampled_from(FORMS), st.integers(0, 2**32))
    found = campaign(drawn, lambda one: agreed(*one), 300)
    assert sum(found[form] for form in FORMS) > found["drawn"] / 4


def test_a_controller_by_hand() -> None:
    of = mission(
        robot(hw("h", "g"), activity("a", ("h",), ("g",))),
        Objective(name="o", activities=("a",), failure="p"),
        Objective(name="p", activities=("a",)),
    )
    assert agreed(of, "hierarchical", 1) == "hierarchical"
