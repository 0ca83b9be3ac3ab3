"""The rules of the house: which way imports point, and what the command line's help may load."""

from __future__ import annotations

import ast
import re
import runpy
import subprocess
import sys
from functools import cache
from pathlib import Path

import networkx
import pytest

PACKAGE = Path(__file__).resolve().parents[1] / "mcpn"
BASE = (
    "errors",
    "_kernel",
    "files",
    "misread",
    "xmlio",
    "notebook",
    "records",
    "sentences",
    "declared",
    "version",
    "steps",
    "turns",
    "cluster",
    "workers",
    "events",
    "did_you_mean",
)
"""What both wings stand on."""
NETS = ("nets", "spaces", "logic")
"""The wing that knows no mission: nets, their spaces, temporal logic."""
# The way of the data; a room may import its own kind and what stands before it.
WAY = [
    *BASE,
    "robot",
    *NETS,
    "mission",
    "trees",
    "drawing",
    "composite",
    "answers",
    "controller",
    "certificates",
    "tree_tests",
    "findings",
    "report",
    "study",
    "testing",
    "pytest_plugin",
    "editor",
    "cli",
]
MODULES = sorted(PACKAGE.rglob("*.py"))
SOURCES = sorted((PACKAGE.parent / "kernel" / "src").rglob("*.[ch]pp"))
"""Of the kernel."""


@cache
def nodes(path: Path) -> tuple[ast.AST, ...]:
    """All that a module says, read once."""
    return tuple(ast.walk(ast.parse(path.read_text())))


@cache
def imported(path: Path) -> frozenset[str]:
    names = set()
    for node in nodes(path):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative imports hide the way"
            names.add(node.module or "")
    return frozenset(names)


def test_imports_only_point_backwards() -> None:
    wrong = []
    for path in MODULES:
        room = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
        ours = {name for name in imported(path) if name.startswith("mcpn.")}
        if room == "__init__":  # its imports are for type checkers alone; test_face.py: it loads nothing
            strangers = ours - {"mcpn.mission.xml", "mcpn.study", "mcpn.version"}
        else:
            assert room in WAY, f"{path} stands in no known room"
            strangers = {name for name in ours if WAY.index(name.split(".")[1]) > WAY.index(room)}
        wrong += [f"{path.relative_to(PACKAGE)} imports {name}" for name in sorted(strangers)]
    assert wrong == []


def test_rooms_do_not_import_each_other_in_circles() -> None:
    """At every depth: of two rooms side by side at most one imports the other, by however many between."""
    ways: networkx.DiGraph[tuple[str, ...]] = networkx.DiGraph()
    for path in MODULES:
        room = path.relative_to(PACKAGE).parent.parts
        for name in imported(path):
            if name.startswith("mcpn."):
                parts = tuple(name.split(".")[1:])
                target = parts if PACKAGE.joinpath(*parts).is_dir() else parts[:-1]
                apart = next((i for i, (a, b) in enumerate(zip(room, target, strict=False)) if a != b), None)
                if apart is not None:
                    ways.add_edge(room[: apart + 1], target[: apart + 1])
    assert [
        sorted(circle) for circle in networkx.strongly_connected_components(ways) if len(circle) > 1
    ] == []


def test_files_do_not_import_each_other_in_circles() -> None:
    """Not for types alone either: each file can be read after those that it imports."""
    files: networkx.DiGraph[str] = networkx.DiGraph()
    names = {".".join(("mcpn", *path.relative_to(PACKAGE).with_suffix("").parts)): path for path in MODULES}
    for name, path in names.items():
        for node in nodes(path):
            if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == "mcpn":
                whole = [f"{node.module}.{alias.name}" for alias in node.names]
                for target in (each if each in names else str(node.module) for each in whole):
                    files.add_edge(name, target if target in names else f"{target}.__init__")
    assert files.number_of_edges() > 1_000
    circles = networkx.strongly_connected_components(files)
    assert [sorted(circle) for circle in circles if len(circle) > 1] == []


