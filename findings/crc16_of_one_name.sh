#!/usr/bin/env bash
# Guess: "CRC-16" without more is one checksum in packages of checksums, that of IBM's (0xBB3D of "123456789"), and "CCITT" one,
#   that which begins with 0xFFFF (0x29B1), as protocols of instruments name them.
# Package: PyPI crccheck 1.3.1, crcmod-plus 2.3.6 and libscrc 1.8.1
# Seen: Crc16 of crccheck is XMODEM's, 0x31C3; crc-16 of crcmod and ibm of libscrc are IBM's. "CCITT" of crccheck and libscrc is
#   Kermit's, 0x2189, which reflects its bits; 0x29B1 is Crc16CcittFalse and ccitt_false there.
# Source: catalogue of parametrised CRC algorithms (check values; "CRC-CCITT" is an alias of KERMIT); found by running them
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q crccheck==1.3.1 crcmod-plus==2.3.6 libscrc==1.8.1 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import crccheck.crc
import crcmod.predefined
import libscrc

text = b"123456789"
found = {
    "crccheck Crc16": crccheck.crc.Crc16.calc(text),
    "crcmod crc-16": crcmod.predefined.mkCrcFun("crc-16")(text),
    "libscrc ibm": libscrc.ibm(text),
    "crccheck Crc16Ccitt": crccheck.crc.Crc16Ccitt.calc(text),
    "libscrc ccitt": libscrc.ccitt(text),
    "crccheck Crc16CcittFalse": crccheck.crc.Crc16CcittFalse.calc(text),
    "libscrc ccitt_false": libscrc.ccitt_false(text),
}
print({name: f"0x{value:04X}" for name, value in found.items()})
assert list(found.values()) == [0x31C3, 0xBB3D, 0xBB3D, 0x2189, 0x2189, 0x29B1, 0x29B1], "the behaviour has changed"
PYTHON
