#!/usr/bin/env bash
# Guess: A fault tree tool lists all minimal cut sets, or says that it left some out; the probability that it prints
#   is that of the list.
# Package: Debian 12's scram 0.16.2-3
# Seen: Products of more than 20 events are left out without a word (--limit-order 20 is the default), while the
#   total, 0.11031, counts them: the only product listed has 0.001.
# Source: https://github.com/rakhimov/scram, src/settings.h (limit_order_)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
apt-get download -qq scram=0.16.2-3 libboost-filesystem1.74.0 libboost-program-options1.74.0 libtcmalloc-minimal4 libxml2 libicu72 >/dev/null 2>&1
for file in *.deb; do dpkg -x "$file" root; done
scram() { LD_LIBRARY_PATH=$PWD/root/usr/lib/x86_64-linux-gnu root/usr/bin/scram "$@"; }

{
  echo '<opsa-mef><define-fault-tree name="f"><define-gate name="top"><or><gate name="all"/><basic-event name="x"/></or></define-gate>'
  echo '<define-gate name="all"><and>'
  for i in $(seq 21); do echo "<basic-event name=\"e$i\"/>"; done
  echo '</and></define-gate></define-fault-tree><model-data>'
  for i in $(seq 21); do echo "<define-basic-event name=\"e$i\"><float value=\"0.9\"/></define-basic-event>"; done
  echo '<define-basic-event name="x"><float value="0.001"/></define-basic-event></model-data></opsa-mef>'
} > tree.xml
scram --bdd --probability true tree.xml > report.xml
grep -E "<sum-of-products|<product |<basic-event name" report.xml
grep -q 'products="1" probability="0.11031"' report.xml || { echo "the behaviour has changed"; exit 1; }
