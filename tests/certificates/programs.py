"""The programs in C++ of ``second/``, of which those that share most of their headers are compiled as one."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from tests.natives import built_once, cpp_compiler

SECOND = Path(__file__).parent / "second"

TOGETHER = (
    ("core_checker", "section_checker", "section_controller_checker", "controller_checker"),
    ("checker", "further_checker"),
    ("diagram_checker",),
)
"""Headers are most of what the compiler reads, and no two of one group name two things alike."""

OPTIONS = ("-O1", "-std=c++17", "-Wall", "-Wextra", "-Werror", f"-I{SECOND}")


def one_source(names: tuple[str, ...]) -> str:
    """A source that is each of the programs, by the name that it is called by."""
    texts = [(SECOND / f"{name}.cpp").read_text().splitlines() for name in names]
    # All that they include comes first, so that nothing of it is declared within a program's namespace.
    headers = dict.fromkeys(line for text in texts for line in text if line.startswith("#include"))
    programs = [f'namespace {name} {{\n#include "{name}.cpp"\n}}' for name in names]
    chosen = [f'  if (called == "{name}") return {name}::main(count, words);' for name in names]
    main = [
        "int main(int count, char** words) {",
        "  const std::string path(words[0]), called = path.substr(path.rfind('/') + 1);",
        *chosen,
        "  return 3;",
        "}",
    ]
    return "\n".join([*headers, *programs, *main, ""])


def compiled(name: str, folders: pytest.TempPathFactory) -> Path:
    """A program in C++ of that folder, compiled once for all processes of one run of the tests."""
    names = next(each for each in TOGETHER if name in each)

    def build(at: Path) -> None:
        (at / "whole.cpp").write_text(one_source(names))
        subprocess.run([*cpp_compiler(), *OPTIONS, "whole.cpp", "-o", names[0]], cwd=at, check=True)
        for other in names[1:]:
            (at / other).hardlink_to(at / names[0])

    return built_once(folders, f"{names[0]}_and_more", build) / name
