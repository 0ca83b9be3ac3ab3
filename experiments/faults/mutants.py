"""Changes mcpn at one place at a time and runs the tests of that place: which changes do they not notice?

Usage: ``python experiments/faults/mutants.py [--number N] [--seed S] [--folder F ...] [--since REVISION|DATE]
[--seconds S] [--minutes M] [--tests FILE ...] [--why] [--list]``

Mutants are drawn so that each folder has its share of them. Tests run in a copy of the sources, with the
profile ``smoke``; the environment's own mcpn is not touched. First the tests of the areas of what is drawn
(:data:`AREAS`) run without any change; if one fails, nothing else is done. It is noted which functions each
test calls (``callers.py``), and a mutant is run with the tests that call what it changes, the shortest first,
until one fails. One line for each says ``killed``, ``timeout``, ``survived`` or, where no test calls the
function, ``not called``, with the place and the change. A survivor may be equivalent to the original, or
change a message or speed alone: somebody must look at it. With its defaults it takes up to half an hour, and
a few minutes before that; a mutant takes from seconds to two minutes.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import copy
import importlib.util
import json
import math
import multiprocessing
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import hypothesis.strategies  # noqa: F401 # once, for the processes that run tests
import lxml.etree  # noqa: F401
import pytest

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("mcpn/spaces", "mcpn/answers", "mcpn/controller", "mcpn/robot/runtime", "mcpn/mission")
COPIED = ("mcpn", "tests", "docs", "experiments", "papers", "kernel", "pyproject.toml", "README.md")
"""What the tests read; not the ``conftest.py`` beside them, which leads to the installed package."""

AREAS = {
    "mcpn": "tests/test_smoke.py tests/test_face.py tests/test_cli.py",
    "mcpn/mission": "tests/mission tests/test_language_page.py tests/judge",
    "mcpn/nets": "tests/nets tests/spaces/test_conformance.py tests/judge",
    "mcpn/nets/reduce": "tests/nets/test_reduce.py tests/spaces",
    "mcpn/spaces": "tests/spaces tests/answers/test_engines.py",
    "mcpn/spaces/stable": "tests/spaces/test_confluence.py tests/spaces/test_alternatives.py tests/spaces",
    "mcpn/drawing": "tests/drawing tests/composite/test_local.py tests/judge",
    "mcpn/composite": "tests/composite/test_local.py tests/spaces tests/test_once.py",
    "mcpn/spaces/search": "tests/spaces/search tests/logic/test_contest.py tests/logic/test_properties.py",
    "mcpn/answers": "tests/answers",
    "mcpn/logic": "tests/logic/test_syntax.py tests/logic/test_ctl.py tests/answers",
    "mcpn/controller": "tests/controller tests/test_once.py",
    "mcpn/robot/runtime": "tests/runtime tests/controller/test_runtime.py tests/controller",
    "mcpn/report": "tests/report tests/test_cli.py",
    "mcpn/cli": "tests/test_cli.py tests/test_cli_causes.py tests/test_cli_controllers.py",
}
"""The tests that should notice a change, by folder (the deepest that is listed)."""

ALONE = """import sys
sys.meta_path[:] = [f for f in sys.meta_path if type(f).__name__ != "ScikitBuildRedirectingFinder"]
"""
"""For Python's start in the copy: an editable install would lead back to the checkout."""

MOST_PAGES = 6 << 18
"""Pages of memory of a run: what never ends may grow."""

WHY = ("FAILED ", "ERROR ")
"""How the lines begin that say which test noticed."""


@dataclass(frozen=True)
class Mutant:
    """One change of one file.

    Args:
        path: The file, from the root of the checkout.
        line: Where.
        around: The function or class around it.
        start: The first byte that is replaced.
        stop: The byte behind the last.
        text: What stands there then.
        outside: Whether it is outside of functions.
    """

    path: str
    line: int
    around: str
    start: int
    stop: int
    text: str
    outside: bool = False

    def applied(self, source: bytes) -> bytes:
        """The file with the change."""
        return source[: self.start] + self.text.encode() + source[self.stop :]

    def told(self, source: bytes) -> str:
        """Place and change on one line."""
        before = " ".join(source[self.start : self.stop].decode().split())
        return f"{self.path}:{self.line} {self.around}: {before}  ->  {' '.join(self.text.split())}"