def test_the_page_draws_the_imports() -> None:
    rooms = runpy.run_path(str(PACKAGE.parent / "docs" / "rooms.py"))
    page = (PACKAGE.parent / "docs" / "architecture.md").read_text()
    assert rooms["renewed"](page) == page, "run python docs/rooms.py"
    told = {*re.findall(r"`mcpn/(\w+)", page), "base"}
    assert {*rooms["graph"]()} - told == set(), "the page does not say what they hold"


def test_the_wing_of_nets_knows_no_mission() -> None:
    """Not where a question is asked, nor for types alone: what checks nets can be taken by itself."""
    strangers = {
        f"{path.relative_to(PACKAGE)} imports {name}"
        for path in MODULES
        if path.relative_to(PACKAGE).parts[0] in NETS
        for name in imported(path)
        if name.startswith("mcpn.") and name.split(".")[1] not in (*BASE, *NETS)
        if name != "mcpn.robot.runtime.shapes"  # what a JSON document must be, whatever it is of
    }
    assert strangers == set()


def test_the_wing_of_nets_has_no_word_of_missions() -> None:
    """Neither a name nor a text that is compared; kinds of elements and words of formulas have own files."""
    word = re.compile(r"mission|objective(?!_function)|hardware|(?<!re)activit|robot", re.IGNORECASE)
    said_in = {"nets/provenance.py", "spaces/formula_names.py", "logic/syntax.py"}
    wrong = set[str]()
    for path in MODULES:
        where = path.relative_to(PACKAGE)
        if where.parts[0] not in NETS or str(where) in said_in:
            continue
        for node in nodes(path):
            said = [getattr(node, name, None) for name in ("name", "id", "arg", "attr", "value")]
            texts = {each for each in said if isinstance(each, str) and each.isidentifier()}
            wrong |= {f"{where} says {each}" for each in texts if word.search(each)}
    assert wrong == set()


AS_WRITTEN = {
    "answers/claims/of_check.py": "what handlers lead to, for as_written.py",
    "answers/mission_names.py": "what a formula may say in place of an unknown name",
    "answers/verdicts/nominal.py": "what runs for others, for as_written.py",
    "answers/verdicts/unreachable.py": "what handlers lead to, for as_written.py",
    "drawing/compose.py": "the net of a mission has its author's mission for who shows it",
    "mission/static/warnings.py": "what pauses and recovers, and what is said of facts",
}
"""Who asks the author's mission though it stands behind the core mission, and what no core mission says."""


def test_the_core_mission_is_read_alone_where_nothing_is_said_of_an_authors_words() -> None:
    rooms = ("mission/static", "drawing", "composite", "answers", "controller", "certificates")
    written = re.compile(r"\b(mission_net|net|usage|spaces\.mission)\.mission\b")
    reading = {
        str(path.relative_to(PACKAGE))
        for path in MODULES
        if str(path.relative_to(PACKAGE)).startswith(rooms) and written.search(path.read_text())
    }
    assert reading == AS_WRITTEN.keys()


def test_targets_read_the_document_alone() -> None:
    """What a target needs of a mission stands in the document; it imports nothing of missions."""
    known = ("mcpn.robot.targets", "mcpn.robot.runtime", "mcpn.events", "mcpn.errors")
    strangers = {
        f"{path.relative_to(PACKAGE)} imports {name}"
        for path in (PACKAGE / "robot" / "targets").glob("*.py")
        for name in imported(path)
        if name.startswith("mcpn.") and not name.startswith(known)
    }
    assert strangers == set()


MOST_POSITIONS = 8
"""Arguments that a reader can still tell apart by their places."""


def test_many_arguments_go_by_their_names() -> None:
    wrong = [
        f"{path.relative_to(PACKAGE)}:{node.lineno} gives {len(node.args)} arguments by their places"
        for path in MODULES
        for node in nodes(path)
        if isinstance(node, ast.Call)
        and len(node.args) > MOST_POSITIONS
        and ast.unparse(node.func) != "st.one_of"  # whose arguments are alternatives
    ]
    assert wrong == []


def test_engines_are_named_in_one_place() -> None:
    """Elsewhere a name is that of ``spaces/engine_names.py``, not a text."""
    engines, wrong = {"explicit", "symbolic", "local"}, set[str]()
    for path in MODULES:
        if path.name == "engine_names.py":
            continue
        for node in nodes(path):
            if isinstance(node, ast.Constant) and node.value in engines:
                wrong.add(f"{path.relative_to(PACKAGE)}:{node.lineno} says {node.value!r}")
    assert wrong == set()


