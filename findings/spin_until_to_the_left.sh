#!/usr/bin/env bash
# Guess: p U q U r is p U (q U r), as in most tools of temporal logic.
# Package: Debian 12's spin 6.5.2+dfsg-1
# Seen: It is (p U q) U r: the never claims of the two are the same, that of p U (q U r) is another one.
# Source: https://spinroot.com/spin/Man/ltl.html ; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
apt-get download -qq spin=6.5.2+dfsg-1 >/dev/null 2>&1
for file in *.deb; do dpkg -x "$file" root; done
claim() { root/usr/bin/spin -f "$1" | tail -n +2; }
claim 'p U q U r' > bare
claim '(p U q) U r' > left
claim 'p U (q U r)' > right
head -20 bare
cmp -s bare left && ! cmp -s bare right || { echo "the behaviour has changed"; exit 1; }
