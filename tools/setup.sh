# SPDX-License-Identifier: Apache-2.0
# Sourced by demo.sh and test.sh: packages, build, and quiet steps that show progress.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build_dir=$root/build/release
log_dir=$root/build/log
mkdir -p "$log_dir"

# The leak checker guesses where memory of modules' threads begins, and may guess wrong (clang 16 with
# glibc 2.36: "DTLS ... at 0x3a9e"); without these guesses it checks the rest.
export ASAN_OPTIONS=intercept_tls_get_addr=0

# step NAME COMMAND...: one line a step; the command's output goes to a log, shown if it fails. A
# terminal shows the last line of it, a file or a pipe the percentage every ten seconds.
step() {
  local name=$1 log start=$SECONDS shown=$SECONDS pid status=0
  shift
  log=$log_dir/$(echo "$name" | tr -c 'a-z0-9\n' '_').log
  "$@" >"$log" 2>&1 </dev/null &
  pid=$!
  while kill -0 "$pid" 2>/dev/null; do
    if [ -t 1 ]; then
      printf '\r\033[2K%-34s %s' "$name" "$(tail -n 1 "$log" | cut -c 1-42)"
    elif [ $((SECONDS - shown)) -ge 10 ]; then
      shown=$SECONDS
      printf '%-34s %s%d s\n' "$name" "$(percent_of "$log")" $((SECONDS - start))
    fi
    sleep 0.2
  done
  wait "$pid" || status=$?
  [ ! -t 1 ] || printf '\r\033[2K'
  [ "$status" -eq 0 ] || fail "$name" "$log" "$status"
  printf '%-34s done, %d s\n' "$name" $((SECONDS - start))
}

# percent_of LOG: "42 %, " from the last "[ 42%]" of a build or the last "12/345 Test" of a test run.
percent_of() {
  tail -n 50 "$1" | awk '
    match($0, /^\[ *[0-9]+%\]/) { percent = substr($0, 2) + 0 }
    match($0, /[0-9]+\/[0-9]+ +Test/) {
      split(substr($0, RSTART, RLENGTH), n, "[/ ]")
      percent = int(100 * n[1] / n[2])
    }
    END { if (percent != "") printf "%d %%, ", percent }'
}

fail() {
  printf '%s FAILED (exit %s). The end of %s:\n' "$1" "$3" "$2" >&2
  tail -n 40 "$2" >&2
  exit 1
}

packages_for() {
  awk -v wanted=" $* " '!/^#/ && NF == 2 && index(wanted, " " $1 " ") { print $2 }' \
    "$root/tools/packages.txt"
}

missing_packages() {
  local package
  for package in $(packages_for "$@"); do
    dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed || echo "$package"
  done
}

# install_packages PURPOSE...: installs what is missing, as root or through sudo. Another
# installation, as a machine's own update, is waited for.
install_packages() {
  local missing as_root=()
  missing=$(missing_packages "$@")
  [ -n "$missing" ] || return 0
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || {
      echo "These packages are missing, and there is no sudo to install them:" $missing
      return 1
    }
    as_root=(sudo)
  fi
  "${as_root[@]}" apt-get update
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get -o DPkg::Lock::Timeout=300 install -y --no-install-recommends $missing
}

configure() { (cd "$root" && cmake --preset release "$@"); }
build() { NINJA_STATUS='[%p] ' cmake --build "$build_dir" --target "$@"; }