BUILDERS = {
    "by_reduction",
    "count",
    "count_markings",
    "direct",
    "explore",
    "explore_markings",
    "explore_tokens",
    "of_listing",
    "prove_confluent",
    "proved",
    "pyeda_reference",
    "reaching",
    "reaching_markings",
    "reach_markings",
}
"""Names of ``mcpn.spaces`` that build a space, or count one."""
COMPOSERS = {"composite_space", "local_graph"}
"""Names of ``mcpn.composite`` that do."""
SPACES = {"BitSpace", "CompositeSpace", "DiagramAlternatives", "DiagramMarkings"}
"""Classes of spaces over a whole net."""


def builders(path: Path) -> set[str]:
    """What a module outside of where spaces are defined takes from there to build them."""
    found = set[str]()
    for node in nodes(path):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(
            ("mcpn.spaces", "mcpn.composite")
        ):
            found |= {alias.name for alias in node.names} & (BUILDERS | COMPOSERS)
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            found |= {node.func.id} & SPACES
    return found


def test_engines_are_built_in_one_place() -> None:
    found = {
        str(path.relative_to(PACKAGE)): names
        for path in MODULES
        if (names := builders(path))
        and path.relative_to(PACKAGE).parts[0] != "composite"
        and not path.is_relative_to(PACKAGE / "spaces")
    } | {"spaces/registry.py": builders(PACKAGE / "spaces" / "registry.py")}
    assert found == {
        "spaces/registry.py": BUILDERS | SPACES - {"CompositeSpace"},
        "answers/spaces_by_engine.py": COMPOSERS,
    }


def test_modules_are_of_a_size_to_be_read() -> None:
    alone = PACKAGE / "certificates" / "certcheck.py"  # which stands in one file, wherever it is copied
    sizes = {path: len(path.read_text().splitlines()) for path in MODULES + SOURCES}
    assert [str(path) for path, lines in sizes.items() if lines > (700 if path == alone else 600)] == []


def test_no_file_and_no_class_is_several_joined_by_banners() -> None:
    banner = re.compile(r"^\s*(#|//) ?-{3,}", re.MULTILINE)
    scripts = (PACKAGE / "report" / "assets").glob("*.js")
    tests = PACKAGE.parent / "tests"
    files = [*MODULES, *SOURCES, *scripts, *tests.rglob("*.py"), *tests.rglob("*.[ch]pp")]
    assert [str(path) for path in files if banner.search(path.read_text())] == []


def test_no_two_classes_have_one_name() -> None:
    places: dict[str, list[str]] = {}
    for path in MODULES:
        for node in nodes(path):
            if isinstance(node, ast.ClassDef):
                places.setdefault(node.name, []).append(str(path.relative_to(PACKAGE)))
    assert {name: where for name, where in places.items() if len(where) > 1} == {}


def test_rooms_are_of_a_size_to_be_seen() -> None:
    """No folder has more than twenty modules side by side; in the kernel header and source are one."""
    rooms: dict[Path, set[str]] = {}
    for path in MODULES + SOURCES:
        rooms.setdefault(path.parent, set()).add(path.stem)
    assert [str(room) for room, modules in rooms.items() if len(modules - {"__init__"}) > 20] == []


def test_help_loads_nothing_heavy() -> None:
    heavy = {"numpy", "networkx", "lxml", "rich", "hypothesis", "scipy"}
    script = (
        "import sys\n"
        "from click.testing import CliRunner\n"
        "from mcpn.cli.line import command_line\n"
        "assert CliRunner().invoke(command_line, ['--help']).exit_code == 0\n"
        f"print(*sorted({heavy!r} & sys.modules.keys()))\n"
    )
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert run.stdout.split() == []


