"""A reader of Markov automata in Storm's DRN text, and their exact probabilities by elimination of states.

Written from Storm's description of the format; nothing of mcpn is used. Where stormpy is installed, Storm
judges the same text.
"""

from __future__ import annotations

import shlex
import tempfile
from dataclasses import dataclass, field
from fractions import Fraction


@dataclass
class Automaton:
    """A Markov automaton with one action in each state.

    Args:
        rates: By state the rate at which it is left; 0 of one that is left in no time.
        labels: By state.
        ways: By state the probability of each next one.
    """

    rates: list[Fraction] = field(default_factory=list)
    labels: list[set[str]] = field(default_factory=list)
    ways: list[dict[int, Fraction]] = field(default_factory=list)

    def reaching(self, label: str) -> Fraction:
        """The probability to come, ever, from the initial state to one with a label."""
        (start,) = (state for state, labels in enumerate(self.labels) if "init" in labels)
        goal = {state for state, labels in enumerate(self.labels) if label in labels}
        if start in goal:
            return Fraction(1)
        ways = [{} if state in goal else dict(each) for state, each in enumerate(self.ways)]
        before: list[set[int]] = [set() for _ in ways]
        for state, each in enumerate(ways):
            for target in each:
                before[target].add(state)
        for state in range(len(ways)):
            if state == start or state in goal:
                continue
            own = ways[state].pop(state, Fraction(0))
            before[state].discard(state)
            for source in before[state]:
                share = ways[source].pop(state)
                for target, chance in ways[state].items() if own != 1 else ():
                    ways[source][target] = ways[source].get(target, Fraction(0)) + share * chance / (1 - own)
                    before[target].add(source)
            for target in ways[state]:
                before[target].discard(state)
            ways[state] = {}
        own = ways[start].pop(start, Fraction(0))
        return (
            sum((ways[start][state] for state in ways[start]), Fraction(0)) / (1 - own)
            if own != 1
            else own * 0
        )


def read(text: str) -> Automaton:
    """Reads an automaton, and says what is wrong with it."""
    found = Automaton()
    header, _, body = text.partition("@model\n")
    lines = [line for line in header.splitlines() if line and not line.startswith("//")]
    assert lines[:3] == ["@type: Markov Automaton", "@parameters", "@reward_models"]
    assert (lines[3], lines[5], lines[6]) == ("@nr_states", "@nr_choices", lines[4])
    for line in body.splitlines():
        words = shlex.split(line, comments=False)
        if line.startswith("//"):
            continue
        if words[0] == "state":
            assert int(words[1]) == len(found.rates)
            assert words[2].startswith("!")
            found.rates.append(Fraction(words[2][1:]))
            found.labels.append({*words[3:]})
            found.ways.append({})
        elif words[0] != "action":
            target, colon, chance = words
            assert colon == ":"
            assert int(target) not in found.ways[-1]
            assert all(int(target) > known for known in found.ways[-1]), "columns ascend"
            found.ways[-1][int(target)] = Fraction(chance)
    assert len(found.rates) == int(lines[4])
    assert all(sum(each.values()) == 1 for each in found.ways)
    return found


def judged(text: bytes, label: str) -> Fraction:
    """The probability to come to a label ever, by Storm's engine of exact rationals.

    Raises:
        ImportError: stormpy is not installed.
    """
    import stormpy

    with tempfile.NamedTemporaryFile(suffix=".drn") as file:
        file.write(text)
        file.flush()
        model = stormpy.build_model_from_drn[stormpy.Rational](file.name)
    if not model.labeling.contains_label(label):
        return Fraction(0)
    (asked,) = stormpy.parse_properties(f'Pmax=? [F "{label}"]')
    return Fraction(str(stormpy.model_checking(model, asked).get_value(model.initial_states[0])))
