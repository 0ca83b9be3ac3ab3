#!/usr/bin/env bash
# Guess: the library for UMB, the binary format of model checkers, writes exact probabilities of any size, for it takes Python's
#   fractions and the format allows rational numbers of 128, 256, 384 bits and so on; and a state whose branches add up to less
#   than 1 is refused as the model is validated.
# Package: PyPI umbi 0.2.5 (the last for Python 3.11; 0.2.14 has the same sizes), and stormpy 2.0.0, which reads the files
# Seen: Numerators and denominators of 64 bits are all that it writes: 1/2^64, or a probability with 20 digits, is an OverflowError
#   that names no number. What it writes Storm reads exactly. 3/10 and 3/10 from one state are valid, and Storm takes them.
# Source: umbi/umb/index/transition_system.py (sizes that are a multiple of 128), binary/sized_type.py (128 bits, always);
#   ats/explicit_ats.py (the sum is left to be checked); found by running both
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q umbi==0.2.5 stormpy==2.0.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from fractions import Fraction

import stormpy
from umbi.ats import ExplicitAts, TimeType, write


def reached(first, second):
    """The probability, as Storm says it, that a chain goes by the first branch of its first state."""
    chain = ExplicitAts()
    chain.time = TimeType.DISCRETE
    for branches in ([(1, first), (2, second)], [(1, Fraction(1))], [(2, Fraction(1))]):
        choice = chain.add_state_choice(state=chain.add_state())
        for target, probability in branches:
            choice.add_branch(target=target, prob=probability)
    chain.num_initial_states = 1
    chain.set_initial_states([0])
    chain.add_ap_annotation(name="good").set_state_values([False, True, False])
    chain.validate()
    try:
        write(chain, "chain.umb")
    except OverflowError as error:
        return type(error).__name__
    model = stormpy.build_model_from_umb("chain.umb")
    (asked,) = stormpy.parse_properties('P=? [F "good"]')
    return str(stormpy.model_checking(model, asked).get_value(model.initial_states[0]))


found = {
    "1/3": reached(Fraction(1, 3), Fraction(2, 3)),
    "1/2^63": reached(Fraction(1, 2**63), 1 - Fraction(1, 2**63)),
    "1/2^64": reached(Fraction(1, 2**64), 1 - Fraction(1, 2**64)),
    "20 digits": reached(Fraction("0.12345678901234567891"), 1 - Fraction("0.12345678901234567891")),
    "3/10 and 3/10": reached(Fraction(3, 10), Fraction(3, 10)),
}
print(found)
overflow = "OverflowError"
assert found == {
    "1/3": "1/3", "1/2^63": f"1/{2**63}", "1/2^64": overflow, "20 digits": overflow, "3/10 and 3/10": "3/10",
}, "the behaviour has changed"
PYTHON
