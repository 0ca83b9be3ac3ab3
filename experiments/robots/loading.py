"""What it costs to load a controller: seconds, and peak memory of the process, by form (on Linux).

Usage: ``python experiments/robots/loading.py MISSION [MISSION ...]``
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.drawing.compose import compose
from mcpn.errors import McpnError
from mcpn.mission.xml import read_mission
from mcpn.robot.targets.json import write_json

LOAD = """
import sys, time
from mcpn.robot.runtime import Controller

def peak():  # of this program alone; that of getrusage begins with its parent's
    (line,) = (line for line in open("/proc/self/status") if line.startswith("VmHWM"))
    return int(line.split()[1])

empty = peak()
started = time.process_time()
Controller.load(sys.argv[1])
seconds = time.process_time() - started
print(f"{seconds:.2f} s, {(peak() - empty) / 1024:.0f} MB")
"""


def main() -> None:
    """Prints a line for each mission and form."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("missions", nargs="+", type=Path)
    parser.add_argument("--max-states", type=int, help="of a section of the hierarchical form")
    arguments = parser.parse_args()
    for mission in arguments.missions:
        mission_net = compose(read_mission(mission))
        for form in ("hierarchical", "modular"):
            try:
                found = generate(mission_net, form, max_states=arguments.max_states)
                text = write_json(document(found, mission_net))
            except McpnError as error:
                print(f"{mission}: {form}: {error}")
                continue
            with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
                file.write(text)
                file.flush()
                run = subprocess.run(
                    [sys.executable, "-c", LOAD, file.name], capture_output=True, text=True, check=True
                )
            print(f"{mission}: {form}: {len(text) / 1e6:.2f} MB, loaded in {run.stdout.strip()}")


if __name__ == "__main__":
    main()