# --- what is changed -------------------------------------------------------------------------------------

_OTHER: dict[type[ast.AST], list[type[ast.AST]]] = {
    ast.Lt: [ast.LtE],
    ast.LtE: [ast.Lt],
    ast.Gt: [ast.GtE],
    ast.GtE: [ast.Gt],
    ast.Eq: [ast.NotEq],
    ast.NotEq: [ast.Eq],
    ast.In: [ast.NotIn],
    ast.NotIn: [ast.In],
    ast.Is: [ast.IsNot],
    ast.IsNot: [ast.Is],
    ast.And: [ast.Or],
    ast.Or: [ast.And],
    ast.Add: [ast.Sub],
    ast.Sub: [ast.Add],
    ast.Mult: [ast.Add],
    ast.BitOr: [ast.BitAnd],
    ast.BitAnd: [ast.BitOr],
    ast.LShift: [ast.RShift],
}
_CALLS = {"min": "max", "max": "min", "any": "all", "all": "any", "sorted": "list", "reversed": "list"}


def _changed(node: ast.AST, **parts: object) -> ast.AST:
    """A copy of a node with some parts replaced."""
    other = copy.copy(node)
    for name, part in parts.items():
        setattr(other, name, part)
    return other


def variants(node: ast.AST) -> Iterator[ast.AST]:
    """What may stand in place of a node."""
    match node:
        case ast.Compare(ops=[op]) if type(op) in _OTHER:
            yield from (_changed(node, ops=[other()]) for other in _OTHER[type(op)])
        case ast.BoolOp():
            yield _changed(node, op=_OTHER[type(node.op)][0]())
            for at in range(len(node.values)):
                rest = node.values[:at] + node.values[at + 1 :]
                yield rest[0] if len(rest) == 1 else _changed(node, values=rest)
        case ast.BinOp():
            yield from (_changed(node, op=other()) for other in _OTHER.get(type(node.op), ()))
            yield node.left
            if not isinstance(node.op, ast.Sub | ast.Mod):
                yield node.right
        case ast.UnaryOp(op=ast.Not() | ast.Invert()):
            yield node.operand
        case ast.IfExp():
            yield node.body
            yield node.orelse
        case ast.If() | ast.While():
            yield ast.Constant(False)
            if isinstance(node, ast.If):
                yield ast.Constant(True)
        case ast.Constant(value=bool(value)):
            yield ast.Constant(not value)
        case ast.Constant(value=int(value)):
            yield ast.Constant(value + 1)
        case ast.Call(func=ast.Name(id=name), args=[_, *_]) if name in _CALLS:
            yield _changed(node, func=ast.Name(_CALLS[name]))
        case ast.comprehension(ifs=[_, *_]):
            yield from (ast.Constant(True) for _ in node.ifs)
        case ast.Expr(value=ast.Call() | ast.Yield() | ast.YieldFrom()) | ast.AugAssign():
            yield ast.Pass()
        case ast.Continue() | ast.Break() | ast.Raise():
            yield ast.Pass()
        case ast.Return(value=ast.expr()) if not isinstance(node.value, ast.Constant | ast.JoinedStr):
            yield ast.Return(ast.Constant(None))


