#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# fuzz.sh SECONDS [excellon|sieb_meyer]: fuzzes one program reader, or both, each for that long. A
# finding goes to tests/fuzz/fixed/ once it is mended.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
seconds=${1:-60}
dialects=${2:-excellon sieb_meyer}
# No input may take more than 256 MiB; freed memory that the sanitizer keeps back would count as well.
export ASAN_OPTIONS=quarantine_size_mb=8
for dialect in $dialects; do
  found=out/fuzz/$dialect
  mkdir -p "$found/corpus"
  "build/fuzz/tests/fuzz/${dialect}_reader_fuzz" "$found/corpus" "tests/fuzz/corpus/$dialect" \
    -dict="tests/fuzz/$dialect.dict" \
    -max_total_time="$seconds" -timeout=10 -rss_limit_mb=256 -artifact_prefix="$found/" \
    -print_final_stats=1
done
