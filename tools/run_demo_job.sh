#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# run_demo_job.sh PANELCAL OUT: the main job on datasets/demo with the given program.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
panelcal=$1
out=$2
mkdir -p "$out"
"$panelcal" run datasets/demo/panel.exc \
  -m datasets/demo/machine.toml \
  --images datasets/demo/images \
  --truth datasets/demo/images/truth.json \
  --save-measurements "$out/measurements.jsonl" \
  --report "$out/report.html" \
  -o "$out/corrected.drl"
