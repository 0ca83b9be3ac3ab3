#!/usr/bin/env bash
# Guess: an event that an inner state and the state around it both take goes to the inner one, which changes within the outer:
#   the machine is then in Outer.Near, as in SCXML.
# Package: PyPI harel 0.9.0
# Seen: It goes to the inner one, and the machine says that it is in Outer, and in no state within it: Near has no transition of
#   its own, so it is taken for an end, and its state is over. One transition out of Near, which no event of the run takes, and it
#   is in Outer.Near. Adding an edge to a chart changes the configurations before that edge.
# Source: W3C SCXML, 3.13 (only final ends a state); harel/definition/validate.py (a leaf with no outgoing transition); found by
#   running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q harel==0.9.0 2>pip.log || { cat pip.log; exit 1; }
for edge in "" "from Near to Inner on Other"; do
  cat > chart.stm <<STM
event Go {}
event Other {}
machine chart {
  initial Outer
  state Outer {
    initial Inner
    state Inner {}
    state Near {}
    from Inner to Near on Go
    $edge
  }
  final Done success
  from Outer to Done on Go
}
STM
  venv/bin/harel validate chart.stm
  venv/bin/harel run chart.stm -e Go | grep -- "->" | tail -1 | tee -a found.txt
done
test "$(tr -s ' ' < found.txt | tr '\n' ';')" = "Go -> Outer;Go -> Outer.Near;" || { echo "the behaviour has changed"; exit 1; }
