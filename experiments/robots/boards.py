"""Controllers in C on small boards: each walks as on the host; flash, RAM and cycles, as Markdown.

``python experiments/robots/boards.py [--write]`` takes the compilers and simulators that are there, and
writes the page ``docs/controller.md`` where all are. Debian has them: gcc-avr, avr-libc, simavr,
gcc-arm-none-eabi, libnewlib-arm-none-eabi, qemu-system-arm, gcc-riscv64-unknown-elf, gcc-mips-linux-gnu,
qemu-user. It takes some two minutes.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import get_args

import mcpn
from mcpn.controller.document import document
from mcpn.controller.generate import Form, generate
from mcpn.drawing.compose import MissionNet, compose
from mcpn.mission.model import Mission
from mcpn.robot.targets import files
from mcpn.robot.targets.c import LARGEST_TABLE

HERE = Path(__file__).parent
PAGE = HERE.parents[1] / "docs" / "controller.md"
MARKED = re.compile(r"(?<=<!-- boards -->\n).*(?=<!-- end of boards -->)", re.DOTALL)
EVENTS = 5000
STRICT = ("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror")
MISSIONS = ("courier", "drone", "glider", "rover", "ulysse")
BARE = ("-nostartfiles", "-Wl,--section-start=.vectors=0", "-Wl,-Ttext=0x400", "-Wl,-Tdata=0x20000000")


@dataclass(frozen=True)
class Board:
    """A compiler for a board, and what runs its programs here.

    Args:
        name: Of its processor.
        compiler: Of GCC, what stands before ``-gcc``.
        options: For this processor.
        run: The command that runs a program.
        flash: Bytes for code and constants.
        largest: Bytes of the largest table that the compiler takes.
    """

    name: str
    compiler: str
    options: tuple[str, ...]
    run: tuple[str, ...]
    flash: int = 1 << 32
    largest: int = 1 << 32

    @property
    def missing(self) -> list[str]:
        """The programs that are not there."""
        return [name for name in (f"{self.compiler}-gcc", self.run[0]) if shutil.which(name) is None]


def _avr(name: str, flash: int) -> Board:
    mcu = name.lower()
    run = ("simavr", "-m", mcu, "-f", "16000000")
    return Board(name, "avr", (f"-mmcu={mcu}", "-std=gnu99", "-DM_NO_NAMES"), run, flash, LARGEST_TABLE)


def _arm(name: str, machine: str, stack: str, flash: int) -> Board:
    options = (f"-mcpu={name.lower()}", "-mthumb", "-std=c99", f"-DSTACK={stack}", "-Wl,-e,main", *BARE)
    run = ("qemu-system-arm", "-M", machine, "-nographic", "-semihosting", "-kernel")
    return Board(name, "arm-none-eabi", options, run, flash)


SMALL = _avr("ATmega328P", 32 << 10)
LARGE = _avr("ATmega2560", 256 << 10)
CORTEX = _arm("Cortex-M0", "microbit", "0x20004000", 256 << 10)
RISC_V = Board(
    "RISC-V (rv32imac)",
    "riscv64-unknown-elf",
    ("-march=rv32imac", "-mabi=ilp32", "-std=c99", "-ffreestanding", "-nostdlib", "-DM_NO_NAMES"),
    ("qemu-riscv32",),
)
BOARDS = (
    LARGE,
    CORTEX,
    _arm("Cortex-M3", "lm3s6965evb", "0x20010000", 256 << 10),
    RISC_V,
    Board("MIPS (big-endian)", "mips-linux-gnu", ("-std=c99", "-static"), ("qemu-mips",)),
)
"""Where each walk is as on the host."""
SIZED = (SMALL, CORTEX, RISC_V)
"""Whose flash and RAM the page has."""


@dataclass(frozen=True)
class InC:
    """A controller in C of a mission that is called m.

    Args:
        texts: Header and source by name.
        tables: Bytes of its tables.
        largest: Bytes of the largest one.
    """

    texts: dict[str, str]
    tables: int
    largest: int

    @classmethod
    def of(cls, net: MissionNet, form: Form) -> InC:
        """The controller of a mission in some form."""
        texts = files(document(generate(net, form), net), "c")
        header = " ".join(texts["m.h"].split(" * "))
        said = (r"(\d+) bytes of constant tables", r"largest table is\s+\w+, (\d+) bytes")
        tables, largest = (int(row[1]) for text in said if (row := re.search(text, header)))
        return cls({name: texts[name] for name in ("m.h", "m.c")}, tables, largest)

    def fits(self, board: Board) -> bool:
        """Whether the board has room for it, and for some code."""
        return self.tables + (8 << 10) <= board.flash and self.largest <= board.largest

    def where(self, board: Board) -> tuple[str, ...]:
        """The option that keeps tables in flash, as the header says it."""
        said = re.search(r"-DM_TABLE=(\w+) \(AVR\)", self.texts["m.h"])
        return (f"-DM_TABLE={said[1]}",) if said and board.compiler == "avr" else ()

    def write(self, folder: Path) -> None:
        """Writes its files."""
        for name, text in self.texts.items():
            (folder / name).write_text(text)


def called_m(mission: Mission) -> MissionNet:
    """The net of a mission, which is called m from now on."""
    return compose(replace(mission, name="m"))


def read(example: str) -> Mission:
    """A worked mission."""
    return mcpn.open(HERE.parent / example / "mission.xml").mission_net.mission


def walk(made: InC, folder: Path, board: Board | None, *options: str) -> list[int]:
    """What a walk says of each event, on a board or on the host; no compiler may warn.

    Args:
        made: The controller.
        folder: Where it is compiled.
        board: The board; of the host, none.
        options: More for the compiler.
    """
    made.write(folder)
    gcc, run = "gcc", tuple[str, ...]()
    own: tuple[str, ...] = ("-std=c99", "-O1")
    if board is not None:
        gcc, run = f"{board.compiler}-gcc", tuple(board.run)
        own = ("-Os", *board.options, *made.where(board))
    command = [gcc, *STRICT, *own, *options, "-I.", "m.c", str(HERE / "boards.c"), "-o", "walk"]
    compiled = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if compiled.returncode or compiled.stderr:
        raise RuntimeError(f"{' '.join(command)}: {compiled.stderr}")
    told = subprocess.run(
        [*run, str(folder / "walk")], capture_output=True, text=True, timeout=900, check=True
    )
    plain = re.sub(r"\x1b\[\d*m", "", told.stdout + told.stderr)
    return [int(number, 16) for number in re.findall(r"^([0-9a-f]{8})\b", plain, re.MULTILINE)]


def sizes(made: InC, board: Board, *options: str) -> tuple[int, int]:
    """Bytes of code and constants, and of static RAM, of a controller without names."""
    prefix = board.compiler
    with TemporaryDirectory() as folder:
        made.write(Path(folder))
        kept = [option for option in board.options if option not in BARE]
        command = [f"{prefix}-gcc", *kept, *options, "-DM_NO_NAMES", "-Os", "-ffreestanding"]
        subprocess.run([*command, "-c", "m.c", "-o", "m.o"], cwd=folder, check=True)
        size = [f"{prefix}-size", "-A", "m.o"]
        told = subprocess.run(size, cwd=folder, check=True, capture_output=True, text=True).stdout
    found = {"text": 0, "progmem": 0, "rodata": 0, "data": 0, "bss": 0}
    for row in map(str.split, told.splitlines()):
        kind = row[0].removeprefix(".").partition(".")[0] if row else ""
        if kind in found:
            found[kind] += int(row[1])
    ram = found["data"] + found["bss"] + (found["rodata"] if prefix == "avr" else 0)
    return sum(found.values()) - found["bss"], ram


def cycles(made: InC) -> tuple[int, int]:
    """Cycles of an event on the small AVR, in the mean and at most."""
    with TemporaryDirectory() as folder:
        *_, in_all, most = walk(made, Path(folder), SMALL, "-DCYCLES")
    return round(in_all / EVENTS), most


def versions() -> str:
    """Which compilers and simulators are there, each with its version."""
    found = []
    for program in (*dict.fromkeys(f"{board.compiler}-gcc" for board in SIZED), "simavr"):
        if shutil.which(program):
            asked = (
                ["dpkg-query", "-W", "-f", "${Version}", program]
                if program == "simavr"
                else [program, "-dumpfullversion", "-dumpversion"]
            )
            told = subprocess.run(asked, capture_output=True, text=True, check=False).stdout.strip()
            found.append(f"{program} {told.partition('+')[0]}".strip())
    return ", ".join(found)


def page() -> Iterator[str]:
    """The lines of the page: flash and RAM of Ulysse, then cycles of each worked mission that fits."""
    ulysse = called_m(read("ulysse"))
    yield "| board | form | flash | static RAM |\n|---|---|---|---|"
    for board in SIZED:
        for form in get_args(Form) if shutil.which(f"{board.compiler}-gcc") else ():
            made = InC.of(ulysse, form)
            for option in (made.where(board), ()) if board is SMALL else ((),):
                name = f"{board.name}, `{option[0].replace('M_', 'ULYSSE_')}`" if option else board.name
                flash, ram = sizes(made, board, *option)
                yield f"| {name} | {form} | {flash:,} | {ram:,} |"
    if not SMALL.missing:
        yield f"\nCycles of an event on an {SMALL.name}, tables in flash, in {EVENTS:,} events at random:\n"
        yield "| mission | form | mean | most |\n|---|---|---|---|"
        for name in MISSIONS:
            net = called_m(read(name))
            for form in get_args(Form):
                made = InC.of(net, form)
                if made.fits(SMALL):
                    mean, most = cycles(made)
                    yield f"| {name} | {form} | {mean:,} | {most:,} |"
    yield f"\nMeasured with {versions()}."


def main(write: bool) -> None:
    """Prints the tables, or writes them into the page."""
    text = "\n".join(page()) + "\n"
    if write:
        if missing := [name for board in SIZED for name in board.missing]:
            raise SystemExit(f"not written: {', '.join(missing)} missing")
        PAGE.write_text(MARKED.sub(lambda _: text, PAGE.read_text()))
    else:
        print(text, end="")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--write", action="store_true", help="write them into the page")
    main(parser.parse_args().write)
