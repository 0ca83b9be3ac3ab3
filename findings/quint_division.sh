#!/usr/bin/env bash
# Guess: in Quint, which is written to be translated to TLA+, -7 / 2 is -4 and -7 % 2 is 1, as \div and % of TLA+ round down;
#   and false implies false implies false is true, or refused, as TLA+ refuses it.
# Package: npm @informalsystems/quint 0.33.1 (with antlr4ts 0.5.0-alpha.4, without which it does not start), its TypeScript
#   backend
# Seen: -3 and -1, as C has it, so that a remainder as a number of places in a ring is below 0; and implies binds to the left:
#   false.
# Source: Lamport, Specifying Systems, 18.1 and 15.2.1 (\div, %, precedences); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init -y >/dev/null
npm install --silent --no-audit --no-fund @informalsystems/quint@0.33.1 antlr4ts@0.5.0-alpha.4 >npm.log 2>&1 || { cat npm.log; exit 1; }
cat > numbers.qnt <<'QUINT'
module numbers {
  run isTowardsZero = assert(-7 / 2 == -3 and -7 % 2 == -1 and 7 / -2 == -3)
  run isLeft = assert((false implies false implies false) == false)
  run isDownwardsTest = assert(-7 / 2 == -4)
}
QUINT
npx quint test --backend typescript --match 'isTowardsZero|isLeft' numbers.qnt >kept.txt 2>&1 || { cat kept.txt; exit 1; }
grep passing kept.txt
grep -q "2 passing" kept.txt || { echo "the behaviour has changed"; exit 1; }
if npx quint test --backend typescript --match isDownwardsTest numbers.qnt >down.txt 2>&1; then echo "the behaviour has changed"; exit 1; fi
grep -q "1 failed" down.txt || { cat down.txt; echo "the behaviour has changed"; exit 1; }
