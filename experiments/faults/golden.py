"""Every answer about many missions and nets, to be compared after a change that must change none.

Usage: ``python experiments/faults/golden.py subjects SUBJECTS [--missions N] [--nets N] [--seed S]`` writes
drawn missions, the worked and the natural ones, and nets, as files; ``... answers SUBJECTS FOLDER
[--seconds S]`` asks each command about each of them, with the code that Python finds, and goes on where it
was stopped; ``... compare SUBJECTS FOLDER FOLDER`` says where two such folders differ (exit code 1). Draw the
subjects once, with the older code, and keep all three folders outside the checkout: strategies may draw
others later. Older code answers by this file too: ``PYTHONPATH=OLD python .../golden.py answers ...``.

What is compared by text: exit codes, what is printed, JSON (all its places, numbers to 1e-9; objects may have
more keys than before), tables row by row. By meaning: controllers, which are played on the same random events
in every form, in C, Python and the runtime (``golden_play.py``; numbers of states may change); fault trees,
by the minimal sets of their gates (``golden_trees.py``); sentences and names that are others now. Those, and
the places that differ on purpose, stand in ``golden_purpose.toml``, each with the words of the changelog that
say so. A command that takes more CPU seconds than ``--seconds`` leaves no answer and is not compared; nor
are seconds, versions and folders. With the defaults answers take two hours of one core, comparing half an
hour.
"""

from __future__ import annotations

import argparse
import io
import os
import re
import resource
import shutil
import signal
import sys
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from contextlib import redirect_stdout, suppress
from functools import partial
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT))

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


def subjects(folder: Path, number: int, seed: int, of_nets: int) -> None:
    """Writes what is asked about: drawn missions, a fifth of them small and dense, and the others."""
    from experiments.shared.drawing import drawn
    from mcpn.mission.writer import write_mission
    from mcpn.nets.formats.pnml_writer import write_pnml
    from mcpn.testing import nets
    from mcpn.testing.elements import MISSIONS
    from tests.answers.dense import any_missions
    from tests.nets.nets import safe_ish_nets, token_nets

    folder.mkdir(parents=True)
    dense = number // 5
    found = drawn(MISSIONS, number - dense, seed) + drawn(any_missions(), dense, seed)
    for i, mission in enumerate(found):
        (folder / f"drawn{i:03}.xml").write_bytes(write_mission(mission))
    for worked in sorted((ROOT / "experiments").glob("*/")):
        if list(worked.glob("*.xml")):
            shutil.copytree(worked, folder / worked.name, ignore=shutil.ignore_patterns("*.py", "*.toml"))
    shutil.copytree(
        ROOT / "tests" / "natural", folder / "natural", ignore=shutil.ignore_patterns("*.py", "__*")
    )
    for family in ("philosophers", "component_ring", "slotted_ring", "kanban", "fms", "queens"):
        for size in (2, 3, 4):
            (folder / f"{family}{size}.pnml").write_bytes(write_pnml(getattr(nets, family)(size)))
    half = of_nets // 2
    for i, net in enumerate(drawn(safe_ish_nets(), half, seed) + drawn(token_nets(), of_nets - half, seed)):
        (folder / f"net{i:03}.pnml").write_bytes(write_pnml(net))


def ask(subject: Path, command: tuple[str, ...], folder: Path, seconds: int) -> None:
    """Asks one question in a process of its own: what it prints, its exit code and its files, or nothing."""
    folder.mkdir(parents=True, exist_ok=True)
    pid = os.fork()
    if pid == 0:
        from mcpn.cli.line import run

        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
        signal.alarm(10 * seconds)
        os.chdir(subject.parent)
        for number, name in ((1, "printed"), (2, "said")):
            os.dup2(os.open(folder / name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), number)
        sys.stdout, sys.stderr = (os.fdopen(n, "w", encoding="utf-8", closefd=False) for n in (1, 2))
        name, *options = (word.format(out=folder) for word in command)
        code = run([name, subject.name, *options])
        sys.stdout.flush()
        sys.stderr.flush()
        (folder / "code").write_text(str(code))
        os._exit(0)
    _, status = os.waitpid(pid, 0)
    if status:
        shutil.rmtree(folder)


