"""Every answer about many missions and nets, to be compared after a change that must change none.

Usage: ``python experiments/faults/golden.py subjects SUBJECTS [--missions N] [--seed S]`` writes drawn
missions, the worked and the natural ones, and nets, as files; ``... answers SUBJECTS FOLDER [--seconds S]``
asks each command about each of them, with the code that Python finds; ``... compare FOLDER FOLDER`` says
where two such folders differ (exit code 1). Draw the subjects once, with the older code: strategies may draw
others later.

A command that takes longer than ``--seconds`` leaves no answer and is not compared; nor are seconds, versions
and folders. With the defaults answers take some twenty minutes of one core.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import signal
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT))

VOLATILE = {"seconds", "version", "memory", "digest", "nodes", "peak", "peak_nodes", "order", "generator"}
"""Keys of JSON objects whose values are no answers."""
TARGETS = ("json", "c", "python", "scxml", "btcpp", "ros2")
FORMS = ("hierarchical", "modular", "flat")
ENGINES = ("auto", "explicit", "symbolic", "local")
FORMULAS = (
    "AG EF (success | failure)",
    "EF failure",
    "AF success",
    "E[!failure U success]",
    "F (success | failure | abort)",
)
OF_MISSIONS = [
    *(("check", "--engine", engine, "--json") for engine in ENGINES),
    ("check", "--width", "100"),
    *(("causes", "--engine", engine, "--json", "--fmeca", "{out}/fmeca.csv") for engine in ENGINES),
    ("causes", "--rates", "--json"),
    ("causes", "--engine", "local", "--rates", "--json", "--openpsa", "{out}/openpsa.xml"),
    ("alternatives", "--json", "-o", "{out}/alternatives.json"),
    *(("ask", *FORMULAS, "--engine", engine, "--json") for engine in ENGINES),
    ("ask", *FORMULAS[:4], "--fair", "progress", "--json"),
    ("ask", "--json"),
    ("ask", "--robot-safety", "--json"),
    ("states", "--json", "--on", "markings"),
    ("convert", "{out}/net.json"),
    *(
        ("controller", "--form", f, "--target", t, "-o", "{out}/controller", "--json")
        for f in FORMS
        for t in TARGETS
    ),
    ("controller", "--form", "minimised", "-o", "{out}/controller", "--json"),
]
"""What is asked of each mission; ``{out}`` is a folder of its own, whose files are answers too."""
OF_NETS = [
    ("check", "--json"),
    ("check", "--structure", "--json"),
    ("states", "--json"),
    ("states", "--engine", "explicit", "--json"),
    *(("ask", "EF deadlock", "AG !deadlock", "F deadlock", "--engine", e, "--json") for e in ENGINES[:3]),
    *(
        ("ask", "--examination", e)
        for e in ("ReachabilityDeadlock", "OneSafe", "StableMarking", "QuasiLiveness")
    ),
    ("convert", "{out}/net.pnml"),
]
"""What is asked of each net."""


def subjects(folder: Path, number: int, seed: int) -> None:
    """Writes what is asked about."""
    from experiments.shared.drawing import drawn
    from mcpn.mission.writer import write_mission
    from mcpn.nets.formats.pnml_writer import write_pnml
    from mcpn.testing import nets
    from mcpn.testing.elements import MISSIONS
    from tests.answers.dense import any_missions

    folder.mkdir(parents=True)
    for i, mission in enumerate(drawn(MISSIONS, number, seed) + drawn(any_missions(), number // 4, seed)):
        (folder / f"drawn{i:03}.xml").write_bytes(write_mission(mission))
    for mission in sorted((ROOT / "experiments").glob("*/")):
        if list(mission.glob("*.xml")):
            shutil.copytree(mission, folder / mission.name, ignore=shutil.ignore_patterns("*.py", "*.toml"))
    shutil.copytree(
        ROOT / "tests" / "natural", folder / "natural", ignore=shutil.ignore_patterns("*.py", "__*")
    )
    for family in ("philosophers", "component_ring", "slotted_ring", "kanban", "fms", "queens"):
        for size in (2, 3, 4):
            (folder / f"{family}{size}.pnml").write_bytes(write_pnml(getattr(nets, family)(size)))


def ask(subject: Path, command: tuple[str, ...], folder: Path, seconds: int) -> None:
    """Asks one question in a process of its own: what it prints, its exit code and its files, or nothing."""
    folder.mkdir(parents=True, exist_ok=True)
    pid = os.fork()
    if pid == 0:
        from mcpn.cli.line import run

        signal.alarm(seconds)
        os.chdir(subject.parent)
        for number, name in ((1, "printed"), (2, "said")):
            os.dup2(os.open(folder / name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), number)
        name, *options = (word.format(out=folder) for word in command)
        code = run([name, subject.name, *options])
        (folder / "code").write_text(str(code))
        sys.stdout.flush()
        os._exit(0)
    _, status = os.waitpid(pid, 0)
    if status:
        shutil.rmtree(folder)


def asked(source: Path, folder: Path, seconds: int, subject: Path) -> None:
    """Asks everything about one subject."""
    into = folder / subject.relative_to(source).with_suffix("")
    for command in OF_NETS if subject.suffix == ".pnml" else OF_MISSIONS:
        words = "_".join(w.replace("{out}/", "") for w in command if w not in FORMULAS)
        ask(subject.resolve(), command, into.resolve() / re.sub(r"[^\w.-]", "_", words), seconds)


def answers(source: Path, folder: Path, seconds: int, jobs: int) -> None:
    """Asks everything about everything."""
    import mcpn.cli.line  # noqa: F401  (so that no child loads it anew)

    files = [p for p in sorted(source.rglob("*")) if p.suffix in (".xml", ".pnml")]
    subjects = [p for p in files if p.stem not in ("robot", "protocols", "package")]
    with ProcessPoolExecutor(jobs) as pool:
        list(pool.map(partial(asked, source, folder, seconds), subjects))


def plain(value: Any) -> Any:
    """A JSON value without what is no answer."""
    if isinstance(value, dict):
        return {key: plain(inner) for key, inner in value.items() if key not in VOLATILE}
    if isinstance(value, str):
        return re.sub(r"/\S+/", "", value)
    return [plain(inner) for inner in value] if isinstance(value, list) else value


def read(file: Path) -> Any:
    """What a file says, as a JSON value or as text without times and folders."""
    text = file.read_text()
    if text.startswith(("{", "[")):
        try:
            return plain(json.loads(text))
        except ValueError:
            pass
    inside = re.search(r'"""\s*(\{\s*"format".*?)"""', text, re.DOTALL)
    document = None if inside is None else plain(json.loads(inside[1]))
    text = text if inside is None else text.partition('"""{')[0]
    text = re.sub(r"\d+(\.\d+)? (s|ms|seconds)\b|/\S+/|TIME\S*|\d{4}-\d\d-\d\dT\S+", "", text)
    return [document, *text.splitlines()]


def difference(old: Any, new: Any, where: str = "") -> str | None:
    """The first place where two values differ; objects may have more keys than before."""
    if isinstance(old, dict) and isinstance(new, dict) and old.keys() <= new.keys():
        pairs = [(old[key], new[key], f"{where}.{key}") for key in old]
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        pairs = [(a, b, f"{where}[{i}]") for i, (a, b) in enumerate(zip(old, new, strict=True))]
    else:
        return None if old == new else f"{where}: {str(old)[:150]!r} -> {str(new)[:150]!r}"
    return next((found for pair in pairs if (found := difference(*pair))), None)


def differences(old: Path, new: Path) -> Iterator[str]:
    """Files that differ, each with the first place, of what both have answered in time."""
    for code in sorted(new.rglob("code")):
        other, folder = code.parent, old / code.parent.relative_to(new)
        if not (folder / "code").exists():
            print(f"{folder.relative_to(old)}: not answered in time by both", file=sys.stderr)
            continue
        names = {str(p.relative_to(f)) for f in (folder, other) for p in f.rglob("*") if p.is_file()}
        for name in sorted(names):
            both = folder / name, other / name
            missing = [str(f) for f in both if not f.exists()]
            found = f"only one has it; {missing}" if missing else difference(*map(read, both))
            if found:
                yield f"{folder.relative_to(old)}/{name} {found}"


def main() -> int:
    """Draws, asks or compares."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=("subjects", "answers", "compare"))
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--missions", type=int, default=60, help="how many are drawn (default 60)")
    parser.add_argument("--seed", type=int, default=1, help="which ones (default 1)")
    parser.add_argument("--seconds", type=int, default=20, help="for each question (default 20)")
    parser.add_argument("--jobs", type=int, default=2, help="processes (default 2)")
    given = parser.parse_args()
    if given.what == "subjects":
        subjects(given.folders[0], given.missions, given.seed)
    elif given.what == "answers":
        answers(*given.folders, given.seconds, given.jobs)
    else:
        found = list(differences(*given.folders))
        print(*found, f"{len(found)} differ", sep="\n")
        return 1 if found else 0
    return 0


if __name__ == "__main__":
    sys.exit(main())
