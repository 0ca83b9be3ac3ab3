"""What certificates of missions cost: claims, bytes, seconds of CPU to write, and to check by both checkers.

Usage: ``python experiments/faults/certificate_costs.py [--missions NAME...] [--seconds S] [--second]`` prints
a row for each mission and each of ``check`` and ``causes``: claims, by what became of them, bytes, seconds:
to answer in a process that runs, of the whole command, to write, and to check, as the command does; how many
times the command that is; and the programs in C++ one after the other. All missions take half an hour.
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

from experiments.faults.both_checkers import compiled
from experiments.growth.growth import FAMILIES
from experiments.shared.missions import Parameters, generate
from mcpn.certificates.verified import Verified, verified
from mcpn.certificates.writing import Certificate, certificate_of, certificate_of_causes
from mcpn.errors import InputError, LimitError, SemanticsError
from mcpn.mission.writer import save_mission
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
LARGE = ("sites 1000", "sites 10000")
"""Missions of which causes have no certificate."""
HEAD = (
    "mission",
    "by",
    "proved",
    "refuted",
    "open",
    "trusted",
    "bytes",
    "asked",
    "command",
    "written",
    "checked",
    "times",
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


def row(study: Study, by: str, second: bool, seconds: float) -> list[str]:
    """One row of the table, but for the mission's name."""
    try:
        asked, written, made = certified(study, by)
    except (LimitError, SemanticsError) as error:
        return [by, f"refused: {error}"]
    data = made.to_bytes()
    with tempfile.TemporaryDirectory() as folder:
        file, mission = Path(folder, "cert"), Path(folder, "mission.xml")
        file.write_bytes(data)
        checked, found = timed(lambda: verified(made, file, seconds))
        assert isinstance(found, Verified)
        programs = _programs(made) if second else []
        other = sum(
            _seconds_of([str(compiled(each)), str(file), "--seconds", str(seconds)]) for each in programs
        )
        save_mission(study.mission, mission)
        command = _seconds_of([sys.executable, "-m", "mcpn.cli", by, str(mission)])
    counts = [len(found.keys(how)) for how in ("proved", "refuted", "not checked")]
    numbers = [*counts, len(made.trusted), len(data)]
    times = [f"{each:.2f}" for each in (asked, command, written, checked)]
    return [by, *map(str, numbers), *times, f"{checked / command:.1f}", f"{other:.2f}" if programs else "-"]


def _programs(made: Certificate) -> list[str]:
    """The programs in C++ that read a certificate."""
    if made.net is None:
        return []
    if made.diagrams is not None:
        return ["diagram_checker"]
    return ["checker", "core_checker", *(["further_checker"] if made.further else [])]


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
    parser.add_argument("--second", action="store_true", help="ask the programs in C++, too")
    asked = parser.parse_args()
    python = platform.python_version()
    print(f"mcpn {VERSION}, CPython {python}, {platform.system()} {platform.machine()}, seconds of CPU\n")
    print(f"| {' | '.join(HEAD)} |\n|{'---|' * len(HEAD)}")
    for name, study in studies(asked.missions):
        for by in ("check", "causes") if name not in LARGE else ("check",):
            print(f"| {name} | {' | '.join(row(study, by, asked.second, asked.seconds))} |", flush=True)


if __name__ == "__main__":
    main()
