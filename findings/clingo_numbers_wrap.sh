#!/usr/bin/env bash
# Guess: a number that clingo cannot hold is refused, as it is where it compares a sum; or it is held whole: times in
#   milliseconds, costs in euro cents.
# Package: PyPI clingo 5.8.3
# Seen: The lowest 32 bits are taken, without a word. 3000000000 in the text is -1294967296, and so is 3000000 * 1000: what is due
#   later than 2000000000 is not late. Asked for the cheaper of two ways, one for 5 and one for 3000000000, it chooses the latter.
#   Two costs of 2000000000 are -294967296 in the sum that it minimises; the same sum, compared with a bound, is an error.
# Source: found by running it; clingo's Symbol holds a number as an int of C
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q clingo==5.8.3 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import clingo


def best(program):
    # The last model, which is the best one, and what it costs.
    models = []
    control = clingo.Control(logger=lambda code, message: models.append(message))
    control.add("base", [], program)
    control.ground([("base", [])])
    control.solve(on_model=lambda model: models.append((sorted(map(str, model.symbols(shown=True))), list(model.cost))))
    return models[-1]


found = {
    "number": best("due(3000000000)."),
    "product": best("due(3000000 * 1000). late :- due(T), T > 2000000000."),
    "choice": best("1 {way(cheap; dear)} 1. #minimize {5 : way(cheap); 3000000000 : way(dear)}."),
    "sum": best("{leg(1..2)} = 2. #minimize {2000000000, L : leg(L)}."),
}
try:
    best("{leg(1..2)} = 2. :- #sum {2000000000, L : leg(L)} > 2100000000.")
except RuntimeError as error:
    found["compared"] = str(error).rpartition(": ")[2]
print(*found.items(), sep="\n")
assert found["number"][0] == found["product"][0] == ["due(-1294967296)"], "the behaviour has changed"
assert found["choice"] == (["way(dear)"], [-1294967296]), "the behaviour has changed"
assert found["sum"] == (["leg(1)", "leg(2)"], [-294967296]), "the behaviour has changed"
assert "overflow" in found["compared"], "the behaviour has changed"
PYTHON
