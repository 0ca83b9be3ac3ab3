#!/usr/bin/env bash
# Guess: A struct of an enumeration and three bytes is 8 bytes on any 32-bit target, as on RISC-V and MIPS.
# Package: Debian 12's gcc-arm-none-eabi 15:12.2.rel1-1
# Seen: It is 4: on bare ARM an enumeration takes as few bytes as its values need. With
#   -fno-short-enums it is 8.
# Source: ARM's procedure call standard, 7.1.3; GCC's manual, -fshort-enums
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
apt-get download -qq gcc-arm-none-eabi=15:12.2.rel1-1 binutils-arm-none-eabi >/dev/null 2>&1
for file in *.deb; do dpkg -x "$file" root; done
export PATH=$PWD/root/usr/bin:$PATH LD_LIBRARY_PATH=$PWD/root/usr/lib/x86_64-linux-gnu
cat > size.c <<'C'
enum kind { one, two };
struct part { enum kind kind; unsigned char a, b, c; };
int as_expected[sizeof(struct part) == SIZE ? 1 : -1];
C
gcc=$(ls root/usr/bin/arm-none-eabi-gcc)
"$gcc" -mcpu=cortex-m0 -DSIZE=4 -S size.c -o /dev/null || { echo "the behaviour has changed"; exit 1; }
"$gcc" -mcpu=cortex-m0 -DSIZE=8 -fno-short-enums -S size.c -o /dev/null || { echo "the behaviour has changed"; exit 1; }
if "$gcc" -mcpu=cortex-m0 -DSIZE=8 -S size.c -o /dev/null 2>told; then echo "the behaviour has changed"; exit 1; fi
echo "4 bytes, 8 with -fno-short-enums"
