"""What certificates of missions cost: claims, bytes, seconds to write and to check, by each checker.

Usage: ``certificate_costs.py [--missions NAME ...] [--seconds S] [--second CHECKER]``

The worked missions, those of ``tests/natural``, generated ones, and families (``share 4``, ``sites 1000``):
some have more states than are listed. ``check`` and ``causes`` each write a certificate; certcheck,
corecheck, furthercheck, diagcheck and sectioncheck read it, each for so many seconds at most, and the checker
in C++ where its program is named. A row that is refused says so; what is only trusted is counted. Seconds of
CPU of one process.
"""

from __future__ import annotations

import argparse
import platform
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2]))

from experiments.growth.growth import FAMILIES
from experiments.shared.missions import Parameters, generate
from mcpn.certificates import certcheck, corecheck, diagcheck, furthercheck
from mcpn.certificates.sections import sectioncheck
from mcpn.certificates.writing import Certificate, certificate_of, certificate_of_causes
from mcpn.errors import InputError, LimitError, SemanticsError
from mcpn.study import Study, open_study
from mcpn.version import VERSION

ROOT = Path(__file__).resolve().parents[1]
WORKED = {name: ROOT / name / "mission.xml" for name in ("ulysse", "courier", "drone", "glider", "rover")}
NATURAL = {f"natural {p.stem}": p for p in sorted((ROOT.parent / "tests/natural").glob("*.xml"))}
GROWING = ("share 4", "drivers 4", "data 8", "sites 5", "sites 1000", "sites 10000")
GENERATED = {
    f"generated, {sections} sections": Parameters(
        sections=sections, types=sections, hardware=hardware, per_section=3, alternatives=2, depth=1
    )
    for sections, hardware in ((3, 6), (6, 14))
}
HEAD = (
    "mission",
    "by",
    "proved",
    "refuted",
    "open",
    "trusted",
    "bytes",
    "asked",
    "written",
    "checked",
    "C++",
)


def timed(work: Callable[[], object]) -> tuple[float, object]:
    """The seconds that some work takes, and what it gives."""
    begun = time.process_time()
    found = work()
    return time.process_time() - begun, found


def studies(names: list[str]) -> Iterator[tuple[str, Study]]:
    """The missions, by name."""
    for name in names:
        if name in GENERATED:
            yield name, Study(generate(GENERATED[name], 1))
        elif name in {**WORKED, **NATURAL}:
            yield name, open_study({**WORKED, **NATURAL}[name])
        else:
            family, size = name.split()
            yield name, Study(FAMILIES[family][0](int(size)))


def certified(study: Study, by: str) -> tuple[float, float, Certificate]:
    """How long it takes to answer and to write, and the certificate."""
    if by == "check":
        asked, check = timed(study.verdicts)
        written, made = timed(lambda: certificate_of(study.verdicts()))
    else:
        asked, check = timed(study.causes)
        written, made = timed(lambda: _of_causes(study))
    assert isinstance(made, Certificate), f"of {check}"
    return asked, written, made


def _of_causes(study: Study) -> Certificate:
    try:
        return certificate_of_causes(study.causes(), chances=True)
    except InputError:  # it has no durations
        return certificate_of_causes(study.causes())


def row(study: Study, by: str, second: Path | None, seconds: float) -> list[str]:
    """One row of the table, but for the mission's name."""
    try:
        asked, written, made = certified(study, by)
    except (LimitError, SemanticsError) as error:
        return [by, f"refused: {error}"]
    data, report = made.to_bytes(), certcheck.Report()
    with tempfile.NamedTemporaryFile() as file:
        file.write(data)
        file.flush()
        begun = time.process_time()
        if made.net is None:
            report += sectioncheck.checked(file.name, seconds=seconds)
        elif made.diagrams is not None:
            report += diagcheck.checked(file.name, seconds=seconds)
        else:
            report += certcheck.checked(file.name, seconds=seconds) + corecheck.checked(
                file.name, seconds=seconds
            )
            report += furthercheck.checked(file.name, seconds=seconds) if made.further else []
        checked = time.process_time() - begun
        other = (
            "-"
            if second is None
            else f"{_seconds_of([str(second), file.name, '--seconds', str(seconds)]):.2f}"
        )
    counts = [sum(how == each for how, _, _ in report) for each in ("proved", "refuted", "not checked")]
    numbers = [*counts, len(made.trusted), len(data)]
    return [by, *map(str, numbers), f"{asked:.2f}", f"{written:.2f}", f"{checked:.2f}", other]


def _seconds_of(command: list[str]) -> float:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Prints the table that the command line asks for."""
    parser = argparse.ArgumentParser(description="What certificates of missions cost.")
    parser.add_argument("--missions", nargs="+", default=[*WORKED, *NATURAL, *GENERATED, *GROWING])
    parser.add_argument("--seconds", type=float, default=120, help="most that each checker takes")
    parser.add_argument("--second", type=Path, help="the program of tests/certificates/checker.cpp")
    asked = parser.parse_args()
    python = platform.python_version()
    print(f"mcpn {VERSION}, CPython {python}, {platform.system()} {platform.machine()}, seconds of CPU\n")
    print(f"| {' | '.join(HEAD)} |\n|{'---|' * len(HEAD)}")
    for name, study in studies(asked.missions):
        for by in ("check", "causes"):
            print(f"| {name} | {' | '.join(row(study, by, asked.second, asked.seconds))} |", flush=True)


if __name__ == "__main__":
    main()