def unverified() -> tuple[str, ...]:
    """What makes ``controller`` write one for a mission that fails its checks too, as older code does."""
    said = io.StringIO()
    with redirect_stdout(said), suppress(SystemExit):
        from mcpn.cli.line import run

        run(["controller", "--help"])
    return ("--unverified",) if "--unverified" in said.getvalue() else ()


def asked(source: Path, folder: Path, seconds: int, subject: Path) -> None:
    """Asks everything about one subject that it has not been asked."""
    into, more = folder / subject.relative_to(source).with_suffix(""), unverified()
    for command in OF_NETS if subject.suffix == ".pnml" else OF_MISSIONS:
        words = "_".join(w.replace("{out}/", "") for w in command if w not in FORMULAS)
        answer = into.resolve() / re.sub(r"[^\w.-]", "_", words)
        late = answer.with_name(f"{answer.name}.late")
        if (answer / "code").exists() or late.exists():
            continue
        ask(subject.resolve(), (*command, *more) if command[0] == "controller" else command, answer, seconds)
        if not answer.exists():
            late.touch()


def answers(source: Path, folder: Path, seconds: int, jobs: int) -> None:
    """Asks everything about everything."""
    import mcpn.cli.line  # noqa: F401  (so that no child loads it anew)

    with ProcessPoolExecutor(jobs) as pool:
        list(pool.map(partial(asked, source, folder, seconds), asked_of(source)))


def asked_of(source: Path) -> list[Path]:
    """The missions and nets of a folder of subjects."""
    files = [p for p in sorted(source.rglob("*")) if p.suffix in (".xml", ".pnml")]
    return [p for p in files if p.stem not in ("robot", "protocols", "package")]


def compare(source: Path, old: Path, new: Path) -> bool:
    """Prints where two folders of answers differ, by place; whether one does for no reason."""
    from experiments.faults.golden_meaning import Difference, expected, of_answers
    from experiments.faults.golden_play import of_controllers

    renamed, purposes = expected()
    counted, meant = Counter[str](), Counter[str]()
    open_: dict[str, list[Difference]] = {}
    for file in asked_of(source):
        subject = file.relative_to(source).with_suffix("")
        for code in sorted((old / subject).glob("*/code")):
            before, now = code.parent, new / subject / code.parent.name
            if not (now / "code").exists():
                counted["not answered by both"] += 1
                continue
            found = [*of_answers(before, now, str(subject), renamed)]
            pages = [next((p.page for p in purposes if p.holds(each)), "") for each in found]
            meant.update(filter(None, pages))
            for each in (each for each, page in zip(found, pages, strict=True) if not page):
                open_.setdefault(each.kind, []).append(each)
            counted["open" if not all(pages) else "differ on purpose" if pages else "equal"] += 1
        for _, wrong in of_controllers(old / subject, new / subject, str(subject), renamed):
            counted["controllers alike" if wrong is None else "controllers open"] += 1
            if wrong is not None:
                open_.setdefault(wrong.kind, []).append(wrong)
    for page, number in meant.most_common():
        print(f"{number} places: {page}")
    for found in sorted(open_.values(), key=len, reverse=True):
        print(f"{len(found)} open: {found[0]}")
    print(", ".join(f"{number} {what}" for what, number in counted.most_common()))
    return bool(open_)


def main() -> int:
    """Draws, asks or compares."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=("subjects", "answers", "compare"))
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--missions", type=int, default=300, help="how many are drawn (default 300)")
    parser.add_argument("--nets", type=int, default=82, help="how many are drawn (default 82)")
    parser.add_argument("--seed", type=int, default=1, help="which ones (default 1)")
    parser.add_argument("--seconds", type=int, default=20, help="of CPU for each question (default 20)")
    parser.add_argument("--jobs", type=int, default=2, help="processes (default 2)")
    given = parser.parse_args()
    expected = {"subjects": 1, "answers": 2, "compare": 3}[given.what]
    if len(given.folders) != expected:
        parser.error(f"{given.what}: expected {expected} folders, found {len(given.folders)}")
    if given.what == "subjects":
        subjects(given.folders[0], given.missions, given.seed, given.nets)
    elif given.what == "answers":
        answers(given.folders[0], given.folders[1], given.seconds, given.jobs)
    else:
        return int(compare(*given.folders))
    return 0


if __name__ == "__main__":
    sys.exit(main())
