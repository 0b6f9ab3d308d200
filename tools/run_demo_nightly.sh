#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# run_demo_nightly.sh PANELCAL OUT: nights of the simulated machine of examples/nightly. Twenty quiet
# ones come first, so that there is something to compare with; three are shown.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
panelcal=$(realpath "$1")
out=$2
rm -rf "$out"
mkdir -p "$out"
cp "$here/examples/nightly/machine.toml" "$here/examples/nightly/camera.cal.json" "$out"
cd "$out"

# night DAY X_UM: the camera stands X_UM from where it stood on the first night. A night whose result
# is refused exits with 1.
night() {
  local x
  x=$(awk -v um="$2" 'BEGIN { printf "%.4f", 45.012 + um / 1000 }')
  sed -i "s/^spindle_camera_offset_mm = .*/spindle_camera_offset_mm = [$x, -2.991]/" machine.toml
  local status=0
  "$panelcal" -q nightly -m machine.toml --by demo --clock "$(date -u -d "2026-11-01 $1 days" +%FT02:00:00Z)" \
    >night.txt || status=$?
  [ "$status" -le 1 ] || exit "$status"
  echo "exit code $status" >>night.txt
}

show() {
  printf '\n%s\n' "$1"
  sed 's/^/  /' night.txt
}

for day in $(seq 0 19); do night "$day" 0; done
night 20 0
show "a quiet night"
for step in 1 2 3 4 5; do night $((20 + step)) "$(awk -v n="$step" 'BEGIN { print 1.6 * n }')"; done
show "the fifth night of a drift of 1.6 um a night"
night 26 80
show "the camera was displaced by 72 um"
