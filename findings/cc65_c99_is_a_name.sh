#!/usr/bin/env bash
# Guess: cc65 with --standard c99 takes a declaration behind a statement, a loop that declares its counter and an initialiser that
#   names its member; and a string may stand beside a const char * behind a question mark.
# Package: Debian 12's cc65 2.19-1 (its compiler says V2.18)
# Seen: The option is taken, and all four are errors: "Variable identifier expected", "Expression expected", "Incompatible pointer
#   types". With declarations at the heads of blocks and an if for the question mark it compiles. So a controller that mcpn writes
#   in C does not, as it stands.
# Source: cc65's manual, --standard (c99: few of its features) and what differs from the standard; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
apt-get download -qq cc65=2.19-1 >/dev/null 2>&1
dpkg-deb -x cc65_*.deb .
export PATH="$work/usr/bin:$PATH"
declare -A text=(
  [declaration]='unsigned char f(unsigned char n) { n = n + 1U; unsigned char s = n; return s; }'
  [loop]='unsigned char f(unsigned char n) { unsigned char s; s = 0U; for (unsigned char i = 0U; i < n; i++) { s = s + i; } return s; }'
  [member]='struct pair { unsigned char a; unsigned char b; }; const struct pair p = { .a = 1U, .b = 2U };'
  [string]='static const char *const names[1] = { "a" }; const char *f(unsigned char n) { return (n < 1U) ? names[n] : ""; }'
)
for name in declaration loop member string; do
  echo "${text[$name]}" > "$name.c"
  if cc65 --standard c99 -t none "$name.c" -o "$name.s" > "$name.txt" 2>&1; then echo "the behaviour has changed: $name"; exit 1; fi
  echo "$name: $(grep -m1 Error "$name.txt")"
done
grep -q "Incompatible pointer types" string.txt || { echo "the behaviour has changed"; exit 1; }
echo 'static const char *const names[1] = { "a" };
const char *f(unsigned char n) { unsigned char s; s = n; { unsigned char t = s; if (t < 1U) { return names[t]; } } return ""; }' > old.c
cc65 --standard c99 -t none old.c -o old.s || { echo "the behaviour has changed"; exit 1; }
echo "declared at the heads of blocks: compiles"
