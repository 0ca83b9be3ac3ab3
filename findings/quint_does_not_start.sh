#!/usr/bin/env bash
# Guess: the newest version of a checker's command line starts where it has been installed.
# Package: npm @informalsystems/quint 0.33.1, whose antlr4ts is then 0.5.0-dev
# Seen: "Class extends value undefined is not a constructor or null", whatever it is asked. It asks for antlr4ts
#   ^0.5.0-alpha.4, and 0.5.0-dev, a later word than alpha, fits: another build. With antlr4ts 0.5.0-alpha.4 it starts.
# Source: https://semver.org, 11 (identifiers of pre-releases are compared as text); found by running it with Node.js 20
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init -y >/dev/null
npm install --silent --no-audit --no-fund @informalsystems/quint@0.33.1 >npm.log 2>&1 || { cat npm.log; exit 1; }
grep '"version"' node_modules/antlr4ts/package.json
if npx quint --version >start.txt 2>&1; then echo "the behaviour has changed"; exit 1; fi
grep "TypeError" start.txt
grep -q "Class extends value undefined" start.txt || { echo "the behaviour has changed"; exit 1; }
npm install --silent --no-audit --no-fund antlr4ts@0.5.0-alpha.4 >npm.log 2>&1 || { cat npm.log; exit 1; }
version=$(npx quint --version)
echo "with 0.5.0-alpha.4: $version"
test "$version" = 0.33.1 || { echo "the behaviour has changed"; exit 1; }
