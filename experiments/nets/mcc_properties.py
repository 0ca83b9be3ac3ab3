"""Answers the properties of Model Checking Contest nets, and compares with the contest's verdicts.

Usage: ``python experiments/nets/mcc_properties.py FOLDER [NET...]`` with a folder that holds
``formulas.tsv``, ``formulas_ltl.tsv``, ``oracles.tsv`` and ``NAME/model.pnml``. Each file of properties has a
process, 60 s of CPU time (``--seconds``) and 4 GiB of its own; with ``--file together`` all files and
examinations of a net share one. It takes up to a minute of CPU time for each file of properties; nothing is
ended by the clock on the wall, so that what else the machine does changes no answer.
"""

from __future__ import annotations

import argparse
import csv
import multiprocessing
import platform
import resource
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import chain
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from mcpn import __version__

SECONDS, GIB = 60, 4
FILES = (
    "CTLFireability",
    "CTLCardinality",
    "ReachabilityFireability",
    "ReachabilityCardinality",
    "UpperBounds",
    "LTLFireability",
    "LTLCardinality",
)
TOGETHER = "together"
OF_NETS = ("examinations", TOGETHER)
EXAMINATIONS = {
    "ReachabilityDeadlock": "deadlock_exists",
    "QuasiLiveness": "quasi_live",
    "Liveness": "live",
    "OneSafe": "safe",
    "StableMarking": "stable_marking_exists",
}


@dataclass
class Run:
    """What one process has told, and what it took.

    Args:
        found: Answers by question.
        cpu: CPU seconds in all.
        until: CPU seconds until the last answer.
    """

    found: dict[str, str] = field(default_factory=dict)
    cpu: float = 0.0
    until: float = 0.0


def answer_questions(
    folder: Path,
    model: str,
    file: str,
    engine: str,
    limit: int,
    answers: Connection,
) -> None:
    """Answers one file, or the examinations, within CPU seconds; sends verdicts as they come."""
    from mcpn.errors import McpnError
    from mcpn.logic.answering import answer_all
    from mcpn.logic.contest import read_properties
    from mcpn.logic.questions import Questions
    from mcpn.nets.formats import read_net

    resource.setrlimit(resource.RLIMIT_AS, (GIB << 30, GIB << 30))
    resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))
    questions = Questions(read_net(folder / model / "model.pnml"), engine=engine)
    paths = [folder / model / f"{name}.xml" for name in (FILES if file == TOGETHER else (file,))]
    files = [read_properties(path, questions.names) for path in paths if path.exists()]
    with suppress(McpnError, MemoryError):
        for verdict in answer_all(
            questions, chain.from_iterable(files), EXAMINATIONS if file in OF_NETS else ()
        ):
            name = verdict.name.removeprefix(f"{questions.net.name}-")
            name = name if name in EXAMINATIONS else verdict.name
            answers.send((name, verdict.value, verdict.techniques, time.process_time()))


def run(
    folder: Path, model: str, file: str, used: Counter[str], engine: str = "auto", limit: int = SECONDS
) -> Run:
    """The answers that one process gives in its time; counts the techniques that they were had by."""
    before, told = cpu_of_children(), Run()
    for name, value, techniques, told.until in told_by(answer_questions, folder, model, file, engine, limit):
        told.found[name] = value
        used.update(["+".join(techniques)])
    told.cpu = cpu_of_children() - before
    return told


def told_by(work: Callable[..., None], *asked: object) -> Iterator[Any]:
    """What a process sends until it ends, by itself or by its limit; its work is given the pipe last."""
    answers, theirs = multiprocessing.Pipe(duplex=False)
    process = multiprocessing.Process(target=work, args=(*asked, theirs))
    process.start()
    theirs.close()  # so that its end is seen here
    with suppress(EOFError):
        while True:
            yield answers.recv()
    process.join()


def cpu_of_children() -> float:
    """CPU seconds of the processes that have ended."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def examined(row: dict[str, str]) -> dict[str, str]:
    """The verdicts on a net that need no formula."""
    wanted = {name: row[column] for name, column in EXAMINATIONS.items() if row[column] != "?"}
    return wanted | {"OneSafe": str(row["safe"] == "1-safe").upper()}


def main() -> None:
    """Prints a row for each net and each file that is not all answered, and the totals."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("nets", nargs="*")
    parser.add_argument(
        "--file",
        action="append",
        help="only this file, or 'examinations', or all 'together' in one process; may be repeated",
    )
    parser.add_argument("--seconds", type=int, default=SECONDS, help="of CPU time for each process")
    parser.add_argument("--engine", default="auto", help="who answers: auto, search, explicit or symbolic")
    parser.add_argument("--all", action="store_true", help="a row for every file")
    arguments = parser.parse_args()
    folder: Path = arguments.folder
    with (folder / "oracles.tsv").open(newline="") as file:
        oracles = {row["model"]: row for row in csv.DictReader(file, delimiter="\t")}
    expected: dict[tuple[str, str], dict[str, str]] = {}
    for name in ("formulas.tsv", "formulas_ltl.tsv"):
        with (folder / name).open(newline="") as file:
            for row in csv.DictReader(file, delimiter="\t"):
                if row["verdict"] != "?":
                    asked = expected.setdefault((row["model"], row["examination"]), {})
                    asked[row["formula"]] = row["verdict"]
    machine = f"{platform.machine()}, Python {platform.python_version()}, mcpn {__version__}"
    print(f"{machine}; {arguments.seconds} s of CPU time and {GIB} GiB a file")
    totals: Counter[str] = Counter()
    used: Counter[str] = Counter()
    cpu = until = 0.0
    for model in arguments.nets or sorted(oracles):
        for kind in arguments.file or (*FILES, "examinations"):
            wanted = examined(oracles[model]) if kind in OF_NETS else {}
            for name in FILES if kind == TOGETHER else (kind,):
                wanted |= expected.get((model, name), {})
            if not wanted:
                continue
            told = run(folder, model, kind, used, arguments.engine, arguments.seconds)
            wrong = [name for name in wanted if name in told.found and told.found[name] != wanted[name]]
            missing = [name for name in wanted if name not in told.found]
            totals.update(asked=len(wanted), wrong=len(wrong), missing=len(missing))
            cpu, until = cpu + told.cpu, until + told.until
            if wrong or missing or told.cpu > 10 or arguments.all:
                row = f"{model:30} {kind:24} {told.cpu:6.2f} s CPU, {told.until:6.2f} s until the last answer"
                row += f"  wrong: {' '.join(wrong)}" if wrong else ""
                row += f"  not answered: {' '.join(missing)}" if missing else ""
                print(row, flush=True)
    for technique, count in used.most_common():
        print(f"{count:5} by {technique}")
    answered = totals["asked"] - totals["missing"]
    share = 100 * answered / totals["asked"]
    print(f"{answered} of {totals['asked']} answered ({share:.1f} %), {totals['wrong']} wrong")
    print(f"{cpu:.1f} s of CPU, {until:.1f} s of it until the last answer of each process")


if __name__ == "__main__":
    main()
