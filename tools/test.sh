#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# test.sh [--strict] [--sanitizers | --nightly] [CTEST OPTION...]: sets up, builds, and runs tests.
#
# Without options: the quick tests; those whose program is missing are skipped, and named at the end.
# The three options stand in any place, and install all programs; all others go to CTest.
# --strict      a skipped test is a failure, as .ci/run wants it
# --sanitizers  the quick tests but for the longest, built by clang with its sanitizers; they find
#               accesses out of bounds
# --nightly     everything, for a timer: also the statistics over many trials, every header and
#               every source by itself, ten minutes of fuzzing a reader; strict. A stage that fails
#               does not stop the next ones; the summary has a line for each. The last result is
#               in tests/bench/README.md.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

strict=()
set_of_tests=quick
purposes=(build test)
for_ctest=()
for option in "$@"; do
  case $option in
    --strict) strict=(--strict) ;;
    --sanitizers) set_of_tests=sanitized ;;
    --nightly)
      set_of_tests=all
      strict=(--strict)
      ;;
    --help | -h)
      sed -n '3,13s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
      exit
      ;;
    *)
      for_ctest+=("$option")
      continue
      ;;
  esac
  purposes=(build test extra site)
done

# A browser, a control or a cluster that shares the cores with other tests can be late. What failed
# is run once more, alone, and named: it may be a race. More than three are not late, they are broken.
run_again_alone() {
  local failed=$1/Testing/Temporary/LastTestsFailed.log
  [ -s "$failed" ] && [ "$(wc -l <"$failed")" -le 3 ] || return 1
  printf '\nfailed beside other tests, once more alone: %s\n' "$(cut -d: -f2 "$failed" | paste -sd' ')"
  (cd "$1" && ctest --rerun-failed --output-on-failure)
}

# run_tests FOLDER [CTEST OPTION...]: the tests that were built in that folder.
run_tests() {
  local folder=$1 results status=0
  results=$log_dir/tests_$(basename "$1").xml
  shift
  rm -f "$results"
  (cd "$folder" && ctest --output-on-failure --no-tests=error -j "$(nproc)" --progress \
    --output-junit "$results" --test-output-size-passed 20000 "$@") || status=$?
  if [ "$status" -eq 8 ]; then # tests failed
    run_again_alone "$folder" && status=0
  fi
  if [ -f "$results" ]; then
    python3 "$root/tools/skipped_tests.py" "$results" "${strict[@]}" || status=1
  fi
  return "$status"
}

test_release() {
  step "configure" configure -DPANELCAL_BUILD_TESTS=ON -DPANELCAL_SLOW_TESTS="$1"
  step "build" build all
  shift
  run_tests "$build_dir" "$@"
}

# They take half of the time with sanitizers. .ci/run leaves them out, --nightly does not: statistics
# of whole nights and plans, whose parts have shorter tests, and what does no more than call programs.
long_with_sanitizers='^(machine\.(TableNights|TrialNights|SurfaceNights)\.|install\.|demo\.survives_kill)'
long_with_sanitizers+='|^machine\.(SurfaceFigures\.AreThose|PlatePicturesTest\.GivesTheTables)'
long_with_sanitizers+='|^machine\.TableRun\.(TheDraft|ALittleMore|AWildLook|FindsTheWarp|ADotsOwn|ALookThatDoesNot|ScatterThat)'
long_with_sanitizers+='|^surface\.ProbePlan\.(NeedsMore|FindsUnsure|SaysWhatCannot|AsksForNothing|KeepsTheTolerance)'
long_with_sanitizers+='|^surface\.SurfaceChoice\.RefusesWhereEvery'
long_with_sanitizers+='|^calib\.TableSelfCalibration\.(StopsBeside|AHalfTurn|AQuarterTurn|WithoutATurn)'
long_with_sanitizers+='|^calib\.(TableSmoother\.AFlatTable|TableFit\.IsSmoother|ChiSquare\.HidesMore|ModelChoice\.FindsTheModel)'
long_with_sanitizers+='|^calib\.(SmoothPanel\.Criterion|VisitingOrder\.IsNeverLonger|ChosenRange\.HoldsNine)'
long_with_sanitizers+='|^program\.CarryArc\.(Strong|TheTrueImage)|^linuxcnc\.real_control'

