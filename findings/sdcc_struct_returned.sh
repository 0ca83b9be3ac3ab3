#!/usr/bin/env bash
# Guess: A C11 compiler that assigns structs also returns them from functions.
# Package: Debian 12's sdcc 4.2.0+dfsg-1 (mcs51)
# Seen: b = a compiles; a function that returns a is error 54, "Function cannot return aggregate".
# Source: SDCC's manual, 1.4 (standards); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
apt-get download -qq sdcc=4.2.0+dfsg-1 sdcc-libraries=4.2.0+dfsg-1 >/dev/null 2>&1
for file in *.deb; do dpkg -x "$file" root; done
PATH=$PWD/root/usr/bin:$PATH
printf 'struct p { int x; int y; };\nstruct p a, b;\nvoid f(void) { b = a; }\n' > assigned.c
printf 'struct p { int x; int y; };\nstruct p a;\nstruct p g(void) { return a; }\n' > returned.c
sdcc -mmcs51 --std-c11 -c assigned.c
if sdcc -mmcs51 --std-c11 -c returned.c > told 2>&1; then echo "the behaviour has changed"; exit 1; fi
cat told
grep -q 'error 54' told || { echo "the behaviour has changed"; exit 1; }
