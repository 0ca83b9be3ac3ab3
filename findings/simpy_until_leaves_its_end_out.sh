#!/usr/bin/env bash
# Guess: run(until=10) of a simulation takes what happens at 10, as run(till=10) of another does.
# Package: PyPI simpy 4.1.2 and salabim 26.0.9
# Seen: simpy stops before it: what waits until 10 is not done, while the clock says 10; it is done by a step more, or with
#   run(until=10.000001). salabim does it. A deadline that is met at the last instant is missed in one and met in the other.
# Source: simpy's documentation, "Environments" (until, as range() leaves out its end); found by running them
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q simpy==4.1.2 salabim==26.0.9 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import salabim
import simpy

done = []
env = simpy.Environment()


def arrive():
    yield env.timeout(10)
    done.append("simpy")


env.process(arrive())
env.run(until=10)
before = list(done)
env.run(until=10.000001)


class Robot(salabim.Component):
    def process(self):
        yield self.hold(10)
        done.append("salabim")


other = salabim.Environment(yieldless=False)
Robot()
other.run(till=10)
print(before, done, other.now())
assert before == [] and done == ["simpy", "salabim"], "the behaviour has changed"
PYTHON
