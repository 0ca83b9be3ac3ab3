"""Answers the properties of Model Checking Contest nets, and compares with the contest's verdicts.

Usage: ``python experiments/mcc_properties.py FOLDER [NET...]`` with a folder that holds ``formulas.tsv``,
``oracles.tsv`` and ``NAME/model.pnml``. Each file of properties has a process, 60 s and 4 GiB of its own. Its
properties are tried under growing limits of time, so that one hard formula does not cost the easy ones.
"""

from __future__ import annotations

import argparse
import csv
import multiprocessing
import platform
import resource
import time
from collections import Counter
from contextlib import suppress
from pathlib import Path

from mcpn import __version__

SECONDS, GIB = 60, 4
FILES = (
    "CTLFireability",
    "CTLCardinality",
    "ReachabilityFireability",
    "ReachabilityCardinality",
    "UpperBounds",
)
EXAMINATIONS = {
    "ReachabilityDeadlock": "deadlock_exists",
    "QuasiLiveness": "quasi_live",
    "Liveness": "live",
    "OneSafe": "safe",
    "StableMarking": "stable_marking_exists",
}


class TooLong(Exception):
    """A property has had its time."""


def answer_file(folder: Path, model: str, file: str, answers: multiprocessing.SimpleQueue) -> None:
    """Answers one file, or the examinations; puts pairs of name and answer as they come."""
    from mcpn.check.logic.contest import read_properties
    from mcpn.check.logic.questions import Questions
    from mcpn.errors import McpnError, UnsafeError
    from mcpn.net.formats import read_net

    resource.setrlimit(resource.RLIMIT_AS, (GIB << 30, GIB << 30))
    questions = Questions(read_net(folder / model / "model.pnml"))
    if file == "examinations":
        for name in EXAMINATIONS:
            with suppress(UnsafeError):
                answers.put((name, questions.examination(name)))
        return
    try:
        store = questions.space.encoding.store
    except McpnError:
        return
    waiting, limit = read_properties(folder / model / f"{file}.xml"), 1.5
    while waiting:
        later = []
        for asked in waiting:
            until = time.monotonic() + limit

            def watch(_: int, until: float = until) -> None:
                if time.monotonic() > until:
                    raise TooLong

            store.progress = watch
            try:
                answers.put((asked.name, questions.property(asked)))
            except (TooLong, MemoryError):
                later.append(asked)
        waiting, limit = later, limit * 4


def run(folder: Path, model: str, file: str) -> dict[str, str]:
    """The answers that one process gives in its time."""
    answers: multiprocessing.SimpleQueue = multiprocessing.SimpleQueue()
    process = multiprocessing.Process(target=answer_file, args=(folder, model, file, answers))
    process.start()
    process.join(SECONDS)
    if process.is_alive():
        process.kill()
        process.join()
    found = {}
    while not answers.empty():
        name, answer = answers.get()
        found[name] = answer
    return found


def examined(row: dict[str, str]) -> dict[str, str]:
    """The verdicts on a net that need no formula; of nets that are not 1-safe only that they are not."""
    safe = row["safe"] == "1-safe"
    wanted = {name: row[column] for name, column in EXAMINATIONS.items() if safe and row[column] != "?"}
    return wanted | {"OneSafe": str(safe).upper()}


def main() -> None:
    """Prints a row for each net and each file that is not all answered, and the totals."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("nets", nargs="*")
    arguments = parser.parse_args()
    folder: Path = arguments.folder
    with (folder / "oracles.tsv").open(newline="") as file:
        oracles = {row["model"]: row for row in csv.DictReader(file, delimiter="\t")}
    expected: dict[tuple[str, str], dict[str, str]] = {}
    with (folder / "formulas.tsv").open(newline="") as file:
        for row in csv.DictReader(file, delimiter="\t"):
            if row["verdict"] != "?":
                expected.setdefault((row["model"], row["examination"]), {})[row["formula"]] = row["verdict"]
    machine = f"{platform.machine()}, Python {platform.python_version()}, mcpn {__version__}"
    print(f"{machine}; {SECONDS} s and {GIB} GiB a file")
    totals: Counter[str] = Counter()
    for model in arguments.nets or sorted(oracles):
        for kind in (*FILES, "examinations"):
            if kind == "examinations":
                wanted = examined(oracles[model])
            else:
                wanted = expected.get((model, kind), {}) if oracles[model]["safe"] == "1-safe" else {}
            if not wanted:
                continue
            started = time.perf_counter()
            found = run(folder, model, kind)
            seconds = time.perf_counter() - started
            wrong = [name for name in wanted if name in found and found[name] != wanted[name]]
            missing = [name for name in wanted if name not in found]
            totals.update(asked=len(wanted), wrong=len(wrong), missing=len(missing))
            if wrong or missing or seconds > 10:
                told = f"  wrong: {' '.join(wrong)}" if wrong else ""
                told += f"  not answered: {' '.join(missing)}" if missing else ""
                print(f"{model:30} {kind:24} {seconds:6.1f} s{told}", flush=True)
    answered = totals["asked"] - totals["missing"]
    share = 100 * answered / totals["asked"]
    print(f"{answered} of {totals['asked']} answered ({share:.1f} %), {totals['wrong']} wrong")


if __name__ == "__main__":
    main()
