"""Drawn formulas: the verdicts of their monitors against LTL3 by its definition, on all short finite words.

Usage: ``python experiments/monitors.py [--formulas N] [--seed S]``

The definition (``tests/controller/ltl3.py``) looks at all endless words of eight letters, the last repeated.
Each formula is judged on the 85 words of up to four letters that begin with the empty one. With its defaults
it takes about a minute.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from pathlib import Path

from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import seed as seeded

sys.path.append(str(Path(__file__).resolve().parents[1]))

from tests.controller import ltl3


def main() -> int:
    """Judges formulas and says what was found."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--formulas", type=int, default=1200)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    found: Counter[str] = Counter()
    wrong: list[str] = []
    begun = time.perf_counter()

    @seeded(asked.seed)
    @settings(
        max_examples=asked.formulas,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(ltl3.formulas())
    def judge(text: str) -> None:
        expected = ltl3.by_definition(text)
        judged = set()
        for word, value in ltl3.by_monitor(text):
            if word not in judged:
                judged.add(word)
                found[value] += 1
                if value != expected[word]:
                    wrong.append(f"{text} on {word}: {value}, by definition {expected[word]}")
        found["formulas"] += 1

    judge()
    words = sum(found[value] for value in ("violated", "satisfied", "open"))
    print(f"{found['formulas']} formulas, {words} words, {time.perf_counter() - begun:.0f} s")
    print(", ".join(f"{found[value]} {value}" for value in ("violated", "satisfied", "open")))
    print(f"{len(wrong)} wrong")
    for line in wrong[:20]:
        print(line)
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
