#!/usr/bin/env bash
# Guess: In the parallel composition of two parts of a plant an event is uncontrollable if it is so in one of them, or the parts are
#   refused where they disagree; and composition is commutative.
# Package: PyPI faudes 2.34.5 (Python's binding of libFAUDES)
# Seen: The second operand alone says whether an event that both have is controllable, in Parallel and in Product. So a supervisor that
#   forbids the event is found or not by the order in which the parts of the plant are composed.
# Source: found by running both orders; https://fgdes.tf.fau.de/faudes/ (CoreFaudes, "Parallel": attributes)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q faudes==2.34.5 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import faudes


def part(controllable):
    plant = faudes.System()
    plant.InsEvent("u")
    (plant.SetControllable if controllable else plant.ClrControllable)("u")
    plant.InsState("1")
    plant.InsState("2")
    plant.SetTransition("1", "u", "2")
    plant.SetInitState("1")
    plant.SetMarkedState("1")
    plant.SetMarkedState("2")
    return plant


def never_u():
    specification = faudes.System()
    specification.InsEvent("u")
    specification.InsState("1")
    specification.SetInitState("1")
    specification.SetMarkedState("1")
    return specification


found = {}
for first in (False, True):
    for second in (False, True):
        whole, product, supervisor = faudes.System(), faudes.System(), faudes.System()
        faudes.Parallel(part(first), part(second), whole)
        faudes.Product(part(first), part(second), product)
        faudes.SupCon(whole, never_u(), supervisor)
        found[first, second] = whole.Controllable("u"), product.Controllable("u"), int(supervisor.Size())
print(found)
no, yes = (False, False, 0), (True, True, 1)
assert found == {(False, False): no, (True, False): no, (False, True): yes, (True, True): yes}, "the behaviour has changed"
PYTHON
