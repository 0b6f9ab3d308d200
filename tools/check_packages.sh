#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Fails if the release build read a header of a package that tools/packages.txt does not bring. A
# machine with leftovers would hide that.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

listed=$(packages_for build test extra bench)
brought=$(apt-cache depends --recurse --installed --no-recommends --no-suggests --no-conflicts \
  --no-breaks --no-replaces --no-enhances $listed | awk '/^[a-z0-9]/ { print $1 }' | sort -u)
headers=$(ninja -C "$build_dir" -t deps | awk '/^    \/usr\// { print $1 }' | sort -u)
[ -n "$headers" ] || { echo "no headers recorded: build first" >&2; exit 1; }
# What was built with a package that is gone since then is built anew before it is used.
used=$(echo "$headers" | { xargs -r realpath -eq || true; } | sort -u | xargs -r dpkg-query -S |
  cut -d ' ' -f 1 | sed 's/[:,].*//' | sort -u)
missing=$(comm -13 <(echo "$brought" | sed 's/:.*//' | sort -u) <(echo "$used" | sort -u))
if [ -n "$missing" ]; then
  echo "the build uses packages that tools/packages.txt does not bring:" $missing >&2
  exit 1
fi
echo "$(echo "$used" | wc -l) packages used, all of them brought by tools/packages.txt"
