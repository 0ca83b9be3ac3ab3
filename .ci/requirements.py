"""Prints what the package and some extras need, for pip: ``python .ci/requirements.py docs test-all``."""

from __future__ import annotations

import re
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

project = tomllib.loads(Path(__file__).parents[1].joinpath("pyproject.toml").read_text())["project"]


def needed(extra: str) -> Iterator[str]:
    """The requirements of an extra, and of those that it names."""
    for line in project["optional-dependencies"][extra]:
        if inner := re.fullmatch(r"mcpn\[(.*)\]", line):
            for name in inner[1].split(","):
                yield from needed(name.strip())
        else:
            yield line


of_extras = [line for extra in sys.argv[1:] for line in needed(extra)]
print(*dict.fromkeys([*project["dependencies"], *of_extras]), sep="\n")
