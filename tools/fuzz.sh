#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# fuzz.sh SECONDS [excellon|gcode|sieb_meyer|picture|probe_file|map_file]: fuzzes one reader, or all,
# each for that long. A finding goes to tests/fuzz/fixed/ once it is mended.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
seconds=${1:-60}
dialects=${2:-excellon gcode sieb_meyer picture probe_file map_file}
# No input may take more than 256 MiB, a picture (up to 4 megapixels) 512; freed memory that the
# sanitizer keeps back would count as well.
for dialect in $dialects; do
  found=out/fuzz/$dialect
  mkdir -p "$found/corpus"
  # Into files: while a picture is decoded, standard error belongs to the decoder.
  export ASAN_OPTIONS=quarantine_size_mb=8:log_path=$found/asan
  export UBSAN_OPTIONS=log_path=$found/ubsan
  most_mb=256
  if [ "$dialect" = picture ]; then most_mb=512; fi
  "build/asan/tests/fuzz/${dialect}_reader_fuzz" "$found/corpus" "tests/fuzz/corpus/$dialect" \
    -dict="tests/fuzz/$dialect.dict" \
    -max_total_time="$seconds" -timeout=10 -rss_limit_mb="$most_mb" -artifact_prefix="$found/" \
    -print_final_stats=1
done
