"""Prints the oldest versions that pyproject.toml allows, as constraints for pip.

After ``python .ci/lower_bounds.py > oldest.txt``, ``pip install -c oldest.txt ".[test-all]"`` takes them.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

BOUND = re.compile(r"([A-Za-z0-9._-]+)(?:\[[^]]*\])?>=([0-9.]+)")

project = tomllib.loads(Path(__file__).parents[1].joinpath("pyproject.toml").read_text())["project"]
extras = project["optional-dependencies"]
wanted = [*project["dependencies"], *(line for lines in extras.values() for line in lines)]
bounds = dict(match.groups() for line in wanted if (match := BOUND.match(line)))
for name, version in sorted(bounds.items()):
    print(f"{name}=={version}")
