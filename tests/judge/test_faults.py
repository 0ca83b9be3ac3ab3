"""Missions that showed a fault of mcpn to judges that share no code with it: the folder of ``--faults``."""

from __future__ import annotations

from pathlib import Path

import pytest

from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.spaces.engine_names import SPACE_ENGINES
from mcpn.testing.judge.interpreter import (
    DECLARED,
    FAILURE,
    OUT_OF_SERVICE,
    REPAIRED,
    START,
    SUCCESS,
    TIMEOUT,
    Happening,
    Interpreter,
    Seen,
)
from tests.commands import mcpn, output
from tests.judge.lockstep import Judge

BEGIN = (START, "")
LEAK = (DECLARED, "leak")


def fault(folder: Path, name: str) -> Path:
    path = folder / f"{name}.xml"
    if not path.is_file():
        pytest.skip(f"needs {path.name} in the folder that --faults names")
    return path


@pytest.mark.parametrize(
    "name",
    [
        "once_in_each",
        "once_in_use",
        "once_in_repeated_parent",
        "waiting_for_hardware",
        "waiting_for_exclusive_software",
        "busy_alternative_waits",
        "two_products_not_confluent",
        "return_by_unrelated_handler",
        "parameters_precedence",
        "hw_fails_while_waiting",
        "producer_restarted_pr3",
        "producer_restarted_pr4",
        "end_around_first",
        "end_around_first_not",
        "failed_pause_not_recovered",
        "timeout_goto_of_shelter",
        "key_error_away",
        "event_abort_after_success",
        "event_abort_after_failure",
        "event_success_after_failure",
        "when_branches_order",
        "failure_when_number_last",
    ],
)
def test_every_engine_and_controller_does_what_the_page_says(faults: Path, name: str) -> None:
    assert Judge(read_mission(fault(faults, name))).judge().kind == "agree"


@pytest.mark.parametrize("engine", SPACE_ENGINES)
@pytest.mark.parametrize(
    ("name", "formula"),
    [
        ("event_abort_after_success", "E X (happens(e) & X abort)"),
        ("event_abort_after_failure", "E X (happens(e) & X abort)"),
        ("event_success_after_failure", "E X (happens(e) & X success)"),
        ("when_branches_order", "E X (happens(w) & X abort)"),
        (
            "failure_when_number_last",
            "E F (happens(OBJ_a_EV_OK) & X (happens(OBJ_b_EV_FAIL) & X success))",
        ),
    ],
)
def test_what_ends_at_one_moment_ends_as_the_page_says(
    faults: Path, name: str, formula: str, engine: str
) -> None:
    (answer,) = output("ask", fault(faults, name), formula, "--engine", engine)
    assert answer["holds"]


@pytest.mark.parametrize("engine", SPACE_ENGINES)
@pytest.mark.parametrize(
    ("name", "success"),
    [
        ("risk_self_interrupt", 0.5),
        ("risk_self_interrupt_success", 1.0),
        ("risk_mission_handler_to_first", 0.5),
        ("risk_parallel_to_itself", 0.5),
    ],
)
def test_an_interruption_that_leads_back_leaves_the_probability_whole(
    faults: Path, name: str, success: float, engine: str
) -> None:
    risk = output("causes", fault(faults, name), "--rates", "--engine", engine)["risk"]
    assert (risk["success"], risk["failure"]) == pytest.approx((success, 1 - success))


def seen(mission: Mission, *happenings: Happening) -> tuple[Seen, set[Happening]]:
    """What the interpreter sees after some events, and what may happen then."""
    interpreter = Interpreter(mission)
    state = interpreter.initial
    for happened in happenings:
        assert happened in interpreter.possible(state), happened
        state = interpreter.after(state, happened)
    return interpreter.seen(state), interpreter.possible(state)


@pytest.mark.parametrize("name", ["once_in_each", "once_in_use", "once_in_repeated_parent"])
def test_a_handler_that_happens_once_does_so_once_by_the_page(faults: Path, name: str) -> None:
    now, possible = seen(read_mission(fault(faults, name)), BEGIN, LEAK)
    (running,) = now.running
    assert possible == {(SUCCESS, running), (FAILURE, running)}


def test_a_producer_does_not_return_undeclared_by_the_page(faults: Path) -> None:
    mission = read_mission(fault(faults, "return_by_unrelated_handler"))
    now, _ = seen(mission, BEGIN, (OUT_OF_SERVICE, "h0"), (REPAIRED, "h0"))
    assert ("d", "spare") in now.mode


