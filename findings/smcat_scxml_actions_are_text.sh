#!/usr/bin/env bash
# Guess: state-machine-cat, which reads and writes SCXML, writes the actions of a state (raise, send) and the default
#   transition of a history state as it has read them; or says that it drops them.
# Package: npm state-machine-cat 14.0.8
# Seen: <raise event="x"/> comes back as text, &lt;raise event=&quot;x&quot;/&gt;, which other tools skip or refuse; the
#   transition of <history> is gone. Exit code 0, nothing is said.
# Source: the README of the package, which names scxml as input and as output, and says nothing of either
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init -y >/dev/null
npm install --silent --no-fund state-machine-cat@14.0.8 >npm.log 2>&1 || { cat npm.log; exit 1; }
cat > machine.scxml <<'XML'
<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" initial="a">
  <state id="a"><onentry><raise event="x"/></onentry><transition event="go" target="b"/></state>
  <state id="b"><history id="h" type="deep"><transition target="c"/></history><state id="c"/></state>
</scxml>
XML
npx smcat -I scxml -T scxml machine.scxml -o written.scxml
cat written.scxml
grep -q '&lt;raise event=&quot;x&quot;/&gt;' written.scxml && ! grep -q 'target="c"' written.scxml ||
    { echo "the behaviour has changed"; exit 1; }
