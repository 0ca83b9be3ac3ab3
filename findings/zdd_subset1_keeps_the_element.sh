#!/usr/bin/env bash
# Guess: subset1(family, v) is one operation in packages of zero-suppressed diagrams: the sets that hold v, without v, as
#   Minato's procedure has it.
# Package: PyPI zdd-algorithms 0.1.5, and oxidd 0.13.0 beside it
# Seen: zdd-algorithms leaves v in: of {1, 2} and {3} it gives {1, 2}, where oxidd gives {2}. A count is the same, so that it is seen
#   only where the result is joined with other sets. union, intersection, difference, subset0, change and count were right in 1,500
#   drawn pairs of families.
# Source: Minato (1993), Zero-suppressed BDDs for set manipulation (Subset1); found by drawing
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q zdd-algorithms==0.1.5 oxidd==0.13.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import zdd_algorithms
from oxidd.zbdd import ZBDDManager

family = zdd_algorithms.to_zdd({frozenset({1, 2}), frozenset({3})})
found = zdd_algorithms.to_set_of_sets(zdd_algorithms.subset1(family, 1))

manager = ZBDDManager(1000, 1000, 1)
manager.add_vars(4)
other = manager.singleton(2).change(1) | manager.singleton(3)
print(found, "oxidd:", other.subset1(1) == manager.singleton(2))
assert other.sat_count(4) == 2 and other.subset1(1) == manager.singleton(2), "the behaviour has changed"
assert found == {frozenset({1, 2})}, "the behaviour has changed"
PYTHON
