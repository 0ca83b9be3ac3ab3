#!/usr/bin/env bash
# Guess: Tables of 90,000 bytes in `__flash`, none above 32,767, are read rightly on an ATmega2560, which
#   has 256 KiB of flash; or the compiler or the linker refuses them.
# Package: Debian 12's gcc-avr 1:5.4.0+Atmel3.6.2-3, avr-libc 1:2.0.0+Atmel3.6.2-3, simavr 1.6+dfsg-3
# Seen: It compiles and links without a word under -Wall -Wextra, and the table that lies beyond 64 KiB
#   reads other bytes (A below: wrong, B: right). With `__memx` in place of `__flash` all are right.
# Source: GCC's manual, "AVR Named Address Spaces": pointers to __flash have 16 bits; nothing checks it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
apt-get download -qq gcc-avr=1:5.4.0+Atmel3.6.2-3 binutils-avr=2.26.20160125+Atmel3.6.2-4 \
    avr-libc=1:2.0.0+Atmel3.6.2-3 simavr=1.6+dfsg-3 libsimavr2=1.6+dfsg-3 libelf1 >/dev/null 2>&1
for file in *.deb; do dpkg -x "$file" root; done
export PATH=$PWD/root/usr/bin:$PATH LD_LIBRARY_PATH=$PWD/root/usr/lib/x86_64-linux-gnu
cat > tables.c <<'C'
#include <avr/io.h>
#include <stdint.h>
#define TEN(x) x, x, x, x, x, x, x, x, x, x
#define TABLE(x) {TEN(TEN(TEN(TEN(x)))), TEN(TEN(TEN(TEN(x)))), TEN(TEN(TEN(TEN(x))))}
const SPACE uint8_t first[30000] = TABLE(11);
const SPACE uint8_t second[30000] = TABLE(22);
const SPACE uint8_t third[30000] = TABLE(33);
static void tell(char sign) { while (!(UCSR0A & (1 << UDRE0))) {} UDR0 = sign; }
int main(void)
{
    volatile uint16_t last = 29999;
    UCSR0B = 1 << TXEN0;
    tell((char)('A' + (first[last] == 11)));
    tell((char)('A' + (second[last] == 22)));
    tell((char)('A' + (third[last] == 33)));
    tell('\n');
    __asm__ volatile("cli\n\tsleep");
    return 0;
}
C
read_back() {
    avr-gcc -DSPACE="$1" -mmcu=atmega2560 -Os -Wall -Wextra -Werror tables.c -o tables.elf
    timeout 60 simavr -m atmega2560 -f 16000000 tables.elf 2>&1 | grep -o '[AB]\{3\}'
}
near=$(read_back __flash) far=$(read_back __memx)
echo "__flash: $near, __memx: $far"
[ "$near" = ABB ] && [ "$far" = BBB ] || { echo "the behaviour has changed"; exit 1; }