class _Sites(ast.NodeVisitor):
    """All mutants of a file: annotations, messages, docstrings and what is asserted stay as they are."""

    def __init__(self, path: str, source: bytes) -> None:
        self.path, self.found, self.around = path, list[Mutant](), list[str]()
        self.lines, self.functions = [0], 0
        for line in source.splitlines(keepends=True):
            self.lines.append(self.lines[-1] + len(line))

    def visit(self, node: ast.AST) -> None:
        if isinstance(node, ast.Assert | ast.JoinedStr | ast.Import | ast.ImportFrom):
            return
        for other in variants(node):
            self._add(node, other)
        if isinstance(node, ast.Raise) or self._messages(node):
            return
        named = isinstance(node, ast.FunctionDef | ast.ClassDef)
        self.around += [node.name] if named else []
        self.functions += isinstance(node, ast.FunctionDef)
        for name, part in ast.iter_fields(node):
            if name in ("annotation", "returns", "decorator_list", "bases"):
                continue
            for child in part if isinstance(part, list) else [part]:
                if isinstance(child, ast.AST):
                    self.visit(child)
        if named:
            self.around.pop()
            self.functions -= isinstance(node, ast.FunctionDef)

    def _messages(self, node: ast.AST) -> bool:
        match node:
            case ast.If(test=ast.Name(id="TYPE_CHECKING")) | ast.Expr(value=ast.Constant()):
                return True
            case ast.Expr(value=ast.Call(func=ast.Name(id="step"))):
                return True
        return False

    def _add(self, node: ast.AST, other: ast.AST) -> None:
        replaced: list[tuple[ast.AST, ast.AST]] = [(node, other)]
        if isinstance(node, ast.If | ast.While):
            replaced = [(node.test, other)]
        elif isinstance(node, ast.comprehension):
            replaced = [(test, other) for test in node.ifs]
        for place, new in replaced:
            start = self.lines[place.lineno - 1] + place.col_offset
            stop = self.lines[place.end_lineno - 1] + place.end_col_offset
            text = ast.unparse(new)
            text = f"({text})" if isinstance(place, ast.expr) and not isinstance(new, ast.Constant) else text
            around, outside = ".".join(self.around) or "-", not self.functions
            made = Mutant(self.path, place.lineno, around, start, stop, text, outside)
            if made not in self.found:
                self.found.append(made)


def mutants_of(path: str, source: bytes) -> list[Mutant]:
    """All mutants of a file that compile."""
    sites = _Sites(path, source)
    sites.visit(ast.parse(source))
    found = []
    for mutant in sites.found:
        with contextlib.suppress(SyntaxError):
            compile(mutant.applied(source), path, "exec")
            found.append(mutant)
    return found


# --- which are drawn -------------------------------------------------------------------------------------


def stratified(mutants: list[Mutant], seed: int) -> list[Mutant]:
    """Mutants in an order of which each beginning has of every folder about its share."""
    strata = defaultdict[str, list[Mutant]](list)
    for mutant in mutants:
        strata[str(Path(mutant.path).parent)].append(mutant)
    draw, placed = random.Random(seed), list[tuple[float, str, Mutant]]()
    for folder in sorted(strata):
        members, first = strata[folder], draw.random()
        draw.shuffle(members)
        placed += [((at + first) / len(members), folder, m) for at, m in enumerate(members)]
    return [m for _, _, m in sorted(placed, key=lambda one: one[:2])]


def files_since(since: str, root: Path = ROOT) -> list[str] | None:
    """Python files changed since a revision or a date and still there; ``None`` where git does not know."""
    git = ["git", "-C", str(root)]
    try:
        known = subprocess.run(
            [*git, "rev-parse", "-q", "--verify", f"{since}^{{commit}}"], capture_output=True
        )
        asked = ["diff", "--name-only", since] if known.returncode == 0 else _log(since)
        found = subprocess.run([*git, *asked], capture_output=True, text=True)
    except OSError:
        return None
    if found.returncode:
        return None
    return sorted({line for line in found.stdout.splitlines() if line and (root / line).is_file()})


def _log(since: str) -> list[str]:
    return ["log", f"--since={since}", "--name-only", "--format="]


# --- the run of one --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Test:
    """What a run of a test without any change showed.

    Args:
        name: As pytest calls it.
        seconds: How long it took, its calls noted.
        calls: By file, the functions of mcpn that it calls.
    """

    name: str
    seconds: float
    calls: Mapping[str, list[str]]


def noticing(mutant: Mutant, tests: Iterable[Test], seconds: float = math.inf) -> list[str]:
    """The tests that may notice a change: those that call what is changed.

    What is outside of functions, or is called when its file is imported, concerns all that call some function
    of the file.

    Args:
        mutant: The change.
        tests: What each test calls; the one without a name is the import of all of them.
        seconds: The shortest are taken until they took this long together; one at least.

    Returns:
        Their names, the files that take least first.
    """
    imported = any(not t.name and mutant.around in t.calls.get(mutant.path, ()) for t in tests)
    concerned = [
        test
        for test in tests
        if test.name
        and mutant.path in test.calls
        and (mutant.outside or imported or mutant.around in test.calls[mutant.path])
    ]
    files, spent = defaultdict[str, list[Test]](list), 0.0
    for test in sorted(concerned, key=lambda test: test.seconds):
        if spent and spent + test.seconds > seconds:
            break
        spent += test.seconds
        files[test.name.partition("::")[0]].append(test)
    ordered = sorted(files.values(), key=lambda some: sum(test.seconds for test in some))
    return [test.name for some in ordered for test in some]


