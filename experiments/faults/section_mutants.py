"""Mutants of missions whose claims are proved by sections: none that is false is proved.

Usage: ``python experiments/faults/section_mutants.py [--mutants N] [--seed S] [--second]`` changes N times
the core mission of a row of sites, or of a generated mission. What sectioncheck, with ``--second`` also the
program in C++, proves of the changed mission by its sections is held against all its states, played one by
one. Exit code 1 if a claim is false, or one program alone proves it. 1,000 mutants take a minute.
"""

from __future__ import annotations

import copy
import json
import random
import sys
import tempfile
from collections import Counter
from functools import cache
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).resolve().parents[2]))

from experiments.faults import campaigns
from experiments.faults.both_checkers import proved
from experiments.faults.certificates import apart
from experiments.shared.missions import Parameters, generate
from mcpn.certificates import certcheck, corecheck
from mcpn.certificates.core_entry import core_entry
from mcpn.certificates.coregraph import ENDS
from mcpn.certificates.sections import sectioncheck
from mcpn.mission.xml import read_mission
from mcpn.study import Study

Document = dict[str, Any]
MOST = 4_000
HEAD = """<mission xmlns="urn:mcpn:mission:1" name="row">
  <robot name="r">
    <hardware name="wheels"/><hardware name="gps"/><hardware name="imu" repairable="false"/>
    <event name="call"/>
    <software name="place"/>
    <activity name="locate" produces="place">
      <alternative name="by_gps" consumes="gps"/><alternative name="by_imu" consumes="imu"/>
    </activity>
    <activity name="drive"><alternative name="mapped" consumes="wheels place"/></activity>
    <activity name="rest"><alternative name="on"/></activity>
  </robot>
  <on event="call" goto="home"/>
"""
SITE = '<objective name="site{}" activities="drive" success="site{}" failure="{}"/>\n'
LAST = '<objective name="home" activities="rest" success="succeed" failure="home"/>\n</mission>\n'
GENERATED = Parameters(sections=4, types=3, hardware=4, per_section=2, alternatives=2, depth=1)


# Missions and claims.


def row(sites: int, failure: str = "home") -> str:
    """A mission of many sites of one type."""
    text = "".join(SITE.format(i, i + 1, failure) for i in range(sites))
    return HEAD + text.replace(f"site{sites}", "home") + LAST


def study_of(sites: int, failure: str = "home") -> Study:
    """Many sites, to be asked."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "row.xml")
        path.write_text(row(sites, failure))
        return Study(read_mission(path))


def _core(study: Study) -> Document:
    found: Document = json.loads(json.dumps(core_entry(study.mission_net)))
    return found


@cache
def core_of(sites: int, failure: str = "home") -> Document:
    """The core mission of many sites, as a certificate holds it."""
    return _core(study_of(sites, failure))


@cache
def generated(seed: int) -> Document:
    """The core mission of a few generated sections."""
    return _core(Study(generate(GENERATED, seed)))


def claim(kind: str, holds: bool) -> Document:
    """One claim of ``sections.json``."""
    return {
        "key": f"{kind} {holds}",
        "kind": kind,
        "subject": [],
        "holds": holds,
        "sentence": kind,
        "statement": {},
        "evidence": {},
    }


ALL = [claim(kind, holds) for kind in sorted(sectioncheck.KINDS) for holds in (True, False)]
"""Each claim that sections may prove, and its contrary."""
CLAIMED = {"format": "mcpn-certificate", "version": 1, "mission": "row", "claims": ALL, "trusted": []}


def mutated(core: Document, of: random.Random) -> Document:
    """The core mission with one change."""
    changed = copy.deepcopy(core)
    sections, robot = changed["graph"]["sections"], changed["robot"]
    one = of.choice(sections)
    names = [each["name"] for each in sections]
    match of.randrange(8):
        case 0:
            sections.remove(one)
        case 1:
            sections.append({**copy.deepcopy(one), "name": of.choice([one["name"], "another"])})
        case 2:
            outcome = of.choice(sorted(one["routes"]))
            one["routes"][outcome][-1]["to"] = of.choice([*names, *ENDS, "nowhere"])
        case 3:
            changed["graph"]["entry"] = of.choice([*names, "nowhere"])
        case 4:
            hardware = of.choice(robot["hardware"])
            key = of.choice(["faulty", "shared", "repairable", "out", "late", "crash"])
            hardware[key] = not hardware[key]
        case 5:
            ways = of.choice(robot["activities"])["alternatives"]
            del ways[of.randrange(len(ways))]
        case 6:
            of.choice(robot["activities"])["alternatives"][0]["consumes"] = [
                of.choice(robot["hardware"])["name"]
            ]
        case _:
            inner = list(sectioncheck.objectives_of(one))
            of.choice(inner)["activities"] = [of.choice(robot["activities"])["name"]]
    return changed


# What is so, section or not.


def played(core: Document) -> dict[str, bool]:
    """What is so of a core mission, all states of which are played one by one, without sections."""
    mission = corecheck.CoreMission(core)
    states, numbers = [mission.first], {mission.first: 0}
    edges = list[list[int]]()
    for state in states:  # grows while it is walked
        edges.append([])
        for happens in mission.possible(state):
            for after in mission.after(state, happens):
                if after not in numbers:
                    numbers[after] = len(states)
                    states.append(after)
                edges[-1].append(numbers[after])
        if len(states) > 20 * MOST:
            raise certcheck.Limit("too many states")
    before = list[list[int]]([] for _ in states)
    for number, targets in enumerate(edges):
        for target in targets:
            before[target].append(number)
    ended = [ENDS.get(state.at, "") if isinstance(state.at, str) else "" for state in states]
    found = {"can_always_go_on": all(targets or end for targets, end in zip(edges, ended, strict=True))}
    for kind, goals in sectioncheck.GOALS.items():
        there = [number for number, end in enumerate(ended) if end in goals]
        always = len(certcheck.grown(there, before.__getitem__)) == len(states)
        found[kind] = always if kind.startswith("can_always") else bool(there)
    return found


# The campaign.


def of_sections(draw: random.Random, second: bool) -> tuple[bool, list[str]]:
    """Changes a mission: whether some claim is proved, and what is wrong with that."""
    if draw.random() < 0.5:
        core = core_of(draw.randint(1, 4), draw.choice(["home", "abort", "succeed", "site0"]))
    else:
        core = generated(draw.randrange(20))
    changed = mutated(core, draw)
    first, other = proved("sections", {"core": changed, "sections": CLAIMED}, second)
    if not first | other:
        return False, []
    wrong, whole = apart(first, other), played(changed)
    said = (key.rsplit(" ", 1) for key in sorted(first | other))
    return True, wrong + [f"{kind} {holds}" for kind, holds in said if str(whole[kind]) != holds]


def campaign(of: str, mutants: int, seed: int, second: bool = False) -> tuple[Counter[str], list[str]]:
    """Changes missions; what became of each change, and the false claims that were proved."""
    found, wrong = Counter[str](), list[str]()
    for number in range(mutants):
        some, why = of_sections(random.Random(f"{seed} {number}"), second)
        wrong += [f"{of}: mutant {number} of seed {seed}: {each}" for each in why]
        found["some claim is proved" if some else "nothing is proved"] += 1
    return found, wrong


if __name__ == "__main__":
    sys.exit(campaigns.ran("Mutants of missions of sections.", ("sections",), campaign))
