"""Numbers of risk of missions that declared events interrupt, against a dense solve that the tests write.

``MCPN_CAMPAIGN`` says how many missions the campaign draws (2,000 if not set), ``MCPN_CAMPAIGN_SEED`` which::

    MCPN_CAMPAIGN=2000 python -m pytest -m slow -s tests/answers/test_risk_interrupted.py
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mcpn.answers.causes.prospects import Prospects
from mcpn.answers.causes.risk import Risk, risk
from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.drawing.compose import compose
from mcpn.errors import ConfluenceError, DivergenceError, LimitError
from mcpn.mission.model import Block, FactRoute, Handler, Mission, Objective, Parallel, Recursive
from mcpn.mission.robot import Alternative, DeclaredEvent, Fact, FactChange, Hardware
from mcpn.mission.xml import read_mission
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.engine_names import Engine
from mcpn.spaces.stable.alternatives import direct
from tests.answers.dense import Dense, Numbers, any_missions, interrupted_missions, spared_missions
from tests.answers.exact import exact_ends, scaled
from tests.draws import MOST_TRANSITIONS, campaign, fewer
from tests.logic.asked import ENGINES
from tests.small import activity, mission, robot

DRAWN = st.one_of(interrupted_missions(), any_missions())
MOST_STATES = 300
RARE = (1e-4, 1e-12)
"""How many times as often as drawn hardware fails."""


def assert_same(found: Risk, numbers: Numbers) -> None:
    assert found.success == pytest.approx(numbers.success, rel=1e-9, abs=1e-11)
    assert found.failure == pytest.approx(numbers.failure, rel=1e-9, abs=1e-11)
    assert found.degraded_modes == pytest.approx(numbers.degraded_modes, rel=1e-9, abs=1e-11)
    assert found.importance == pytest.approx(dict(numbers.importance), rel=1e-9, abs=1e-11)
    assert (found.abort is None) == (numbers.abort is None)
    if found.abort is not None and numbers.safety_importance is not None:
        assert found.abort == pytest.approx(numbers.abort, rel=1e-9, abs=1e-11)
        safely = dict(numbers.safety_importance)
        assert found.safety_importance == pytest.approx(safely, rel=1e-9, abs=1e-11)


def by(engine: Engine, mission: Mission) -> Risk:
    found = compose(mission)
    return risk(Prospects(found, spaces_of(found).space(engine, "alternatives")))


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("name", "success"), [("rk2", 0.0), ("rk5", 0.5), ("rk8", 6 / 11)])
def test_facts_are_as_at_the_start(faults: Path, name: str, success: float, engine: Engine) -> None:
    found = by(engine, read_mission(faults / f"risk_facts_at_start_{name}.xml"))
    assert found.success == pytest.approx(success)
    assert found.failure == pytest.approx(1 - success)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("rate", [None, 0.5])
def test_what_an_event_may_change_before_the_start_is_not_changed(rate: float | None, engine: Engine) -> None:
    """The door is closed, unless somebody opens it meanwhile; a closed one lets nobody through."""
    of = robot((), activity("go", ()), activity("free", ()))
    opened = DeclaredEvent(name="opens", sets=(FactChange(fact="open", to="true"),), rate=rate)
    of = replace(of, facts=(Fact(name="open"),), events=(opened,))
    through = FactRoute(on="success", goto="fail", when=("!open",))
    of_mission = mission(of, replace(other("wait"), duration=2.0, routes=(through,)))
    found = by(engine, of_mission)
    success = 0.0 if rate is None else rate / (rate + 1 / 2.0)
    assert (found.success, found.failure) == pytest.approx((success, 1 - success))
    assert found.importance == {}


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("name", "success"),
    [
        ("risk_self_interrupt", 0.5),
        ("risk_self_interrupt_success", 1.0),
        ("risk_mission_handler_to_first", 0.5),
        ("risk_parallel_to_itself", 0.5),
    ],
)
def test_what_can_only_fail_does_not_wait_for_an_event(
    faults: Path, name: str, success: float, engine: Engine
) -> None:
    found = by(engine, read_mission(faults / f"{name}.xml"))
    assert found.success == pytest.approx(success)
    assert found.failure == pytest.approx(1 - success)
    assert found.unrated == ("e",)


def test_the_stable_states_of_a_small_block(faults: Path) -> None:
    """Five activities on one resource: few stable states, listed here without a proof, far more markings."""
    found = compose(read_mission(faults / "slow_small_block.xml"))
    graph = direct(found.net, proof=False)
    assert (graph.states, graph.edges) == (336, 1340)
    assert_same(risk(Prospects(found, ArraySpace(graph))), Dense(found, graph).numbers())


@pytest.mark.long
@pytest.mark.parametrize("engine", ENGINES)
def test_a_small_block_by_every_engine(faults: Path, engine: Engine) -> None:
    """The same with the proof of confluence, whose diagrams hold 10^11 markings where nothing has a rank."""
    of = read_mission(faults / "slow_small_block.xml")
    found = compose(of)
    assert_same(by(engine, of), Dense(found, direct(found.net, proof=False)).numbers())


RHO, LAMBDA, D = 0.7, 0.25, 1.6
END = 1 / D


def leg(*handlers: Handler, **more: str) -> Objective:
    """An objective that needs the hardware, with mean duration D."""
    return Objective(name="leg", activities=("go",), duration=D, handlers=handlers, **more)  # type: ignore[arg-type]


def leaking(rate: float | None, *blocks: Block, handlers: tuple[Handler, ...] = ()) -> Mission:
    hardware = (Hardware(name="h", failure_rate=LAMBDA),)
    of = robot(hardware, activity("go", ("h",)), activity("free", ()))
    of = replace(of, events=(DeclaredEvent(name="leak", rate=rate),))
    return replace(mission(of, *blocks), handlers=handlers)


def to(target: str, *, once: bool = False) -> Handler:
    return Handler(event="leak", goto=target, once=once)


def other(name: str, duration: float = 1.0) -> Objective:
    return Objective(name=name, activities=("free",), duration=duration)


def restarted_block() -> float:
    """Success of two branches, of which one needs the hardware, that the event restarts together.

    The unknowns are the success with both running, with the free one left, with the other left.
    """
    leaving = LAMBDA + RHO
    after_loss = 1 / (1 + RHO)  # the free one left, its sibling ended well, the hardware lost since
    system = [[END + 1 + leaving - RHO, -END, -1], [-RHO, 1 + leaving, 0], [-RHO, 0, END + leaving]]
    return float(np.linalg.solve(system, [0, 1 + LAMBDA * after_loss, END])[0])


STAGE = END + LAMBDA + RHO
INTERRUPTED: list[tuple[str, Mission, float]] = [
    ("never without a rate", leaking(None, leg(to("home")), other("home")), END / (END + LAMBDA)),
    ("never at the rate 0", leaking(0.0, leg(to("home")), other("home")), END / (END + LAMBDA)),
    ("on to another", leaking(RHO, leg(to("home")), other("home")), (END + RHO) / STAGE),
    ("out of the mission", leaking(RHO, leg(to("fail"))), END / STAGE),
    ("into itself", leaking(RHO, leg(to("leg"))), END / (END + LAMBDA)),
    ("to the first", leaking(RHO, leg(), handlers=(to("leg"),)), END / (END + LAMBDA)),
    (
        "back to the first",
        leaking(RHO, other("start"), leg(to("start")), other("end")),
        # In "start" the hardware may fail unnoticed; without repair what counts is whether it outlives all.
        (s := 1 / (1 + LAMBDA)) * END / (STAGE - RHO * s),
    ),
    (
        "once, then out",
        leaking(RHO, leg(to("leg", once=True)), handlers=(to("fail"),)),
        END / STAGE * (1 + RHO / STAGE),
    ),
    (
        "a block into itself",
        leaking(RHO, Parallel(name="both", blocks=(leg(), other("beside")), handlers=(to("both"),))),
        restarted_block(),
    ),
    (
        "a block, one branch of which handles it",
        leaking(RHO, Parallel(name="both", blocks=(leg(to("succeed")), other("beside")))),
        (END + RHO) / STAGE,
    ),
]


ABORTED: list[tuple[str, Mission, float, float]] = [
    # One objective, then a way home that may fail too.
    (
        "where it fails",
        leaking(RHO, replace(leg(), failure="abort")),
        END / (END + LAMBDA),
        LAMBDA / (END + LAMBDA),
    ),
    ("by an event", leaking(RHO, leg(to("abort"))), END / STAGE, RHO / STAGE),
    (
        "and comes home or not",
        leaking(
            RHO,
            replace(leg(to("home")), success="succeed"),
            replace(other("home"), failure_probability=0.25, success="abort", failure="fail"),
        ),
        END / STAGE,
        RHO / STAGE * 0.75,
    ),
    (
        # The branch beside is stopped: it neither ends well nor badly.
        "in a branch",
        leaking(
            RHO,
            Parallel(
                name="both",
                blocks=(
                    replace(other("beside", D), failure_probability=1.0),
                    Recursive(name="r", blocks=(leg(to("abort")),)),
                ),
            ),
        ),
        0.0,
        # It aborts while the leg runs; else all fails, be it by the leg or by what is beside.
        RHO / STAGE,
    ),
]


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("of", "success", "abort"), [row[1:] for row in ABORTED], ids=[row[0] for row in ABORTED]
)
def test_three_ends_against_closed_forms(of: Mission, success: float, abort: float, engine: Engine) -> None:
    found = by(engine, of)
    assert found.success == pytest.approx(success)
    assert found.abort == pytest.approx(abort)
    assert found.success + found.failure + abort == pytest.approx(1)


def test_the_importance_of_what_brings_it_home() -> None:
    """Two resources: one that the work needs, one that the way home needs; both are lost for good."""
    hardware = (Hardware(name="h", failure_rate=LAMBDA), Hardware(name="motor", failure_rate=LAMBDA))
    of = robot(hardware, activity("go", ("h",)), activity("free", ("motor",)))
    home = replace(other("home"), success="abort", failure="fail")
    for engine in ENGINES:
        found = by(engine, mission(of, replace(leg(), success="succeed", failure="home"), home))
        assert found.safety_importance is not None
        # Without the motor a leg that fails ends badly; with it that never happens, as nothing else fails.
        lost = LAMBDA / (END + LAMBDA)
        assert found.importance == pytest.approx({"h": 1.0, "motor": 0.0})
        assert found.safety_importance["motor"] == pytest.approx(lost)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("of", "success"), [row[1:] for row in INTERRUPTED], ids=[row[0] for row in INTERRUPTED]
)
def test_interruptions_against_closed_forms(of: Mission, success: float, engine: Engine) -> None:
    found = by(engine, of)
    assert found.success == pytest.approx(success)
    assert found.failure == pytest.approx(1 - success)
    assert found.unrated == (("leak",) if of.events[0].rate is None else ())


def test_interruptions_count_in_importance() -> None:
    row = by("explicit", leaking(RHO, leg(to("home")), other("home")))
    # Where the hardware never fails it comes home or to its end; where it is lost the leg fails at once.
    assert row.importance == pytest.approx({"h": 1.0})
    assert by("local", leaking(RHO, leg(to("fail")))).importance == pytest.approx({"h": END / (END + RHO)})


def tangled(mission: Mission) -> bool:
    """Whether an event with a rate changes several facts or one of many values: sections do not know that."""
    values = {fact.name: fact.values for robot in mission.robots for fact in robot.facts}
    changing = (event.sets for event in mission.events if event.rate)
    return any(len(sets) > 1 or any(len(values[s.fact]) > 2 for s in sets) for sets in changing)


def judge(mission: Mission) -> str:
    """Compares the numbers of each engine with those of the dense solve; says what kind of mission it was."""
    found = compose(mission)
    if len(found.net.transitions) > MOST_TRANSITIONS:
        return "too large"
    try:
        graph = direct(found.net, max_states=MOST_STATES)
        assert Prospects(found, ArraySpace(graph)).objectives
    except (LimitError, ConfluenceError, DivergenceError) as error:
        return type(error).__name__
    numbers = Dense(found, graph).numbers()
    assert_same(risk(Prospects(found, ArraySpace(graph))), numbers)
    for engine in ("symbolic", "local"):
        if engine == "symbolic" or not tangled(mission):
            assert_same(risk(Prospects(found, spaces_of(found).space(engine, "alternatives"))), numbers)
    handled = {i.event for section in found.graph.all_sections() for i in section.interruptions}
    rates = {event.name for event in mission.events if event.rate}
    assert_exact(mission)
    if found.abort is not None:
        return "interruptions and abort" if handled & rates else "no interruption but abort"
    if not handled:
        return "no interruption"
    return "interruptions with rates" if handled & rates else "interruptions without rates"


def assert_exact(mission: Mission, rare: Sequence[float] = RARE) -> None:
    """Each end by each engine, relative to itself, however rare failures are."""
    for factor in rare:
        found = compose(scaled(mission, factor))
        graph = direct(found.net, proof=False)
        ends = exact_ends(Dense(found, graph))
        local = () if tangled(mission) else (spaces_of(found).space("local", "alternatives"),)
        for space in (ArraySpace(graph), *local):
            numbers = risk(Prospects(found, space))
            for one, exact in zip(
                (numbers.success, numbers.failure, numbers.abort or 0.0), ends, strict=True
            ):
                assert one == pytest.approx(float(exact), rel=1e-9, abs=1e-300)


@pytest.mark.parametrize("factor", [1.0, 1e-6, 1e-12])
def test_a_late_loss_beside_a_section(factor: float) -> None:
    """Two of three spares are lost before they are needed: 1e-24 and less, by sections as on the whole."""
    hardware = tuple(Hardware(name=n, failure_rate=0.1 * factor) for n in ("a", "b", "c"))
    go = replace(
        activity("go", ("a",)),
        alternatives=tuple(Alternative(name=f"by_{n}", consumes=(n,)) for n in ("a", "b", "c")),
    )
    of = robot(hardware, go, activity("free", ()))
    leg = Objective(name="leg", activities=("go",), duration=3.0)
    assert_exact(mission(of, other("wait", 5.0), leg, other("rest")), (factor,))


@pytest.mark.parametrize("engine", ENGINES)
def test_late_hardware_beside_sections_that_lead_to_each_other(engine: Engine) -> None:
    """Of the two bits of what is detected late one never is, not even where the section is left at once."""
    hardware = (Hardware(name="h"), Hardware(name="late", detected="late"))
    of = robot(hardware, activity("hold", ("h",)), activity("go", ("late",)))
    first = Objective(name="x", activities=("hold",), duration=7.0)
    both = Objective(name="both", activities=("hold", "go"), duration=1.0)
    again = Recursive(name="r", blocks=(both,), routes=(FactRoute(goto="x", when=("b=true",)),))
    found = by(engine, mission(replace(of, facts=(Fact(name="b"),)), first, again))
    assert (found.success, found.failure) == (1, 0)


@pytest.mark.parametrize("engine", ENGINES)
def test_the_small_probabilities_of_a_file(faults: Path, engine: Engine) -> None:
    of = read_mission(faults / "risk_small_probabilities.xml")
    _, failure, _ = exact_ends(Dense(found := compose(of), direct(found.net, proof=False)))
    assert by(engine, of).failure == pytest.approx(float(failure), rel=1e-12)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("factor", [1.0, 1e-6, 1e-12])
def test_what_goes_round_before_it_ends(factor: float, engine: Engine) -> None:
    """It tries again and again: what ends it is rare against what goes round."""
    hardware = (
        Hardware(name="h", failure_rate=5.0, repair_rate=3.0),
        Hardware(name="g", failure_rate=factor),
    )
    of = robot(hardware, activity("go", ("h",)), activity("hold", ("g",)))
    first = Objective(name="x", activities=("hold",), duration=1.0, failure="y")
    again = replace(first, name="z", success="x", failure="fail", failure_probability=factor / 2)
    both = mission(
        of, replace(first, success="z"), again, Objective(name="y", activities=("go",), duration=1.0)
    )
    graph = direct((net := compose(both)).net, proof=False)
    exact = exact_ends(Dense(net, graph))
    found = by(engine, both)
    assert (found.success, found.failure) == pytest.approx(tuple(map(float, exact[:2])), rel=1e-9, abs=1e-300)


@fewer(0.2)
@given(DRAWN)
def test_numbers_are_those_of_a_dense_solve(mission: Mission) -> None:
    assume(judge(mission).partition(" ")[0] in ("no", "interruptions"))


@fewer(0.3)
@given(spared_missions(), st.sampled_from([1.0, 1e-6, 1e-12]))
def test_what_fails_where_all_spares_are_lost_is_as_rare_as_that(mission: Mission, factor: float) -> None:
    assert_exact(mission, (factor,))


@pytest.mark.slow
def test_campaign() -> None:
    found = campaign(DRAWN, judge, 2000)
    number = found["drawn"]
    assert found["interruptions with rates"] > number / 10
    assert found["interruptions without rates"] > number / 10
    assert found["interruptions and abort"] > number / 20
    assert found["no interruption but abort"] > number / 20
