"""Numbers of risk of missions with many sites that lead back: CPU seconds, and the probability of success.

Usage: ``python experiments/growth/loops.py [--sites N ...]``

The natural mission of ``growth.py`` (8 hardware resources, data with fallbacks, two branches at each site),
with rates drawn once. Its sites lead back nowhere; each to itself where it fails; each to the one before;
each to the first; or the last, where it succeeds, to the first again (a *patrol*, which a call back ends).
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command line does

sys.path.append(str(Path(__file__).resolve().parents[2]))

import mcpn
from experiments.growth.growth import BASE, natural
from experiments.shared.rates import rated
from mcpn.answers.causes.risk import risk
from mcpn.mission.model import Mission, Recursive
from mcpn.mission.writer import write_mission

WAYS = ("none", "itself", "before", "first", "patrol")


def leading_back(mission: Mission, way: str) -> Mission:
    """The mission whose sites lead back."""
    sites = [block.name for block in mission.blocks if isinstance(block, Recursive)]
    blocks = list(mission.blocks)
    for i, name in enumerate(sites):
        if way == "patrol":
            onward = {"success": sites[0]} if name == sites[-1] else {}
        else:
            failure = {"itself": name, "before": sites[max(0, i - 1)], "first": sites[0]}
            onward = {"failure": failure[way]} if way in failure else {}
        blocks[i] = replace(blocks[i], **onward)
    return replace(mission, blocks=tuple(blocks))


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--sites", nargs="+", type=int, default=[100, 1000])
    print("| sites | lead back to | success | seconds of the numbers |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for sites in parser.parse_args().sites:
            for way in WAYS:
                path = Path(folder) / f"{way}{sites}.xml"
                mission = leading_back(rated(natural(**{**BASE, "sites": sites})), way)
                path.write_bytes(write_mission(mission))
                prospects = mcpn.open(path).causes().prospects
                begin = time.process_time()
                found = risk(prospects).success
                print(f"| {sites} | {way} | {found:.9f} | {time.process_time() - begin:.1f} |", flush=True)


if __name__ == "__main__":
    main()
