"""Fault trees in the Open-PSA format as what they mean: the minimal sets of gates, the chances of events."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from itertools import combinations, product
from pathlib import Path
from xml.etree import ElementTree

Sets = frozenset[frozenset[str]]
MOST_SETS = 20_000


def minimal(sets: Iterable[frozenset[str]]) -> Sets:
    """The sets of which no part is one.

    >>> sorted(map(sorted, minimal([frozenset("ab"), frozenset("a"), frozenset("bc")])))
    [['a'], ['b', 'c']]
    """
    kept: list[frozenset[str]] = []
    for each in sorted({*sets}, key=len):
        if not any(smaller <= each for smaller in kept):
            kept.append(each)
    return frozenset(kept)


def fault_tree(path: Path) -> dict[str, list[list[str]] | str]:
    """What a file means: of each gate its minimal sets of basic events, of each of those its expression.

    Args:
        path: A file without negation, as ``causes --openpsa`` writes it.

    Raises:
        ValueError: It has something else, or a gate with more than :data:`MOST_SETS` sets.
    """
    root = ElementTree.parse(path).getroot()
    gates = {gate.attrib["name"]: gate for gate in root.iter("define-gate")}

    @cache
    def of_gate(name: str) -> Sets:
        (formula,) = (part for part in gates[name] if part.tag not in ("label", "attributes"))
        return of(formula)

    def of(formula: ElementTree.Element) -> Sets:
        if formula.tag == "gate":
            return of_gate(formula.attrib["name"])
        if formula.tag == "basic-event":
            return frozenset([frozenset([formula.attrib["name"]])])
        if formula.tag == "constant":
            return frozenset([frozenset[str]()] if formula.attrib["value"] == "true" else [])
        parts = [of(part) for part in formula]
        if formula.tag == "or":
            return minimal(each for part in parts for each in part)
        least = {"and": len(parts), "atleast": int(formula.get("min", 0))}.get(formula.tag)
        if least is None:
            raise ValueError(f"{path}: {formula.tag}: expected no negation")
        found = frozenset[frozenset[str]]()
        for chosen in combinations(parts, least):
            joined = frozenset([frozenset[str]()])
            for part in chosen:
                joined = minimal(one | other for one, other in product(joined, part))
                if len(joined) > MOST_SETS:
                    raise ValueError(f"{path}: more than {MOST_SETS} sets")
            found = minimal([*found, *joined])
        return found

    told: dict[str, list[list[str]] | str] = {
        f"gate {name}": sorted(map(sorted, of_gate(name))) for name in gates
    }
    for event in root.iter("define-basic-event"):
        said = [part for part in event if part.tag not in ("label", "attributes")]
        words = (f"{each.tag} {each.get('value', '')}" for part in said for each in part.iter())
        told[f"event {event.attrib['name']}"] = "; ".join(words)
    return told
