"""Faults seeded in mcpn itself: of which are its certificates refuted, though mcpn is sure?

Run: python experiments/faults/seeded_faults.py [WORDS...] (some four minutes)

Each fault of ``seeded_list.py`` replaces one text in a copy of the package; a text that does not stand there
exactly once ends the script. A process of its own answers the fault's questions with that copy, writes
certificates and has them checked; answers are compared with those of the unchanged package. *Refuted* means
that a program refutes a claim of a certificate; *not proved* that a claim of an unchanged one is proved no
more; *not written* that mcpn ends with an error as it writes the certificate; *contradicted* that an interval
that is proved does not hold the number that is said; *mcpn stops* that it gives no answer. What is *unseen*
has changed an answer and nothing else. A fault that changes a net alone, and no answer, may be refuted.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

sys.path.append(str(Path(__file__).resolve().parents[2]))

import mcpn
from experiments.faults.seeded_list import FAULTS, Seeded
from experiments.faults.seeded_missions import Answered, answered

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = Path(mcpn.__file__).parent
SECONDS = 240
"""For all questions of one fault."""
HOW = ("refuted", "not proved", "not written", "contradicted", "mcpn stops", "unseen")


class Outcome(NamedTuple):
    """What became of one fault.

    Args:
        how: One of ``HOW``, or ``same``.
        by: What notices it.
        shown: The first question that shows it.
        answers: Whether some answer is another one than without it, or is not there.
    """

    how: str
    by: str
    shown: str
    answers: bool


def changed(fault: Seeded, package: Path) -> str:
    """The text of a file with the fault in it.

    Args:
        fault: The fault.
        package: Where mcpn lies.

    Raises:
        ValueError: What it replaces does not stand there exactly once.
    """
    text = (package / fault.path).read_text(encoding="utf-8")
    if (times := text.count(fault.old)) != 1:
        raise ValueError(f"{fault.name}: {fault.path} has {times} times {fault.old!r}, expected once")
    return text.replace(fault.old, fault.new)


@contextmanager
def seeded(faults: Sequence[Seeded]) -> Iterator[Path]:
    """A folder with a copy of mcpn that has some faults."""
    with tempfile.TemporaryDirectory() as folder:
        package = Path(folder, "mcpn")
        shutil.copytree(PACKAGE, package, ignore=shutil.ignore_patterns("__pycache__"))
        for fault in faults:
            (package / fault.path).write_text(changed(fault, package), encoding="utf-8")
        (Path(folder) / "experiments").symlink_to(ROOT / "experiments")
        yield Path(folder)


def answers(faults: Sequence[Seeded], asks: Sequence[str]) -> dict[str, Answered]:
    """What mcpn with some faults and its checkers say to questions, by question."""
    with seeded(faults) as folder:
        run = subprocess.run(
            [sys.executable, "-m", "experiments.faults.seeded_faults", "--answer", *asks],
            cwd=folder,
            env={**os.environ, "PYTHONPATH": str(folder)},
            capture_output=True,
            text=True,
            check=False,
            timeout=SECONDS,
        )
    found = {asked: Answered(stopped="no answer at all") for asked in asks}
    for line in run.stdout.splitlines():
        asked, row = json.loads(line)
        found[asked] = Answered(*row)
    return found


def compared(right: Answered, wrong: Answered) -> tuple[str, str]:
    """How a fault is noticed in one answer, and by what."""
    if right.said == wrong.said and wrong.found == right.found and not wrong.stopped:
        return "same", ""
    if refuted := [how for how in wrong.found.values() if how.startswith("refuted")]:
        return "refuted", refuted[0].removeprefix("refuted by ")
    less = [key for key, how in right.found.items() if how.startswith("proved") and key in wrong.found]
    if less := [wrong.found[key] for key in less if not wrong.found[key].startswith("proved")]:
        return "not proved", less[0].rpartition(" ")[2]
    if wrong.stopped:
        written = wrong.stopped.startswith("no certificate")
        return ("not written" if written else "mcpn stops"), wrong.stopped
    for end, (low, high) in wrong.intervals.items():
        if not float(low) - 1e-9 <= wrong.said[0][end] <= float(high) + 1e-9:
            return "contradicted", f"{end}: {wrong.said[0][end]:.6f} is not in {low} to {high}"
    return ("unseen", "") if right.said != wrong.said else ("same", "")


def outcome(fault: Seeded, right: dict[str, Answered]) -> Outcome:
    """What becomes of a fault: what notices it in some answer, else in none."""
    try:
        wrong = answers([fault], fault.asks)
    except subprocess.TimeoutExpired:
        return Outcome("mcpn stops", f"no answer in {SECONDS} s", fault.asks[0], answers=True)
    other = any(wrong[asked].stopped or wrong[asked].said != right[asked].said for asked in fault.asks)
    each = [Outcome(*compared(right[asked], wrong[asked]), asked, other) for asked in fault.asks]
    return min(each, key=lambda one: (*HOW, "same").index(one.how))


def table(rows: Sequence[tuple[Seeded, Outcome]]) -> str:
    """The outcomes by area."""
    lines = [f"| area | seeded | changed an answer | {' | '.join(HOW)} |", f"|{'---|' * (3 + len(HOW))}"]
    areas = dict.fromkeys(fault.area for fault, _ in rows)
    for area in (*areas, "all"):
        counts = Counter(found.how for fault, found in rows if area in ("all", fault.area))
        every = sum(counts.values())
        other = sum(found.answers for fault, found in rows if area in ("all", fault.area))
        cells = [every, other, *(counts[how] for how in HOW)]
        lines.append(f"| {area} | {' | '.join(map(str, cells))} |")
    return "\n".join(lines)


def main() -> None:
    """Prints a row for each fault, then the table by area."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("words", nargs="*", help="words of the names of faults")
    parser.add_argument("--answer", nargs="+", help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.answer:
        for one in asked.answer:
            print(json.dumps([one, answered(one)], default=dict), flush=True)
        return
    faults = [f for f in FAULTS if not asked.words or any(word in f.name for word in asked.words)]
    for fault in faults:
        changed(fault, PACKAGE)
    right = answers([], [*dict.fromkeys(one for fault in faults for one in fault.asks)])
    rows = list[tuple[Seeded, Outcome]]()
    print("| area | what is wrong | outcome | by | shown by |\n|---|---|---|---|---|")
    for fault in faults:
        rows.append((fault, found := outcome(fault, right)))
        print(f"| {fault.area} | {fault.wrong} | {' | '.join(found[:3])} |", flush=True)
    print(f"\n{table(rows)}")


if __name__ == "__main__":
    main()
