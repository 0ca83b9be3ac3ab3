#!/usr/bin/env bash
# Guess: || in a property is "or", as in PRISM's guards, C and most languages; Storm's own sign for it is |.
# Package: PyPI stormpy 2.0.0
# Seen: Between two temporal formulas it is "given": P=? [F "good" || F "seen"] is the probability of good if seen, 2/3, where
#   "or" is 3/4. Between two labels, P=? [F "good" || "seen"] is read as (F "good") given "seen", and the answer is None, without
#   an error. In parentheses, F ("good" || "seen"), it is a syntax error, and so is &&.
# Source: https://www.stormchecker.org/documentation/background/properties.html (conditional probabilities); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q stormpy==2.0.0 2>pip.log || { cat pip.log; exit 1; }
cat > chain.drn <<'DRN'
@type: DTMC
@parameters

@reward_models

@nr_states
4
@nr_choices
4
@model
state 0 init
	action 0
		1 : 0.5
		2 : 0.25
		3 : 0.25
state 1 good seen
	action 0
		1 : 1
state 2 bad
	action 0
		2 : 1
state 3 bad seen
	action 0
		3 : 1
DRN
venv/bin/python - <<'PYTHON'
import stormpy

chain = stormpy.build_model_from_drn[float]("chain.drn")


def answer(text):
    try:
        (asked,) = stormpy.parse_properties(text)
    except RuntimeError:
        return "syntax error"
    result = stormpy.model_checking(chain, asked)
    return None if result is None else round(result.get_value(0), 6)


questions = ('F "good" | "seen"', 'F "good" || F "seen"', 'F "good" || "seen"', 'F ("good" || "seen")', 'F "good" && F "seen"')
found = [answer(f"P=? [{question}]") for question in questions]
print(*zip(questions, found), sep="\n")
assert found == [0.75, 0.666667, None, "syntax error", "syntax error"], "the behaviour has changed"
PYTHON
