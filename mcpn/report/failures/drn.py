"""The chain of a mission as a Markov automaton in the DRN text of the model checker Storm.

Each state says its number, the rate at which it is left (0 for a state left in no time, where the edges are a
probabilistic choice), its labels, in a comment what the robot does in it, and one action whose edges have
probabilities. All numbers are exact fractions. The automaton has no choice to make: minimal and maximal
probabilities are equal.

Labels are identifiers, as formulas of Storm need them: ``transect.diving`` runs in states of
``objective_transect_diving``. States in which nothing with a rate can happen any more are labelled
``deadlock``; a loop keeps them.

Source: https://www.stormchecker.org/documentation/background/languages.html#drn
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator
from fractions import Fraction

import numpy as np

from mcpn.answers.causes.whole_chain import WholeChain
from mcpn.answers.verdicts.modes import Situation, situation
from mcpn.mission.static.interval_rates import at_their_means

NOT_OF_NAMES = re.compile(r"\W", re.ASCII)


def drn(chain: WholeChain) -> bytes:
    """The text of a chain with exact rates.

    Args:
        chain: The chain, its rates fractions.

    Returns:
        The text, which :func:`stormpy.build_model_from_drn` reads.
    """
    return "\n".join(_lines(chain)).encode()


def objective_labels(chain: WholeChain) -> dict[str, str]:
    """The label of each objective, by its name."""
    found, taken = dict[str, str](), set[str]()
    for name in chain.running:
        label = base = "objective_" + NOT_OF_NAMES.sub("_", name)
        number = 2
        while label in taken:
            label, number = f"{base}_{number}", number + 1
        taken.add(label)
        found[name] = label
    return found


def _lines(chain: WholeChain) -> Iterator[str]:
    edges = defaultdict[int, defaultdict[int, Fraction]](lambda: defaultdict(Fraction))
    arrays = (chain.sources.tolist(), chain.targets.tolist(), chain.rates.tolist())
    for source, target, rate in zip(*arrays, strict=True):
        edges[source][target] += rate
    labels = objective_labels(chain)
    told = {0: ["init"]} | {state: [] for state in range(1, chain.states)}
    for label, states in (*chain.ends.items(), *((labels[n], states) for n, states in chain.running.items())):
        for state in np.flatnonzero(states).tolist():
            told[state].append(label)
    yield f"// The mission {chain.mission_net.mission.name}: rates per hour."
    if means := at_their_means(chain.mission_net.core):
        yield f"// Rates are {means}."
    for name, label in labels.items():
        yield f"// {label}: the objective {name} runs"
    yield from ("@type: Markov Automaton", "@parameters", "", "@reward_models", "")
    yield from ("@nr_states", str(chain.states), "@nr_choices", str(chain.states), "@model")
    for state in range(chain.states):
        ways = edges[state] or {state: Fraction(1)}
        if not edges[state]:
            told[state].append("deadlock")
        total = sum(ways.values(), Fraction())
        yield " ".join([f"state {state} !{0 if chain.hasty[state] else total}", *told[state]])
        yield f"// {said(situation(chain.mission_net, chain.markings(state)))}"
        yield "\taction 0"
        yield from (f"\t\t{target} : {rate / total}" for target, rate in sorted(ways.items()))
    yield ""


def said(now: Situation) -> str:
    """A state in the words of formulas."""
    listed = {
        "objective": now.objectives,
        "pending": now.pending,
        "done": now.done,
        "refused": now.refused,
        "oos": now.out_of_service,
        "unnoticed": now.unnoticed,
    }
    words = [now.outcome] if now.outcome else []
    words += [f"{kind}({name})" for kind, names in listed.items() for name in names]
    words += [f"alternative({activity})={way}" for activity, way in now.mode.items()]
    words += [f"waiting({activity})={way}" for activity, way in now.waiting.items()]
    words += [f"{fact}={value}" for fact, value in now.facts.items()]
    return " ".join(words)