HEAVY = {
    "mcpn.certificates.certcheck",
    "numpy",
    "numpy.ma",
    "networkx",
    "scipy",
    "highspy",
    "lark",
    "rich",
    "hypothesis",
    "distributed",
    "matplotlib",
    "pyeda",
    "asyncio",
    "logging",
    "tempfile",
    "secrets",
    "mcpn.trees.ledger",
    "mcpn.spaces.diagrams.counters",
    "mcpn.spaces.markings.counted",
    "mcpn.spaces.markings.widths",
    "mcpn.spaces.search.portfolio",
    "mcpn.logic.contest",
}
TOKENS = {"mcpn.spaces.markings.counted", "mcpn.spaces.markings.widths"}
ARRAYS, FILES = {"numpy"}, {"tempfile"}
CONTEST = {"mcpn.logic.contest", "mcpn.spaces.search.portfolio"}
LOADS: dict[str, set[str]] = {
    "states --json": TOKENS,
    "states": TOKENS,
    "states --engine local": set(),
    "states --engine symbolic": set(),
    "states --engine explicit": TOKENS,
    "check": set(),
    "check --engine symbolic": set(),
    "check --engine local": set(),
    "alternatives": ARRAYS,
    "controller -o {folder}": ARRAYS | FILES,
    "convert {folder}/net.pnml": FILES,
    "ask AG(EF(success|failure))": ARRAYS,
    "ask --on markings AG(EF(success|failure))": set(),
    "ask --engine local AG(EF(success|failure))": set(),
    "ask --engine explicit AG(EF(success|failure))": ARRAYS,
    "causes --engine local": set(),
    "causes": ARRAYS,
}
"""What each command loads of the heavy modules, beside what makes a mission's net."""


LOADS_OF_NETS: dict[str, set[str]] = {
    "states": set(),
    "check": TOKENS | {"mcpn.spaces.search.portfolio"},
    "ask EF(deadlock)": {"mcpn.spaces.search.portfolio"},
    "ask AG(EF(b))": set(),
    "ask --examination StableMarking": TOKENS | CONTEST,
    "convert {folder}/net.pnml": FILES,
}
SHARED = {"line", "exit_codes", "options", "printed", "__init__", "__main__"}
COMMANDS = {path.stem for path in (PACKAGE / "cli").glob("*.py")} - SHARED
"""Modules of commands."""
NET = """pl a (1)
tr t a -> b
tr u b -> a
"""


OF_MISSIONS = tuple(f"mcpn.{room}." for room in ("mission", "drawing", "composite"))


def loaded(arguments: list[str]) -> set[str]:
    script = (
        "import sys\n"
        "from mcpn.cli.line import run\n"
        f"assert run({arguments!r}) in (0, 1)\n"
        f"heavy = {HEAVY!r}.union(m for m in sys.modules if m.startswith({OF_MISSIONS!r}))\n"
        "print('loaded', *sorted(heavy & sys.modules.keys()))\n"
    )
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return set(run.stdout.splitlines()[-1].split()[1:])


@pytest.mark.parametrize("command", LOADS)
def test_a_question_loads_what_it_needs(command: str, tmp_path: Path) -> None:
    mission = PACKAGE.parent / "experiments" / "ulysse" / "mission.xml"
    name, *options = command.format(folder=tmp_path).split()
    found = {m for m in loaded([name, str(mission), *options]) if not m.startswith(OF_MISSIONS)}
    assert found <= LOADS[command]


@pytest.mark.parametrize("command", LOADS_OF_NETS)
def test_a_question_of_a_net_loads_what_it_needs(command: str, tmp_path: Path) -> None:
    (tmp_path / "net.net").write_text(NET)
    name, *options = command.format(folder=tmp_path).split()
    found = loaded([name, str(tmp_path / "net.net"), *options])
    assert not [module for module in found if module.startswith(OF_MISSIONS)]
    assert found <= LOADS_OF_NETS[command]


@pytest.mark.parametrize(("arguments", "modules"), [("--version", set()), ("check --help", {"check"})])
def test_a_command_loads_no_other(arguments: str, modules: set[str]) -> None:
    script = (
        "import sys\n"
        "from mcpn.cli.line import run\n"
        f"assert run({arguments.split()!r}) == 0\n"
        "print('loaded', *(name.removeprefix('mcpn.cli.') for name in sys.modules))\n"
    )
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert COMMANDS.intersection(run.stdout.splitlines()[-1].split()) == modules
