#!/usr/bin/env bash
# Guess: A static assertion that does not hold ends the compilation, as the C standard asks.
# Package: Debian 12's sdcc 4.2.0+dfsg-1 (mcs51)
# Seen: It is warning 215 and exit code 0; the object file is written.
# Source: ISO C11 6.7.10; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
apt-get download -qq sdcc=4.2.0+dfsg-1 sdcc-libraries=4.2.0+dfsg-1 >/dev/null 2>&1
for file in *.deb; do dpkg -x "$file" root; done
PATH=$PWD/root/usr/bin:$PATH
cat > a.c <<'C'
_Static_assert(sizeof(int) == 4, "int is wide");
int one(void) { return 1; }
C
sdcc -mmcs51 --std-c11 -c a.c 2>&1 | tee told
test -e a.rel
grep -q 'warning 215: static assertion failed' told || { echo "the behaviour has changed"; exit 1; }
