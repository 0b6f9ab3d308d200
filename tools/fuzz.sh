#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# fuzz.sh SECONDS: fuzzes the program reader. A finding goes to tests/fuzz/fixed/ once it is mended.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
seconds=${1:-60}
found=out/fuzz
mkdir -p "$found/corpus"
# No input may take more than 256 MiB; freed memory that the sanitizer keeps back would count as well.
export ASAN_OPTIONS=quarantine_size_mb=8
build/fuzz/tests/fuzz/excellon_reader_fuzz "$found/corpus" tests/fuzz/corpus/excellon \
  -dict=tests/fuzz/excellon.dict \
  -max_total_time="$seconds" -timeout=10 -rss_limit_mb=256 -artifact_prefix="$found/" \
  -print_final_stats=1
