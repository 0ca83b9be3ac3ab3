"""Rows of the page on other tools: how each is asked for its version, what of drawn missions it judges."""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from collections import Counter
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from hypothesis import strategies as st

from mcpn.answers.causes.chain import decimal
from mcpn.answers.causes.ends_by_time import within
from mcpn.answers.causes.whole_chain import whole_chain
from mcpn.drawing.compose import compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission
from mcpn.nets.formats import read_net, save_net
from mcpn.report.failures.drn import drn
from mcpn.testing import missions
from mcpn.trees.nodes.versions import PY_TREES
from tests.answers import test_ends_by_time as times
from tests.answers import test_whole_chain as chains
from tests.answers.dense import any_missions, interrupted_missions
from tests.answers.exact import scaled
from tests.controller.interpreters import scion_version
from tests.controller.test_scxml import DRAWN as CONTROLLED
from tests.controller.test_scxml import answers_as_the_runtime
from tests.draws import compared, composed
from tests.logic.automata import judged
from tests.nets.formats.test_pm4py import counted, counted_by_pm4py
from tests.report.test_scram import FOR_SCRAM, compare_with_scram
from tests.trees.languages import TooMuch
from tests.trees.py_trees_library import played
from tests.trees.test_judged import DRAWN as TREES
from tests.trees.test_judged import agree
from tests.trees.test_py_trees import trees as py_trees
from tests.trees.test_py_trees import whole

MOST_MARKINGS = 1000
"""Of a mission's net that pm4py counts."""


class Row(NamedTuple):
    """A row of the page.

    Args:
        tools: By name of a tool how it is asked for its version, ``None`` where it is not installed.
        file: Of which format.
        direction: Whether mcpn writes or reads it.
        held: What is the same.
        differs: What is not.
        test: Which holds it, where that is not :func:`tests.test_other_tools.test_drawn`.
        draws: What is drawn.
        judge: Says how much of what was compared.
        of: What is drawn, as the figures call it.
    """

    tools: Mapping[str, Callable[[], str | None]]
    file: str
    direction: str
    held: str
    differs: str
    test: str = ""
    draws: st.SearchStrategy[Any] | None = None
    judge: Callable[[Any, Path], Mapping[str, int]] = lambda drawn, folder: {}
    of: str = "missions"

    @property
    def names(self) -> str:
        """The tools with their versions."""
        return ", ".join(f"{name} {ask()}" for name, ask in self.tools.items())

    @property
    def here(self) -> bool:
        """Whether all its tools are installed."""
        return all(ask() for ask in self.tools.values())

    def compared(self, number: int, *, strict: bool) -> Counter[str]:
        """Draws so many, and has the tool judge them; see :func:`tests.draws.compared`."""
        assert self.draws is not None

        def judge(drawn: Any) -> Mapping[str, int]:
            with tempfile.TemporaryDirectory() as folder:
                return self.judge(drawn, Path(folder))

        return compared(self.draws, judge, number, strict=strict)


def of_python(*names: str) -> Callable[[], str | None]:
    """The version of a distribution of PyPI, the first that is installed."""

    def ask() -> str | None:
        for name in names:
            with suppress(PackageNotFoundError):
                return version(name)
        return None

    return ask


def of_program(program: str, option: str) -> Callable[[], str | None]:
    """What a program says of its version."""

    def ask() -> str | None:
        if shutil.which(program) is None:
            return None
        run = subprocess.run([program, option], capture_output=True, text=True, check=False)
        found = re.search(r"\d+(\.\d+)+", run.stdout + run.stderr)
        return found[0] if found else None

    return ask


def of_debian(package: str) -> Callable[[], str | None]:
    """The version of a package whose program says none, without Debian's own part."""

    def ask() -> str | None:
        if shutil.which("dpkg-query") is None:
            return None
        asked = ["dpkg-query", "-W", "-f", "${Version}", package]
        run = subprocess.run(asked, capture_output=True, text=True, check=False)
        return run.stdout.rpartition("-")[0] or None

    return ask


STORM = {"Storm, stormpy": of_python("stormpy")}