test_sanitized() {
  step "configure with sanitizers" cmake -S "$root" --preset asan
  step "build with sanitizers" cmake --build "$root/build/asan"
  run_tests "$root/build/asan" --label-exclude slow "$@"
}

# The threads that look at pictures and do jobs; libraries that are not built here are not watched.
test_threads() {
  step "configure with thread sanitizer" cmake -S "$root" --preset tsan -DPANELCAL_WITH_PYTHON=ON
  step "build with thread sanitizer" cmake --build "$root/build/tsan" --target panelcal panelcal_python threads_test
  step "shared objects with thread sanitizer" env TSAN_OPTIONS=ignore_noninstrumented_modules=1 \
    "$root/build/tsan/tests/machine/threads_test"
  step "threads with thread sanitizer" python3 "$root/tests/tools/threads_test.py" \
    "$root/build/tsan/tools/panelcal" "$root"
  # It has to be loaded before Python itself, which it does not watch.
  step "Python module with thread sanitizer" env \
    LD_PRELOAD="$(clang++-16 -print-file-name=libclang_rt.tsan-x86_64.so)" PANELCAL="$build_dir/tools/panelcal" \
    PYTHONPATH="$root/build/tsan/python" TSAN_OPTIONS="ignore_noninstrumented_modules=1 exitcode=66" \
    /usr/bin/python3 -m pytest -q -p no:cacheprovider "$root/tests/python"
  step "batch with thread sanitizer" python3 "$root/tests/tools/batch_test.py" \
    "$root/build/tsan/tools/panelcal" "$root" 0
}

# Other builds compile many sources as one, which hides what a source forgets to include.
test_sources() {
  step "configure without unity" cmake -S "$root" --preset debug
  step "every source by itself" cmake --build "$root/build/debug" --target panelcal
}

# As root: a minimal Debian is made in a folder.
test_packages() {
  "$root/tools/package.sh"
  step "packages in a minimal Debian" "$root/tests/package/minimal_tree_test.sh" \
    "$build_dir/packages" "$root" "$root/out/package"
  step "container image" "$root/tests/package/container_test.sh" "$build_dir/packages" "$root" "$root/out/container"
}

summary=()
n_failed=0

# stage NAME COMMAND...: a part of the night, in a shell of its own, which ends at its first failure.
stage() {
  local name=$1 start=$SECONDS status result=passed
  shift
  set +e
  (
    set -e
    "$@"
  )
  status=$?
  set -e
  if [ "$status" -ne 0 ]; then
    result=failed
    n_failed=$((n_failed + 1))
  fi
  summary+=("$(printf '%-34s %s, %d s' "$name" "$result" $((SECONDS - start)))")
}

test_all() {
  stage "all tests" test_release ON "$@"
  stage "headers" step "every header by itself" build all_verify_interface_header_sets
  stage "sources" test_sources
  stage "tests with sanitizers" test_sanitized "$@"
  stage "threads" test_threads
  stage "Debian packages" test_packages
  stage "fuzzing" step "fuzz each reader for ten minutes" "$root/tools/fuzz.sh" 600
  printf '\nsummary\n'
  printf '%s\n' "${summary[@]}"
  [ "$n_failed" -eq 0 ] || exit 1
}

step "packages" install_packages "${purposes[@]}"
case $set_of_tests in
  quick) test_release OFF --label-exclude slow "${for_ctest[@]}" ;;
  sanitized) test_sanitized --exclude-regex "$long_with_sanitizers" "${for_ctest[@]}" ;;
  all) test_all "${for_ctest[@]}" ;;
esac
