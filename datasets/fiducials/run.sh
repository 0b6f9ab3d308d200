#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The benchmark of fiducial locating: makes the pictures, runs panelcal and OpenCV's methods on them,
# and prints the tables of README.md.
#
# usage: datasets/fiducials/run.sh [BUILD [SET]]; BUILD is configured, SET a folder that is new
set -euo pipefail
source=$(realpath "$(dirname "${BASH_SOURCE[0]}")/../..")
build=$(realpath "${1:-$source/build/release}")
if [ $# -ge 2 ]; then
  set=$2
else
  folder=$(mktemp -d)
  trap 'rm -rf "$folder"' EXIT
  set=$folder/set
fi
ninja -C "$build" -j1 panelcal locate_set >&2
"$build/tools/panelcal" synth --sweep "$source/datasets/fiducials/sweep.toml" -o "$set" >&2
"$build/tests/bench/locate_set" "$set"
