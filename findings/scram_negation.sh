#!/usr/bin/env bash
# Guess: The product of "a and not b" is a, not b, and its probability that of the top event.
# Package: Debian 12's scram 0.16.2-3
# Seen: The only product is a, of probability 0.5; the total of the same report is 0.25.
# Source: https://github.com/rakhimov/scram: minimal cut sets unless --prime-implicants; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
apt-get download -qq scram=0.16.2-3 libboost-filesystem1.74.0 libboost-program-options1.74.0 libtcmalloc-minimal4 libxml2 libicu72 >/dev/null 2>&1
for file in *.deb; do dpkg -x "$file" root; done
scram() { LD_LIBRARY_PATH=$PWD/root/usr/lib/x86_64-linux-gnu root/usr/bin/scram "$@"; }

cat > tree.xml <<'XML'
<opsa-mef><define-fault-tree name="f"><define-gate name="top"><and><basic-event name="a"/><not><basic-event name="b"/></not></and></define-gate>
</define-fault-tree><model-data><define-basic-event name="a"><float value="0.5"/></define-basic-event>
<define-basic-event name="b"><float value="0.5"/></define-basic-event></model-data></opsa-mef>
XML
scram --bdd --probability true tree.xml > report.xml
grep -E "<sum-of-products|<product |<basic-event name" report.xml
grep -q 'products="1" probability="0.25"' report.xml && grep -q '<product order="1" probability="0.5"' report.xml ||
  { echo "the behaviour has changed"; exit 1; }