def by_scram(mission: Mission, folder: Path) -> Mapping[str, int]:
    """Cut sets and probabilities of every gate."""
    try:
        return compare_with_scram(mission, folder)
    except (LimitError, SemanticsError):
        return {}


def by_storm(drawn: tuple[Mission, float], folder: Path) -> Mapping[str, int]:
    """How the mission ends, exactly, by two engines; and each label in a property."""
    import stormpy

    mission_net = composed(scaled(*drawn))
    try:
        text = drn(whole_chain(chains.whole(mission_net).within(2000), decimal))
        ends = {end: judged(text, end) for end in chains.ENDS}
        for engine in ("explicit", "local"):
            with suppress(LimitError):  # of local: a fact of more than two values, which events change
                chains.agree(mission_net, engine, ends)
    except (LimitError, SemanticsError):
        return {}
    (folder / "chain.drn").write_bytes(text)
    labels = stormpy.build_model_from_drn[float](str(folder / "chain.drn")).labeling.get_labels()
    for label in labels:
        assert stormpy.parse_properties(f'Pmax=? [F "{label}"]')
    return {"probabilities": len(ends), "labels": len(labels)}


def by_storm_in_time(drawn: tuple[Mission, float], folder: Path) -> Mapping[str, int]:
    """How the mission has ended by a time."""
    mission, hours = drawn
    mission_net = composed(mission)
    try:
        prospects = chains.whole(mission_net)
        found = within(whole_chain(prospects.within(2000)), hours)
    except (LimitError, SemanticsError):
        return {}
    target = folder / "chain.drn"
    target.write_bytes(drn(whole_chain(prospects.within(2000), decimal)))
    count = 0
    for end in chains.ENDS:
        try:
            asked = times.by_storm_in_time(target, hours, end)
        except RuntimeError as error:
            if "empty submatrix" not in str(error):
                raise
            continue  # no immediate state leads to this end
        assert (getattr(found, end) or 0.0) == pytest.approx(asked, abs=1e-6), end  # Storm's precision
        count += 1
    return {"probabilities": count}


def by_pm4py(mission: Mission, folder: Path) -> Mapping[str, int]:
    """Markings and firings of the mission's net as pm4py reads it, and as it is read when pm4py wrote it."""
    import pm4py

    net = compose(mission).net
    save_net(net, folder / "ours.pnml")
    ours = counted(replace(net, priorities=False), MOST_MARKINGS)
    if ours is None:
        return {}
    made, initial, final = pm4py.read_pnml(str(folder / "ours.pnml"))
    assert counted_by_pm4py(pm4py, made, initial) == ours
    pm4py.write_pnml(made, initial, final, str(folder / "theirs.pnml"))
    assert counted(read_net(folder / "theirs.pnml"), MOST_MARKINGS) == ours
    return {"markings": ours[0], "firings": ours[1]}


def by_interpreter(name: str, steps: int) -> Callable[[Any, Path], Mapping[str, int]]:
    """The answers of an interpreter of SCXML to random events."""
    return lambda drawn, folder: answers_as_the_runtime(name, folder, drawn, steps)


def by_library(tree: str, folder: Path) -> Mapping[str, int]:
    """Runs of BehaviorTree.CPP that are runs of the imported mission."""
    try:
        return {"runs": runs} if (runs := agree(folder, tree, range(4))) else {}
    except TooMuch:
        return {}


def by_py_trees(tree: str, folder: Path) -> Mapping[str, int]:
    """Runs of py_trees that are runs of the imported mission."""
    try:
        return {"runs": runs} if (runs := agree(folder, whole(tree), range(4), PY_TREES, played)) else {}
    except TooMuch:
        return {}