def test_a_producer_of_two_products_goes_on_for_another_branch_by_the_page(faults: Path) -> None:
    mission = read_mission(fault(faults, "two_products_not_confluent"))
    now, _ = seen(mission, BEGIN, (OUT_OF_SERVICE, "h"), (REPAIRED, "h"), (SUCCESS, "o2"))
    assert now.running == {"o1", "o3"}
    assert ("d", "spare") in now.mode


@pytest.mark.parametrize(
    ("name", "way"),
    [
        ("waiting_for_hardware", "b"),
        ("waiting_for_exclusive_software", "b"),
        ("busy_alternative_waits", "with_h"),
    ],
)
def test_an_activity_waits_for_what_another_has_by_the_page(faults: Path, name: str, way: str) -> None:
    now, possible = seen(read_mission(fault(faults, name)), BEGIN, (SUCCESS, "o1"))
    assert now.waiting == {("b", way)}
    assert (SUCCESS, "o2") not in possible
    assert (FAILURE, "o2") in possible


def test_the_innermost_parameter_counts_by_the_page(faults: Path) -> None:
    interpreter = Interpreter(read_mission(fault(faults, "parameters_precedence")))
    said = {name: leaf.parameters for name, leaf in interpreter.objectives.items()}
    assert said["u_12_1.o"] == {"room": "12", "speed": "2", "round": "1"}
    assert said["u_12_1.w"]["room"] == "own"
    assert said["u_14_2.inner.q"] == {"room": "14", "speed": "2", "z": "fromP", "round": "2"}
    assert (said["v_12.o"]["room"], said["v_12.w"]["room"]) == ("use", "own")
    assert said["v_12.inner.q"]["room"] == "use"
    assert (said["y_12_1"]["room"], said["y_12_1"]["round"]) == ("own2", "mine")
    assert (said["h_1"]["p1"], said["i_A"]["p1"]) == ("inner", "A")
    assert interpreter.parameters("x_12", "a", "a0") == {"k": "act", "k2": "alt", "room": "12"}


@pytest.mark.parametrize("name", ["producer_restarted_pr3", "producer_restarted_pr4"])
def test_a_producer_that_is_needed_when_all_is_over_goes_on_by_the_page(faults: Path, name: str) -> None:
    now, _ = seen(read_mission(fault(faults, name)), BEGIN, (SUCCESS, "o1"))
    assert now.refused == {"b"}
    assert ("d", "y1") in now.mode


@pytest.mark.parametrize(
    ("name", "events", "running"),
    [
        ("end_around_first", [(DECLARED, "e")], {"s1"}),  # as event_success_after_failure
        ("end_around_first_not", [(DECLARED, "e")], {"s1"}),
        ("failed_pause_not_recovered", [(DECLARED, "e"), (FAILURE, "X_at_A_run1")], {"z1"}),
        ("failed_pause_not_recovered", [(FAILURE, "A_run1")], {"Y_A1"}),
        ("timeout_goto_of_shelter", [(DECLARED, "e"), (TIMEOUT, "X_at_A")], {"z2"}),
        ("timeout_goto_of_shelter", [(DECLARED, "e"), (FAILURE, "X_at_A")], {"z1"}),
    ],
)
def test_what_leads_on_by_the_page(
    faults: Path, name: str, events: list[Happening], running: set[str]
) -> None:
    now, _ = seen(read_mission(fault(faults, name)), BEGIN, *events)
    assert now.running == running


@pytest.mark.slow  # test_lockstep.py draws wide blocks of fewer branches
def test_a_wide_block_is_as_the_page_says(faults: Path) -> None:
    verdict = Judge(read_mission(fault(faults, "wide_parallel_7"))).judge()
    assert verdict.kind == "agree"
    # Each branch runs or has ended in one of two ways, not all ended; and before, success and failure.
    assert verdict.states == 3**7 - 2**7 + 3


def test_a_recovery_that_the_way_falls_into_is_told(faults: Path) -> None:
    found = mcpn("check", fault(faults, "recovery_falls_into"))
    assert found.returncode == 1
    assert 'a block after which all is done says success="succeed"' in found.stdout


def test_a_pause_that_leads_to_what_is_never_entered_is_told(faults: Path) -> None:
    found = mcpn("check", fault(faults, "key_error_away"))
    assert found.returncode == 0
    assert "objective o5 can never be entered: event e1 never happens while block u4 runs" in found.stdout
