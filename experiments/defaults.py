"""CPU of typed questions as they were asked by default, and as they are: both ways in one run.

Usage: ``python experiments/defaults.py [--sites N] [--branches N] [--seconds S]``

Each command runs in a process of its own; its seconds of CPU are counted with those of its children. Before:
all markings, as a diagram or one by one. Now: what ``mcpn`` does where nothing is said. A mission of 20 sites
with eight resources, a net of switches round which a token goes, and a block of five activities that stand on
one resource. A command is stopped after 120 s of CPU. It takes about
11 seconds; with three branches some minutes.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from growth import natural

from mcpn.mission.writer import save_mission

BLOCK = """<mission name="block" xmlns="urn:mcpn:mission:1">
<robot name="robot">
<hardware name="core" failure_rate="0.5" repair_rate="2" shared="true"/>
<software name="raw"/><software name="map"/><software name="pose"/><software name="plan"/>
<event name="call"/>
<activity name="sample" produces="raw"><alternative name="sampled" consumes="core"/></activity>
<activity name="build" produces="map"><alternative name="built" consumes="raw"/><alternative name="known"
  consumes="core"/><alternative name="rebuilt" consumes="raw"/></activity>
<activity name="locate" produces="pose"><alternative name="both" consumes="core raw"/><alternative
  name="alone" consumes="raw"/><alternative name="again" consumes="raw"/></activity>
<activity name="decide" produces="plan"><alternative name="near" consumes="pose"/><alternative name="far"
  consumes="pose map"/><alternative name="late" consumes="pose"/></activity>
<activity name="move"><alternative name="moved" consumes="plan map"/></activity>
<activity name="film"><alternative name="filmed" consumes="raw map"/></activity>
<activity name="turn"><alternative name="turned" consumes="plan raw"/></activity>
<activity name="look"><alternative name="looked" consumes="raw map"/></activity>
<activity name="tell"><alternative name="told" consumes="plan map"/></activity>
</robot>
<parallel name="all" repeat="2">
<objective name="first"><parallel name="pair" success="succeed">
<objective name="go" activities="move film" duration="0.1"><on event="call" goto="succeed"/></objective>
<objective name="spin" activities="turn" duration="0.7" mandatory="false"/>
</parallel></objective>
<objective name="watch" activities="look" duration="1.6"><on event="call" goto="fail"/></objective>
<objective name="report" activities="tell" duration="2.9"/>
</parallel>
</mission>
"""
"""Few stable states, between which there are more markings than can be listed."""


def ring(switches: int) -> str:
    """A net in which a token goes round, past switches that turn on and off: its markings are n * 2^n."""
    lines = ["net ring", "pl at0 (1)"]
    for i in range(switches):
        lines += [f"pl off{i} (1)", f"tr on{i} off{i} -> on{i}", f"tr back{i} on{i} -> off{i}"]
        lines.append(f"tr go{i} at{i} on{i} -> at{(i + 1) % switches} on{i}")
    return "\n".join(lines) + "\n"


def cpu(arguments: list[str], seconds: float) -> str:
    """The seconds of CPU of one command, children included, or that it was stopped."""
    began = os.times()
    limit = f"import resource; resource.setrlimit(resource.RLIMIT_CPU, ({seconds:.0f}, {seconds:.0f})); "
    code = limit + "from mcpn.cli import main; main()"
    run = subprocess.run(
        [sys.executable, "-P", "-c", code, *arguments], capture_output=True, text=True, check=False
    )
    ended = os.times()
    took = ended.children_user + ended.children_system - began.children_user - began.children_system
    if run.returncode < 0:
        return f"over {seconds:.0f}"
    if run.returncode > 1:
        return f"gave up after {took:.1f}: {run.stderr.splitlines()[0][:60]}"
    return f"{took:.2f}"


def main() -> None:
    """Measures and prints a table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sites", type=int, default=20, help="sites of the mission (default: 20)")
    parser.add_argument("--branches", type=int, default=2, help="branches of a site (default: 2)")
    parser.add_argument("--switches", type=int, default=16, help="switches of the net (default: 16)")
    parser.add_argument("--seconds", type=float, default=120, help="the most CPU of a command (default: 120)")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        sites, net, block = (str(Path(name, file)) for file in ("sites.xml", "ring.net", "block.xml"))
        save_mission(natural(asked.sites, asked.branches, 8, 5), sites)
        Path(net).write_text(ring(asked.switches))
        Path(block).write_text(BLOCK)
        markings = ["--on", "markings", "--engine", "symbolic"]
        print("| question | before, s of CPU | now, s of CPU |\n|---|---|---|")
        for told, command, before in (
            (f'`ask` "EF success" at {asked.sites} sites', ["ask", sites, "EF success"], markings),
            (f"`states` at {asked.sites} sites", ["states", sites], ["--engine", "symbolic"]),
            (
                f'`ask` "EF deadlock" on a net of {asked.switches} switches',
                ["ask", net, "EF deadlock"],
                ["--engine", "explicit"],
            ),
            (
                "`causes` on a small block: `--engine explicit`, then `local`",
                ["causes", block, "--engine", "local"],
                ["--engine", "explicit"],
            ),
        ):
            print(
                f"| {told} | {cpu([*command, *before], asked.seconds)} | {cpu(command, asked.seconds)} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