ROWS = {
    "SCRAM": Row(
        {"SCRAM": of_program("scram", "--version")},
        "Open-PSA fault tree",
        "written",
        "minimal cut sets and probabilities of every gate at one time",
        "a static tree: no durations, no rates of events, no demand probabilities",
        draws=FOR_SCRAM,
        judge=by_scram,
    ),
    "Storm": Row(
        STORM,
        "DRN, a Markov automaton",
        "written",
        "each end's probability, exactly; each label can be asked for",
        "one choice in each state, so that minimum and maximum are equal; in labels `_` for dots",
        draws=chains.RATED_DRAWS,
        judge=by_storm,
    ),
    "Storm in time": Row(
        STORM,
        "DRN, by a time",
        "written",
        "probabilities by a time, to Storm's precision",
        "with floats only; not for ends to which no immediate state leads",
        draws=st.tuples(any_missions() | interrupted_missions(), st.sampled_from([0.01, 1.0, 20.0])),
        judge=by_storm_in_time,
    ),
    "HOA": Row(
        STORM,
        "HOA automaton",
        "written",
        "all headers are read; made deterministic and accepting in states, it is asked as a property",
        "ours need be none of these, and Storm refuses those",
        "tests/test_other_tools.py::test_storm_reads_an_automaton",
    ),
    "Spin": Row(
        {"Spin": of_program("spin", "-V"), "lbt": of_debian("lbt")},
        "formulas as automata",
        "compared",
        "the same words are accepted, on drawn formulas",
        "Debian's Spin has no `X`; operators bind otherwise",
        "tests/logic/ltl/test_automaton.py::test_the_language_is_that_of_other_translators",
    ),
    "pm4py": Row(
        {"pm4py": of_python("pm4py")},
        "PNML",
        "both",
        "markings and firings of missions' nets, read by pm4py and written by it again",
        "priorities, pages, inhibitor arcs, parallel arcs",
        draws=missions(max_objectives=2, max_hardware=2, max_sections=4),
        judge=by_pm4py,
    ),
    "pm4py, nets": Row(
        {"pm4py": of_python("pm4py")},
        "PNML",
        "both",
        "weights, markings, labels, on drawn nets",
        "as above",
        "tests/nets/formats/test_pm4py.py::test_what_pm4py_writes_is_read",
    ),
    "pictures": Row(
        {
            "resvg_py": of_python("resvg_py"),
            "librsvg": of_program("rsvg-convert", "--version"),
            "CairoSVG": of_python("CairoSVG"),
        },
        "SVG",
        "written",
        "each kind of picture has its colours",
        "files carry no dark mode",
        "tests/report/test_graph_pictures.py::test_each_kind_of_picture_has_its_colours_everywhere",
    ),
    "trang": Row(
        {"trang": of_debian("trang"), "jing": of_debian("jing")},
        "XSD made of `mcpn schema`",
        "written",
        "with Xerces worked missions fit, a misspelled element does not",
        "attributes that exclude children are not expressed",
        "tests/mission/test_xml_schema.py::test_trang_makes_an_xsd_that_xerces_takes",
    ),
    "Qt": Row(
        {"Qt, PySide6": of_python("PySide6-Addons", "PySide6-Essentials")},
        "SCXML",
        "written",
        "what the runtime does, event by event",
        "its null data model, see below",
        draws=CONTROLLED,
        judge=by_interpreter("Qt", 60),
    ),
    "python-statemachine": Row(
        {"python-statemachine": of_python("python-statemachine")},
        "SCXML",
        "written",
        "what the runtime does, event by event",
        "timers, see below",
        draws=CONTROLLED,
        judge=by_interpreter("python-statemachine", 30),
    ),
    "SCION": Row(
        {"SCION, @scion-scxml/scxml": scion_version},
        "SCXML",
        "written",
        "what the runtime does, event by event",
        "from npm, which continuous integration does not have",
        draws=CONTROLLED,
        judge=by_interpreter("SCION", 60),
    ),
    "BehaviorTree.CPP": Row(
        {"BehaviorTree.CPP 4.8.2, behaviortreepy": of_python("behaviortreepy")},
        "trees",
        "read",
        "each run is one of the imported mission, tick by tick",
        "the ledger names what is approximated",
        draws=TREES,
        judge=by_library,
        of="trees",
    ),
    "py_trees": Row(
        {"py_trees": of_python("py_trees", "py-trees")},
        "trees",
        "read",
        "each run is one of the imported mission, tick by tick",
        "the ledger names what is approximated",
        draws=py_trees(),
        judge=by_py_trees,
        of="trees",
    ),
}
"""By name, in the order of the page."""
