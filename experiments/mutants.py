"""Changes mcpn at one place at a time and runs the tests of that place: which changes do they not notice?

Usage: ``python experiments/mutants.py [--number N] [--seed S] [--folder F ...] [--since REVISION|DATE]
[--seconds S] [--minutes M] [--list]``

Mutants are drawn so that each folder has its share of them. A mutant is run in a copy of the sources, with
the profile ``smoke`` and the tests of its area (:data:`AREAS`); the environment's own mcpn is not touched.
One line for each says ``killed``, ``timeout`` or ``survived``, the place and the change. A survivor may be
equivalent to the original, or change a message or speed alone: somebody must look at it. With its defaults it
takes up to half an hour; a mutant takes from seconds to two minutes.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import copy
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("mcpn/space", "mcpn/check", "mcpn/controller", "mcpn/runtime", "mcpn/mission")
COPIED = ("mcpn", "tests", "docs", "experiments", "papers", "kernel", "pyproject.toml", "README.md")
"""What the tests read; not the ``conftest.py`` beside them, which leads to the installed package."""

AREAS = {
    "mcpn": "tests/test_smoke.py tests/test_face.py tests/test_cli.py",
    "mcpn/mission": "tests/mission tests/test_language_page.py tests/judge",
    "mcpn/net": "tests/net tests/space/test_conformance.py tests/judge",
    "mcpn/net/reduce": "tests/net/test_reduce.py tests/space",
    "mcpn/space": "tests/space tests/check/test_engines.py",
    "mcpn/space/stable": "tests/space/test_confluence.py tests/space/test_alternatives.py tests/space",
    "mcpn/space/local": "tests/space/test_local.py tests/check/test_local.py tests/space tests/test_once.py",
    "mcpn/space/search": "tests/space/search tests/check/test_contest.py tests/check/test_properties.py",
    "mcpn/check": "tests/check",
    "mcpn/check/logic": "tests/check/test_language.py tests/check/test_ctl.py tests/check",
    "mcpn/controller": "tests/controller tests/test_once.py",
    "mcpn/runtime": "tests/controller/test_runtime.py tests/controller/test_sessions.py tests/controller",
    "mcpn/report": "tests/report tests/test_cli.py",
    "mcpn/cli": "tests/test_cli.py tests/test_cli_causes.py tests/test_cli_controllers.py",
}
"""The tests that should notice a change, by folder (the deepest that is listed), the likeliest first."""

ALONE = """import sys
sys.meta_path[:] = [f for f in sys.meta_path if type(f).__name__ != "ScikitBuildRedirectingFinder"]
"""
"""For Python's start in the copy: an editable install would lead back to the checkout."""


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
    """

    path: str
    line: int
    around: str
    start: int
    stop: int
    text: str

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
        self.lines = [0]
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
        for name, part in ast.iter_fields(node):
            if name in ("annotation", "returns", "decorator_list", "bases"):
                continue
            for child in part if isinstance(part, list) else [part]:
                if isinstance(child, ast.AST):
                    self.visit(child)
        if named:
            self.around.pop()

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
            made = Mutant(self.path, place.lineno, ".".join(self.around) or "-", start, stop, text)
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


def area(path: str, root: Path = ROOT) -> list[str]:
    """The files of tests of a file; those that name its module come first."""
    folders = [str(parent) for parent in Path(path).parents]
    listed = next(AREAS[folder] for folder in folders if folder in AREAS).split()
    each = [
        [root / name] if name.endswith(".py") else sorted((root / name).rglob("test_*.py")) for name in listed
    ]
    files = dict.fromkeys(file for some in each for file in some if file.exists())
    module = path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
    first = sorted(files, key=lambda file: f"{module} import" not in file.read_text())
    return [str(file.relative_to(root)) for file in first]


def copied(root: Path, to: Path) -> None:
    """Copies what the tests need, with the kernel that is installed, to a folder."""
    import mcpn._kernel

    ignored = shutil.ignore_patterns("__pycache__", "*.so")
    for name in COPIED:
        if (root / name).is_dir():
            shutil.copytree(root / name, to / name, ignore=ignored)
        elif (root / name).exists():
            shutil.copy(root / name, to / name)
    kernel = Path(mcpn._kernel.__file__)
    shutil.copy(kernel, to / "mcpn" / kernel.name)
    (to / "sitecustomize.py").write_text(ALONE)
    where = [sys.executable, "-c", "import mcpn._kernel; print(mcpn.__file__)"]
    found = subprocess.run(where, cwd=to, env=_environment(to), capture_output=True, text=True, check=True)
    if Path(found.stdout.strip()) != to / "mcpn" / "__init__.py":
        raise SystemExit(f"not the copy is tested, but {found.stdout}")


def _environment(folder: Path) -> dict[str, str]:
    changed = {"PYTHONPATH": str(folder), "HYPOTHESIS_PROFILE": "smoke", "PYTHONDONTWRITEBYTECODE": "1"}
    # The folders of files that some tests need stand beside the checkout.
    for variable, beside in (("MCPN_FAULTS", "faults"), ("MCPN_REFERENCE", "reference")):
        if (found := ROOT.parent / "shared" / beside).is_dir():
            changed[variable] = str(found)
    return {**os.environ, **changed}


def tested(folder: Path, tests: list[str], seconds: float) -> tuple[str, str]:
    """Runs tests in a copy until one fails: how that ended, and the end of the output."""
    command = [sys.executable, "-m", "pytest", "-q", "-x", "--tb=line", "-p", "no:cacheprovider"]
    command += ["-m", "not long and not slow", *tests]
    with tempfile.TemporaryFile("w+") as out:
        child = subprocess.Popen(
            command, cwd=folder, env=_environment(folder), stdout=out, stderr=out, start_new_session=True
        )
        try:
            code = child.wait(seconds)
        except subprocess.TimeoutExpired:
            return "timeout", ""
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(child.pid, signal.SIGKILL)
            child.wait()
        out.seek(0)
        return ("survived" if code == 0 else "killed"), out.read()[-2000:]


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
    parser.add_argument("--tests", action="append", help="run these instead of those of the area")
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
    end, counts, sound = time.monotonic() + 60 * asked.minutes, Counter[str](), set[str]()
    with tempfile.TemporaryDirectory(prefix="mutants") as name:
        folder = Path(name) / "source"
        folder.mkdir()
        copied(ROOT, folder)
        for mutant in chosen:
            if time.monotonic() > end:
                break
            tests = [*(asked.tests or area(mutant.path))]
            if not sound.issuperset(tests):  # tests that fail anyway kill nothing
                said, output = tested(folder, sorted(set(tests) - sound), 10 * asked.seconds)
                if said != "survived":
                    print(f"{output}\nwithout any change: {said}: {' '.join(tests)}", file=sys.stderr)
                    return 2
                sound |= set(tests)
            source = sources[mutant.path]
            (folder / mutant.path).write_bytes(mutant.applied(source))
            said, _ = tested(folder, tests, asked.seconds)
            (folder / mutant.path).write_bytes(source)
            counts[said] += 1
            print(f"{said} {mutant.told(source)}", flush=True)
    told = ", ".join(f"{counts[said]} {said}" for said in ("killed", "timeout", "survived"))
    print(f"{counts.total()} run: {told}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
