#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# fuzz.sh SECONDS [excellon|gcode|sieb_meyer|picture|probe_file|map_file]: fuzzes one reader, or all,
# each for that long, as many at once as there are cores. A finding goes to tests/fuzz/fixed/ once
# it is mended.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
seconds=${1:-60}
readers=${2:-excellon gcode sieb_meyer picture probe_file map_file}

# fuzz READER SECONDS. No input may take more than 256 MiB, a picture (up to 4 megapixels) 512; freed
# memory that the sanitizer keeps back would count as well.
fuzz() {
  local reader=$1 found=out/fuzz/$1 most_mb=256
  mkdir -p "$found/corpus"
  # Into files: while a picture is decoded, standard error belongs to the decoder.
  export ASAN_OPTIONS=quarantine_size_mb=8:log_path=$found/asan
  export UBSAN_OPTIONS=log_path=$found/ubsan
  if [ "$reader" = picture ]; then most_mb=512; fi
  "build/asan/tests/fuzz/${reader}_reader_fuzz" "$found/corpus" "tests/fuzz/corpus/$reader" \
    -dict="tests/fuzz/$reader.dict" \
    -max_total_time="$2" -timeout=10 -rss_limit_mb="$most_mb" -artifact_prefix="$found/" \
    -print_final_stats=1 >"$found/log" 2>&1 || {
    echo "$reader: FAILED, the end of $found/log:"
    tail -n 40 "$found/log"
    return 1
  }
  echo "$reader: nothing found in $(grep -o 'number_of_executed_units: [0-9]*' "$found/log" | grep -o '[0-9]*$') inputs"
}
export -f fuzz

# shellcheck disable=SC2086 # the list of readers is split here
printf '%s\n' $readers | xargs -P "$(nproc)" -I{} bash -euo pipefail -c "fuzz {} $seconds"
