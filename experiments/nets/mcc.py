"""The symbolic engine on nets of the Model Checking Contest, safe or not, judged by its answers.

Run: python experiments/nets/mcc.py FOLDER [--seconds 60] [--gigabytes 4] [NET...]

FOLDER holds oracles.tsv and NAME/model.pnml. Each net runs in a process of its own; a line says whether
states, edges, deadlock and most tokens are exactly the contest's, the seconds of the clock and of the
processors from the parsed net to all counts, the process's peak memory, the nodes of the final diagram (if
there is one) and the order of places that won the race.
It takes up to a minute for each net.
"""

from __future__ import annotations

import argparse
import csv
import json
import platform
import subprocess
import sys
from pathlib import Path

import mcpn
from mcpn.nets.formats import read_net
from mcpn.nets.petri import PetriNet

QUICK = 2.0


def solve(net: PetriNet, gigabytes: float) -> None:
    """Counts one net and prints what was found as JSON."""
    import resource
    import time

    from mcpn.spaces.diagrams.bounded import reach_markings

    started, working = time.perf_counter(), time.process_time()
    space = reach_markings(net, memory_limit=int(gigabytes * 2**30))
    found = {
        "states": space.states,
        "edges": space.edges,
        "deadlock": space.dead_states > 0,
        "tokens": space.max_tokens,
        "seconds": time.perf_counter() - started,
        "cpu": time.process_time() - working,
        "nodes": space.nodes,
        "order": space.order,
        "megabytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss >> 10,
    }
    print(json.dumps(found))


def run(command: list[str], seconds: float) -> dict[str, object]:
    """What a process of its own finds of one net."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=seconds, check=False)
    except subprocess.TimeoutExpired:
        return {"failed": f"no end in {seconds:.0f} s"}
    if done.returncode:
        return {"failed": (done.stderr.strip().splitlines() or ["killed"])[-1]}
    return dict(json.loads(done.stdout))


def main() -> None:
    """Prints the table."""
    sys.set_int_max_str_digits(0)
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, nargs="?")
    parser.add_argument("nets", nargs="*")
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--gigabytes", type=float, default=4)
    parser.add_argument("--solve", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.solve:
        solve(read_net(options.solve), options.gigabytes)
        return
    if options.folder is None:
        parser.error("the contest's folder is missing")
    with (options.folder / "oracles.tsv").open(newline="") as file:
        rows = list(csv.DictReader(file, delimiter="\t"))
    rows = [row for row in rows if not options.nets or row["model"] in options.nets]
    solved = quick = wrong = 0
    print(f"{'net':28}{'answer':>8}{'seconds':>9}{'CPU':>9}{'MB':>7}{'nodes':>9}  order")
    for row in rows:
        path = str(options.folder / row["model"] / "model.pnml")
        command = [sys.executable, __file__, "--solve", path, "--gigabytes", str(options.gigabytes)]
        found = run(command, options.seconds)
        if "failed" in found:
            print(f"{row['model']:28}{'none':>8}  {found['failed']}", flush=True)
            continue
        right = (found["states"], found["edges"], found["deadlock"], found["tokens"]) == (
            int(row["states"]),
            int(row["edges"]),
            row["deadlock_exists"] == "TRUE",
            int(row["max_tokens_per_marking"]),
        )
        solved += right
        wrong += not right
        quick += right and float(str(found["seconds"])) < QUICK
        print(
            f"{row['model']:28}{'right' if right else 'WRONG':>8}{found['seconds']:9.2f}"
            f"{found['cpu']:9.2f}{found['megabytes']:7}{found['nodes'] or '-':>9}  {found['order']}",
            flush=True,
        )
    print(f"{solved} of {len(rows)} solved, {quick} in under {QUICK:.0f} s, {wrong} wrong")
    machine = f"{platform.system()} {platform.machine()}"
    print(f"mcpn {mcpn.__version__}, Python {platform.python_version()}, {machine}")


if __name__ == "__main__":
    main()
