"""Mutants of formulas and of nominal success that sections prove: none that is false is proved.

Usage: ``python experiments/faults/stated_mutants.py [--mutants N] [--seed S] [--second]`` changes N times the
core mission of a few sections, or what some of its claims state. What sectioncheck, with ``--second`` also
the program in C++, proves by sections is evaluated by mcpn's engine on all states of the mission, played one
by one. Exit code 1 if a claim is false, or one program alone proves it. 1,000 take a minute.
"""

from __future__ import annotations

import copy
import json
import random
import sys
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).resolve().parents[2]))

from experiments.faults import campaigns
from experiments.faults.both_checkers import proved
from experiments.faults.certificates import Truth, apart
from experiments.faults.core_mutants import ROUND
from experiments.faults.core_mutants import study_of as written_out
from experiments.faults.section_mutants import CLAIMED, GENERATED, Document, mutated, row
from experiments.shared.missions import generate
from mcpn.certificates import certcheck, corecheck
from mcpn.certificates.core_entry import core_entry
from mcpn.certificates.writing import certificate_of
from mcpn.study import Study

MOST = 10_000
AT_ONCE = 12
"""So many claims are asked of each changed mission."""
OPERATORS = ("not", "and", "or", "EU", "E", "U", "EX", "EG")
NAMELESS = ("begin", "success", "failure", "abort")
"""Roles of which the core mission has no element."""


# Missions and claims.


@cache
def original(which: int) -> tuple[Document, list[Document]]:
    """A core mission, and what its certificate of all states says by formulas, as sections read it."""
    texts = [row(2), row(3, "abort"), row(3, "succeed"), row(4, "site0"), ROUND]
    study = written_out(texts[which]) if which < len(texts) else Study(generate(GENERATED, which))
    core, claims = json.loads(
        json.dumps([core_entry(study.mission_net), certificate_of(study.verdicts(engine="explicit")).claims])
    )
    stated = list[Document]()
    for each in claims:
        kind = "formula" if "formula" in each["statement"] else each["kind"]
        if kind in ("formula", "nominal_success"):
            stated.append(each | {"kind": kind, "evidence": {}})
    return core, stated


def lists_in(value: Any) -> Iterator[list[Any]]:
    """All lists inside of a value."""
    if isinstance(value, list):
        yield value
    for inside in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        yield from lists_in(inside)


def change_claim(claim: Document, other: Document, draw: random.Random) -> None:
    """Changes at one place what a claim states."""
    if draw.random() < 0.3:
        claim["holds"] = not claim["holds"]
        return
    some = draw.choice([*lists_in(claim["statement"])])
    others = [*lists_in(other["statement"])]
    at = draw.randrange(len(some) + 1)
    match draw.randrange(5):
        case 0:
            some.insert(at, copy.deepcopy(draw.choice(draw.choice(others) or [[]])))
        case 1 if some:
            some.pop(at - 1)
        case 2 if some and isinstance(some[at - 1], str):
            words = [each for found in others for each in found if isinstance(each, str)]
            some[at - 1] = draw.choice([*words, *OPERATORS])
        case 3:
            some[:] = ["not", copy.deepcopy(some)]
        case _:
            some[:] = copy.deepcopy(draw.choice(others))


# What is so, section or not.


def states_of(core: Document) -> Document:
    """A net that has a place for each state of a core mission, which says what is so in it."""
    mission = corecheck.CoreMission(core)
    states, numbers = [mission.first], {mission.first: 0}
    transitions = list[Document]()
    for number, state in enumerate(states):  # grows while it is walked
        for happens in sorted(mission.possible(state)):
            for after in mission.after(state, happens):
                if after not in numbers:
                    numbers[after] = len(states)
                    states.append(after)
                name, to = f"t{len(transitions)}", numbers[after]
                transitions.append({"name": name, "event": [*happens], "rank": 0, "read": []})
                transitions[-1] |= {"consume": [number], "produce": [to]}
        if len(states) > MOST:
            raise certcheck.Limit("too many states")
    places = [
        {
            "name": f"s{number}",
            "initial": int(not number),
            "roles": sorted(map(list, mission.says(state))),
        }
        for number, state in enumerate(states)
    ]
    return {"places": places, "transitions": transitions}


def nameless(formula: Any) -> Any:
    """A formula in the words of the core mission."""
    match formula:
        case ["says", role, _] if role in NAMELESS:
            return ["says", role, ""]
        case ["says", "want", element]:
            return ["says", "wait", element]
        case [*parts]:
            return [*map(nameless, parts)]
    return formula


def is_so(truth: Truth, claim: Document) -> bool:
    """Whether what a claim states is so in all states."""
    statement = claim["statement"]
    if "formula" in statement:
        statement = statement | {"formula": nameless(statement["formula"])}
    return truth.holds(claim | {"statement": statement})


# The campaign.


def one(draw: random.Random, second: bool) -> tuple[int, list[str]]:
    """Changes a mission, or claims: how many claims are proved, and what is wrong with that."""
    core, every = copy.deepcopy(original(draw.randrange(15)))
    claims = draw.sample(every, min(AT_ONCE, len(every)))
    if draw.random() < 0.5:
        core = mutated(core, draw)
    else:
        for each in claims:
            if draw.random() < 0.2:
                change_claim(each, draw.choice(every), draw)
    first, other = proved("sections", {"core": core, "sections": CLAIMED | {"claims": claims}}, second)
    if not first | other:
        return 0, []
    truth = Truth(states_of(core))
    found = [each for each in claims if each["key"] in first | other]
    return len(found), apart(first, other) + [each["key"] for each in found if not is_so(truth, each)]


def campaign(of: str, mutants: int, seed: int, second: bool = False) -> tuple[Counter[str], list[str]]:
    """Changes missions and claims; what became of each change, and what was proved wrongly."""
    found, wrong = Counter[str](), list[str]()
    for number in range(mutants):
        some, why = one(random.Random(f"{seed} {number}"), second)
        wrong += [f"{of}: mutant {number} of seed {seed}: {each}" for each in why]
        found["some claim is proved" if some else "nothing is proved"] += 1
        found["claims proved"] += some
    return found, wrong


if __name__ == "__main__":
    sys.exit(campaigns.ran("Mutants of what sections state.", ("stated",), campaign))
