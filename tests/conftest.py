"""Options, fixtures and hypothesis profiles that every test shares."""

from __future__ import annotations

import csv
import gc
import os
import random
import signal
import sys
from collections.abc import Generator, Iterator
from functools import wraps
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, settings

from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.drawing.compose import MissionNet, compose
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.robot.runtime import Controller
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.markings.graph import StateGraph
from tests import shares

ROOT = Path(__file__).resolve().parents[1]
ULYSSE = ROOT / "experiments" / "ulysse" / "mission.xml"


def interruptible() -> None:
    """For ``preexec_fn``: a child that hears the signals that a background job or ``nohup`` ignores."""
    for number in (signal.SIGINT, signal.SIGQUIT, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


_quiet = [HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much]
# smoke: the same examples each time, where no profile is named; ci: others with each change, from a printed
# seed; dev: while a property is worked on, and all of them at night; nightly: of long campaigns.
# In ci what fails is told as drawn: shrinking may take longer than a test has, which then tells nothing.
for _name, _examples, _fixed in (
    ("smoke", 10, True),
    ("ci", 10, False),
    ("dev", 100, False),
    ("nightly", 5000, False),
):
    settings.register_profile(
        _name,
        max_examples=_examples,
        derandomize=_fixed,
        deadline=None,
        print_blob=True,
        suppress_health_check=_quiet,
        phases=[phase for phase in Phase if phase is not Phase.shrink or _name != "ci"],
    )
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "smoke"))


def pytest_addoption(parser: pytest.Parser) -> None:
    drawn = random.randrange(1 << 32)
    parser.addoption("--seed", type=int, default=drawn, help="Seed of what is drawn afresh (default: any).")
    parser.addoption("--cases", type=int, default=10_000, help="Mutated inputs of a campaign.")
    parser.addoption("--rewrite", action="store_true", help="Write tests/snapshots/ anew.")
    for option, variable, what in (
        ("--mcc", "MCPN_MCC", "nets of the Model Checking Contest with oracles.tsv"),
        ("--reference", "MCPN_REFERENCE", "reference nets of the Ulysse mission"),
        ("--roscon", "MCPN_ROSCON", "worlds of the ROS deliberation workshop 2024"),
        ("--faults", "MCPN_FAULTS", "missions that once showed a fault"),
        ("--trees", "MCPN_TREES", "behaviour trees that others wrote"),
        ("--tapaal", "MCPN_TAPAAL", "test models of TAPAAL's engine, verifypn"),
        ("--btcpp", "MCPN_BTCPP", "sources of BehaviorTree.CPP"),
    ):
        parser.addoption(option, default=os.environ.get(variable), help=f"folder of the {what} (${variable})")
    python = os.environ.get("MCPN_PYTHON310")
    parser.addoption("--python310", default=python, help="a CPython 3.10 that runs what is generated")


def pytest_xdist_auto_num_workers(config: pytest.Config) -> int | None:
    """One named test runs in this process, where a debugger and prints reach it; others on all cores."""
    return 0 if any("::" in argument for argument in config.args) else None


def pytest_collection_finish() -> None:
    """What is imported and collected stays to the end: the collector of garbage need not look at it again."""
    gc.freeze()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None]:
    """Fails a property that returned early for too large a share of its examples (see tests/shares.py)."""
    handle = getattr(getattr(item, "obj", None), "hypothesis", None)
    if handle is None:
        return (yield)
    examples = 0
    inner = handle.inner_test

    @wraps(inner)
    def counted(*args: object, **kwargs: object) -> object:
        nonlocal examples
        examples += 1
        return inner(*args, **kwargs)

    shares.left.clear()
    handle.inner_test = counted
    try:
        result = yield
    finally:
        handle.inner_test = inner
    marker = item.get_closest_marker("may_leave")
    ceiling = marker.args[0] if marker else shares.CEILING
    if examples >= shares.ENOUGH and shares.left.total() > shares.most(examples, ceiling):
        told = ", ".join(f"{count} {reason}" for reason, count in shares.left.most_common())
        pytest.fail(f"returned early for {shares.left.total()} of {examples} examples: {told}")
    return result


@pytest.fixture(scope="session")
def fresh_seed(request: pytest.FixtureRequest) -> int:
    """A seed that differs from run to run; the header of the run tells how to have it again."""
    return int(request.config.getoption("--seed"))


def pytest_report_header(config: pytest.Config) -> str:
    return f"drawn afresh from --seed {config.getoption('--seed')}"


def _folder(request: pytest.FixtureRequest, option: str, beside: str) -> Path:
    given = request.config.getoption(option)
    folder = Path(given) if given else ROOT.parent / "shared" / beside
    if not folder.is_dir():
        pytest.skip(f"needs the folder that {option} names")
    return folder


@pytest.fixture(scope="session")
def mcc(request: pytest.FixtureRequest) -> Path:
    """The folder of the contest's nets."""
    return _folder(request, "--mcc", "mcc")


@pytest.fixture(scope="session")
def tapaal(request: pytest.FixtureRequest) -> Path:
    """The folder of the test models of TAPAAL's engine."""
    return _folder(request, "--tapaal", "tapaal")


@pytest.fixture(scope="session")
def mcc_oracles(mcc: Path) -> dict[str, dict[str, str]]:
    """The contest's answers by net."""
    with (mcc / "oracles.tsv").open(newline="") as file:
        return {row["model"]: row for row in csv.DictReader(file, delimiter="\t")}


@pytest.fixture(scope="session")
def reference(request: pytest.FixtureRequest) -> Path:
    """The folder of the reference nets of the Ulysse mission."""
    return _folder(request, "--reference", "reference")


@pytest.fixture(scope="session")
def faults(request: pytest.FixtureRequest) -> Path:
    """The folder of missions that once showed a fault."""
    return _folder(request, "--faults", "faults")


@pytest.fixture(scope="session")
def trees(request: pytest.FixtureRequest) -> Path:
    """The folder of behaviour trees that others wrote."""
    return _folder(request, "--trees", "trees")


@pytest.fixture(scope="session")
def roscon(request: pytest.FixtureRequest) -> Path:
    """The folder of the workshop's worlds."""
    return _folder(request, "--roscon", "roscon")


@pytest.fixture(scope="session")
def ulysse() -> Mission:
    """The mission of the paper, section 8."""
    return read_mission(ULYSSE)


@pytest.fixture(scope="session")
def ulysse_net(ulysse: Mission) -> MissionNet:
    return compose(ulysse)


@pytest.fixture(scope="session")
def ulysse_document(ulysse_net: MissionNet) -> dict[str, Any]:
    """Its controller, as the file holds it."""
    return document(generate(ulysse_net), ulysse_net)


@pytest.fixture
def controller(ulysse_document: dict[str, Any]) -> Controller:
    """A controller of it that has handled nothing."""
    return Controller.from_document(ulysse_document)


@pytest.fixture(scope="session")
def ulysse_markings(ulysse_net: MissionNet) -> StateGraph:
    return explore(ulysse_net.net)


@pytest.fixture(autouse=True)
def as_a_process_finds_it(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """What a command run in this process finds, and leaves: no width of a terminal, the limit on digits."""
    monkeypatch.delenv("COLUMNS", raising=False)
    digits = sys.get_int_max_str_digits()
    yield
    sys.set_int_max_str_digits(digits)
