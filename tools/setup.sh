# SPDX-License-Identifier: Apache-2.0
# Sourced by demo.sh and test.sh: packages, build, and quiet steps that show progress.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build_dir=$root/build/release
log_dir=$root/build/log
mkdir -p "$log_dir"

# step NAME COMMAND...: one line a step; the command's output goes to a log, shown if it fails.
step() {
  local name=$1 log start
  shift
  log=$log_dir/$(echo "$name" | tr -c 'a-z0-9\n' '_').log
  start=$SECONDS
  if [ -t 1 ]; then
    "$@" >"$log" 2>&1 </dev/null &
    local pid=$! status=0
    while kill -0 "$pid" 2>/dev/null; do
      printf '\r\033[2K%-34s %s' "$name" "$(tail -n 1 "$log" | cut -c 1-42)"
      sleep 0.5
    done
    wait "$pid" || status=$?
    printf '\r\033[2K'
    [ "$status" -eq 0 ] || fail "$name" "$log" "$status"
  else
    "$@" >"$log" 2>&1 </dev/null || fail "$name" "$log" $?
  fi
  printf '%-34s done, %d s\n' "$name" $((SECONDS - start))
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

# install_packages PURPOSE...: installs what is missing, as root or through sudo.
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
    apt-get install -y --no-install-recommends $missing
}

configure() { (cd "$root" && cmake --preset release "$@"); }
build() { NINJA_STATUS='[%p] ' cmake --build "$build_dir" --target "$@"; }
