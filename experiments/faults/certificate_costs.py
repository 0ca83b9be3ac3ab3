"""What certificates of missions cost: claims, bytes, seconds of CPU to write, and to check by both checkers.

Usage: ``python experiments/faults/certificate_costs.py [--missions NAME...] [--seconds S] [--row-seconds S]
[--second]`` prints a row for each mission and each of ``check`` and ``causes`` as soon as it is measured:
claims, by what became of them, bytes, seconds: to answer in a process that runs, of the whole command, to
write, and to check, as the command does; how many times the command that is; and the programs in C++ one
after the other, with the claims that they prove. Each row has a process of its own, and an end. All missions
take half an hour.
"""

from __future__ import annotations

import argparse
import multiprocessing
import platform
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2]))

from experiments.faults.both_checkers import compiled
from experiments.growth.growth import FAMILIES
from experiments.shared.missions import Parameters, generate
from mcpn.certificates.checked_claims import Verified, verified
from mcpn.certificates.writing import Certificate, certificate_of, certificate_of_causes
from mcpn.errors import InputError, LimitError, SemanticsError
from mcpn.mission.writer import save_mission
from mcpn.study import Study, open_study
from mcpn.version import VERSION

ROOT = Path(__file__).resolve().parents[1]
WORKED = {name: ROOT / name / "mission.xml" for name in ("ulysse", "courier", "drone", "glider", "rover")}
NATURAL = {f"natural {p.stem}": p for p in sorted((ROOT.parent / "tests/natural").glob("*.xml"))}
FAMILY = tuple(f"{family} {sizes[0]}" for family, (_, sizes) in FAMILIES.items() if family != "sites")
GROWING = ("share 4", "drivers 4", "data 8", "sites 5", "sites 100", "sites 1000", "sites 10000")
"""Beside the smallest mission of each family."""
GENERATED = {
    f"generated, {sections} sections": Parameters(
        sections=sections, types=sections, hardware=hardware, per_section=3, alternatives=2, depth=1
    )
    for sections, hardware in ((3, 6), (6, 14))
}
LARGE = ("sites 100", "sites 1000", "sites 10000")
"""Missions of which causes have no certificate."""
PROGRAMS = ("checker", "core_checker", "further_checker", "diagram_checker", "section_checker")
MISSIONS = [*dict.fromkeys((*WORKED, *NATURAL, *GENERATED, *FAMILY, *GROWING))]
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
    "C++ proves",
)


def timed(work: Callable[[], object]) -> tuple[float, object]:
    """The seconds that some work takes, and what it gives."""
    begun = time.process_time()
    found = work()
    return time.process_time() - begun, found


def study_of(name: str) -> Study:
    """A mission of the table."""
    if name in GENERATED:
        return Study(generate(GENERATED[name], 1))
    if name in {**WORKED, **NATURAL}:
        return open_study({**WORKED, **NATURAL}[name])
    family, size = name.split()
    return Study(FAMILIES[family][0](int(size)))


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
        others = [
            _seconds_of([str(compiled(each)), str(file), "--seconds", str(seconds)]) for each in programs
        ]
        save_mission(study.mission, mission)
        command, _ = _seconds_of([sys.executable, "-m", "mcpn.cli", by, str(mission)])
    counts = [len(found.keys(how)) for how in ("proved", "refuted", "not checked")]
    numbers = [*counts, len(made.trusted), len(data)]
    times = [f"{each:.2f}" for each in (asked, command, written, checked)]
    proves = sum(line.startswith("proved ") for _, said in others for line in said.splitlines())
    last = [f"{sum(each for each, _ in others):.2f}", str(proves)] if programs else ["-", "-"]
    return [by, *map(str, numbers), *times, f"{checked / command:.1f}", *last]


def bounded(name: str, by: str, second: bool, seconds: float, most: float) -> list[str]:
    """The same in a process of its own, which has an end."""
    fork = multiprocessing.get_context("fork")
    here, there = fork.Pipe(duplex=False)
    process = fork.Process(target=_sent, args=(there, name, by, second, seconds))
    process.start()
    there.close()
    try:
        found: list[str] = here.recv() if here.poll(most) else [by, f"no answer in {most:g} s of the clock"]
    except EOFError:
        found = [by, "its process has ended without an answer"]
    process.terminate()
    process.join()
    return found


def _sent(there: Connection, name: str, by: str, second: bool, seconds: float) -> None:
    there.send(row(study_of(name), by, second, seconds))


def _programs(made: Certificate) -> list[str]:
    """The programs in C++ that read a certificate."""
    if made.net is None:
        return ["section_checker"]
    if made.diagrams is not None:
        return ["diagram_checker"]
    return ["checker", "core_checker", *(["further_checker"] if made.further else [])]


def _seconds_of(command: list[str]) -> tuple[float, str]:
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run = subprocess.run(command, check=False, capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, run.stdout


def main() -> None:
    """Prints the table that the command line asks for."""
    parser = argparse.ArgumentParser(description="What certificates of missions cost.")
    parser.add_argument("--missions", nargs="+", default=MISSIONS)
    parser.add_argument("--seconds", type=float, default=300, help="most that each checker takes")
    parser.add_argument("--row-seconds", type=float, default=900, help="most that a row takes")
    parser.add_argument("--second", action="store_true", help="ask the programs in C++, too")
    asked = parser.parse_args()
    python = platform.python_version()
    print(f"mcpn {VERSION}, CPython {python}, {platform.system()} {platform.machine()}, seconds of CPU\n")
    print(f"| {' | '.join(HEAD)} |\n|{'---|' * len(HEAD)}")
    for each in PROGRAMS if asked.second else ():
        compiled(each)  # once, before rows have processes of their own
    for name in asked.missions:
        for by in ("check", "causes") if name not in LARGE else ("check",):
            found = bounded(name, by, asked.second, asked.seconds, asked.row_seconds)
            print(f"| {name} | {' | '.join(found)} |", flush=True)


if __name__ == "__main__":
    main()
