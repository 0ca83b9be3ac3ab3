#!/usr/bin/env bash
# Guess: spin -f knows the weak until W, or refuses it as a syntax error, as it does X.
# Package: Debian 12's spin 6.5.2+dfsg-1
# Seen: "(p W q)" becomes one proposition of that name: the automaton is that of a state formula, and asserts !((p W
#   q)). "X p" is refused, since Debian's build leaves the operator out (-DNXT).
# Source: https://spinroot.com/spin/Man/ltl.html ; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
apt-get download -qq spin=6.5.2+dfsg-1 >/dev/null 2>&1
for file in *.deb; do dpkg -x "$file" root; done
root/usr/bin/spin -f '(p W q)' | tee automaton
grep -qF 'assert(!((p W q)))' automaton || { echo "the behaviour has changed"; exit 1; }
if root/usr/bin/spin -f 'X p' > refused 2>&1; then :; fi
cat refused
grep -q "saw 'X'" refused || { echo "the behaviour has changed"; exit 1; }