def area(path: str, root: Path = ROOT) -> list[str]:
    """The files of tests that should notice changes of a file."""
    folders = [str(parent) for parent in Path(path).parents]
    listed = next(AREAS[folder] for folder in folders if folder in AREAS).split()
    each = [[root / name] if name.endswith(".py") else (root / name).rglob("test_*.py") for name in listed]
    return sorted({str(file.relative_to(root)) for files in each for file in files if file.exists()})


class Copy:
    """A copy of the sources with the kernel that is installed; tests run there, in processes of their own.

    Args:
        folder: An empty folder for it.
        root: The checkout.

    Raises:
        SystemExit: Python finds another mcpn there.
    """

    def __init__(self, folder: Path, root: Path = ROOT) -> None:
        self.folder = folder
        find = [sys.executable, "-c", "import mcpn._kernel; print(mcpn._kernel.__file__)"]
        kernel = Path(subprocess.check_output(find, cwd=folder, text=True).strip())
        ignored = shutil.ignore_patterns("__pycache__", "*.so")
        for name in COPIED:
            if (root / name).is_dir():
                shutil.copytree(root / name, folder / name, ignore=ignored)
            elif (root / name).exists():
                shutil.copy(root / name, folder / name)
        shutil.copy(kernel, folder / "mcpn" / kernel.name)
        (folder / "sitecustomize.py").write_text(ALONE)
        self.environment = {"PYTHONPATH": str(folder), "HYPOTHESIS_PROFILE": "smoke"}
        # The folders of files that some tests need are beside the checkout.
        for variable, beside in (("MCPN_FAULTS", "faults"), ("MCPN_REFERENCE", "reference")):
            if (found := root.parent / "shared" / beside).is_dir():
                self.environment[variable] = str(found)
        told = subprocess.check_output(find, cwd=folder, env={**os.environ, **self.environment}, text=True)
        if Path(told.strip()).parent != folder / "mcpn":
            raise SystemExit(f"not the copy is tested, but {told}")

    @contextlib.contextmanager
    def changed(self, mutant: Mutant) -> Iterator[None]:
        """The copy with a change. Bytecode goes: its time and size need not differ."""
        path = self.folder / mutant.path
        source, bytecode = path.read_bytes(), Path(importlib.util.cache_from_source(str(path)))
        bytecode.unlink(missing_ok=True)
        path.write_bytes(mutant.applied(source))
        try:
            yield
        finally:
            path.write_bytes(source)
            bytecode.unlink(missing_ok=True)

    def tested(self, tests: Iterable[str], seconds: float, *more: str) -> tuple[str, str]:
        """Runs tests until one fails.

        Returns:
            ``killed``, ``timeout`` or ``survived``, and the end of the output.
        """
        with tempfile.TemporaryFile("w+") as out:
            child = multiprocessing.get_context("fork").Process(target=self._run, args=(out, [*more, *tests]))
            child.start()
            end, held = time.monotonic() + seconds, Path(f"/proc/{child.pid}/statm")
            while child.is_alive() and time.monotonic() < end and _pages(held) <= MOST_PAGES:
                child.join(0.5)
            late = child.is_alive()
            with contextlib.suppress(ProcessLookupError):
                os.killpg(child.pid or 0, signal.SIGKILL)
            child.join()
            out.seek(0)
            said = "timeout" if late else "killed" if child.exitcode else "survived"
            return said, out.read()[-2000:]

    def _run(self, out: IO[str], arguments: list[str]) -> None:
        """What the process does; pytest and hypothesis are imported already, mcpn is not."""
        os.setsid()
        os.dup2(out.fileno(), 1)
        os.dup2(out.fileno(), 2)
        os.chdir(self.folder)
        os.environ |= self.environment
        exec(ALONE, {})
        sys.path.insert(0, str(self.folder))
        fixed = [
            "-q",
            "-x",
            "--tb=line",
            "--disable-warnings",
            "-p",
            "no:cacheprovider",
            "-n",
            "0",  # this very process has the mutant
            "-m",
            "not long and not slow",
        ]
        sys.exit(pytest.main([*fixed, *arguments]))

    def calls(self, tests: Iterable[str], seconds: float) -> list[Test] | str:
        """Runs files of tests without any change: what each test calls; or how they fail."""
        with tempfile.NamedTemporaryFile("r") as file:
            sys.path.append(str(Path(__file__).parent))
            said, output = self.tested(tests, seconds, "-p", "callers", "--callers", file.name)
            if said != "survived":
                return f"{output}\nwithout any change: {said}"
            return [Test(*json.loads(line)) for line in file]


