"""Flash and static RAM of a controller in C on small boards, with the compilers that are there: Markdown.

``python experiments/boards.py [MISSION]``; Debian has gcc-avr, gcc-arm-none-eabi, gcc-riscv64-unknown-elf.
It takes some seconds.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import get_args

import mcpn
from mcpn.controller.document import document
from mcpn.controller.generate import Form, generate
from mcpn.controller.targets import files

BOARDS = {
    "ATmega328P": ("avr", "-mmcu=atmega328p", "-D{}_TABLE=__flash"),
    "Cortex-M0": ("arm-none-eabi", "-mcpu=cortex-m0", "-mthumb"),
    "RISC-V (rv32imac)": ("riscv64-unknown-elf", "-march=rv32imac", "-mabi=ilp32"),
}


def sizes(texts: dict[str, str], name: str, compiler: tuple[str, ...]) -> tuple[int, int]:
    """Bytes of code and constants, and of static RAM, of a controller without names."""
    prefix, *options = compiler
    with TemporaryDirectory() as made:
        folder = Path(made)
        for file in (f"{name}.h", f"{name}.c"):
            (folder / file).write_text(texts[file])
        named = [option.format(name.upper()) for option in options]
        command = [
            f"{prefix}-gcc",
            *named,
            f"-D{name.upper()}_NO_NAMES",
            "-Os",
            "-std=gnu99",
            "-ffreestanding",
        ]
        subprocess.run([*command, "-c", f"{name}.c", "-o", "x.o"], cwd=folder, check=True)
        size = [f"{prefix}-size", "-A", "x.o"]
        told = subprocess.run(size, cwd=folder, check=True, capture_output=True, text=True).stdout
    found = {"text": 0, "progmem": 0, "rodata": 0, "data": 0, "bss": 0}
    for row in map(str.split, told.splitlines()):
        kind = row[0].removeprefix(".").partition(".")[0] if row else ""
        if kind in found:
            found[kind] += int(row[1])
    ram = found["data"] + found["bss"] + (found["rodata"] if prefix == "avr" else 0)
    return sum(found.values()) - found["bss"], ram


def main(mission: Path) -> None:
    """Prints the table."""
    net = mcpn.open(mission).mission_net
    print("| board | form | flash | static RAM |\n|---|---|---|---|")
    for board, compiler in BOARDS.items():
        for form in get_args(Form) if shutil.which(f"{compiler[0]}-gcc") else ():
            texts = files(document(generate(net, form), net), "c")
            name = next(file.removesuffix(".h") for file in texts if file.endswith(".h"))
            flash, ram = sizes(texts, name, compiler)
            print(f"| {board} | {form} | {flash} | {ram} |")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("mission", nargs="?", type=Path, default=Path("experiments/ulysse/mission.xml"))
    main(parser.parse_args().mission)
