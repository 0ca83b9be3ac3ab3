#!/usr/bin/env bash
# Guess: In RDDL the brackets of sum_{?x : t} [p(?x)] + 1 end the sum, so that 1 is added once; a => b => c is a => (b => c).
# Package: PyPI pyRDDLGym 2.7
# Seen: The sum takes all that follows: of three objects with p = 2 it is 9, not 7. Each arrow takes what stands before it,
#   so that false => false => false is false. Parentheses around the whole sum end it.
# Source: pyRDDLGym/core/parser/parser.py (the table of precedence); https://github.com/ssanner/rddlsim/issues/10 asks the same
#   of another simulator; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q pyrddlgym==2.7 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import contextlib
import io

from pyRDDLGym.core.compiler.model import RDDLLiftedModel
from pyRDDLGym.core.parser.parser import RDDLParser
from pyRDDLGym.core.simulator import RDDLSimulator

TEXT = """
domain d {{
  types {{ site : object; }};
  pvariables {{
    p(site) : {{ state-fluent, int, default = 2 }};
    n : {{ state-fluent, int, default = 0 }};
    b : {{ state-fluent, bool, default = false }};
    a : {{ action-fluent, bool, default = false }};
  }};
  cpfs {{ p'(?x) = p(?x); n' = {number}; b' = {truth}; }};
  reward = 0;
}}
non-fluents o {{ domain = d; objects {{ site : {{ s1, s2, s3 }}; }}; }}
instance i {{ domain = d; non-fluents = o; max-nondef-actions = 1; horizon = 1; discount = 1.0; }}
"""


def after_one_step(number, truth):
    parser = RDDLParser()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        parser.build()
        simulator = RDDLSimulator(RDDLLiftedModel(parser.parse(TEXT.format(number=number, truth=truth))))
    simulator.reset()
    simulator.step({})
    return int(simulator.subs["n"]), bool(simulator.subs["b"])


found = (
    after_one_step("sum_{?x : site} [p(?x)] + 1", "false => false => false"),
    after_one_step("(sum_{?x : site} [p(?x)]) + 1", "false => (false => false)"),
)
print(*found)
assert found == ((9, False), (7, True)), "the behaviour has changed"
PYTHON