def _pages(statm: Path) -> int:
    """Pages in memory of a process, 0 where the system does not say."""
    with contextlib.suppress(OSError):
        return int(statm.read_text().split()[1])
    return 0


def main() -> int:
    """Draws mutants, runs each, says which survive."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--number", type=int, default=100, help="how many mutants at most (default: 100)")
    parser.add_argument("--seed", type=int, default=random.randrange(1 << 32), help="of the draw (any)")
    parser.add_argument("--folder", action="append", help=f"files below it (default: {' '.join(FOLDERS)})")
    parser.add_argument("--since", help="only files that changed since a revision of git, or a date")
    parser.add_argument("--seconds", type=float, default=120, help="for each mutant (default: 120)")
    parser.add_argument("--minutes", type=float, default=30, help="for all of them (default: 30)")
    parser.add_argument("--tests", action="append", help="files of tests, instead of those of the area")
    parser.add_argument("--why", action="store_true", help="say which test noticed")
    parser.add_argument("--list", action="store_true", help="only say which mutants are drawn")
    asked = parser.parse_args()
    folders = [folder.rstrip("/") for folder in asked.folder or FOLDERS]
    paths = sorted(str(path.relative_to(ROOT)) for path in (ROOT / "mcpn").rglob("*.py"))
    paths = [p for p in paths if any(p == f or p.startswith(f"{f}/") for f in folders)]
    if asked.since is not None:
        changed = files_since(asked.since)
        if changed is None:
            print("git does not know what changed: mutants of all files are drawn", file=sys.stderr)
        else:
            paths = [path for path in paths if path in changed]
    sources = {path: (ROOT / path).read_bytes() for path in paths}
    every = [mutant for path, source in sources.items() for mutant in mutants_of(path, source)]
    chosen = stratified(every, asked.seed)[: asked.number]
    print(f"{len(chosen)} of {len(every)} mutants of {len(paths)} files, --seed {asked.seed}", flush=True)
    if asked.list:
        print("\n".join(mutant.told(sources[mutant.path]) for mutant in chosen))
        return 0
    counts = Counter[str]()
    with tempfile.TemporaryDirectory(prefix="mutants") as name:
        copy_of, tests = Copy(Path(name)), asked.tests
        files = tests or sorted({test for mutant in chosen for test in area(mutant.path)})
        known = copy_of.calls(files, 60 * asked.minutes)
        if isinstance(known, str):  # tests that fail anyway kill nothing
            print(known, file=sys.stderr)
            return 2
        print(f"{len(known) - 1} tests without any change: passed", flush=True)
        end = time.monotonic() + 60 * asked.minutes
        for mutant in chosen:
            if time.monotonic() > end:
                break
            told, said = mutant.told(sources[mutant.path]), "not called"
            if names := noticing(mutant, known, asked.seconds / 4):
                with copy_of.changed(mutant):
                    said, output = copy_of.tested(names, asked.seconds)
            counts[said] += 1
            print(f"{said} {told}", flush=True)
            if said == "killed" and asked.why:
                print(*[line for line in output.splitlines() if line.startswith(WHY)], sep="\n", flush=True)
    told = ", ".join(f"{counts[said]} {said}" for said in ("killed", "timeout", "survived", "not called"))
    print(f"{counts.total()} run: {told}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
