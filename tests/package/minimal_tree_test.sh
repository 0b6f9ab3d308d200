#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs the packages into a minimal Debian 12, runs the demo's job there, builds the example of
# the library against libpanelcal-dev, and removes everything again: nothing may stay behind.
#
# usage: minimal_tree_test.sh PACKAGES SOURCE WORK; as root, with Debian's mirror of this machine
set -euo pipefail
# What is mounted here ends with this script.
if [ -z "${PANELCAL_OWN_MOUNTS:-}" ]; then
  exec env PANELCAL_OWN_MOUNTS=1 unshare --mount "$0" "$@"
fi
packages=$(realpath "$1") source=$(realpath "$2") work=$3
tree=$work/tree
rm -rf "$work"
mkdir -p "$work"
trap 'umount -q "$tree/proc"; rm -rf --one-file-system "$tree"' EXIT

inside() { chroot "$tree" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"; }
install_packages() { inside sh -c "apt-get install -y --no-install-recommends $*" >>"$work/apt.log" 2>&1; }
say() { printf '%4d s  %s\n' $SECONDS "$*"; }

mmdebstrap --variant=minbase bookworm "$tree" >"$work/mmdebstrap.log" 2>&1
rm -rf "$tree"/etc/apt/sources.list*
cp -r /etc/apt/apt.conf.d /etc/apt/sources.list* "$tree/etc/apt/"
mount -t proc proc "$tree/proc"
cp /etc/resolv.conf "$tree/etc/resolv.conf"
mkdir "$tree/packages"
cp "$packages"/*.deb "$tree/packages"
inside apt-get update >"$work/apt.log" 2>&1
say "minimal tree"

install_packages ./packages/panelcal_*.deb
say "panelcal installed"
cp -r "$source/datasets/demo" "$tree/tmp/demo"
start=$(date +%s)
inside sh -c 'cd /tmp/demo && panelcal run panel.exc -m machine.toml --images images -o /tmp/corrected.drl --truth images/truth.json --report /tmp/report.html' >"$work/job.txt" 2>&1
taken=$(($(date +%s) - start))
grep -q '990 holes written' "$work/job.txt"
say "the demo's job, in $taken s"
[ "$taken" -lt 60 ]
size_kb=$(inside dpkg-query -W -f='${Installed-Size}' panelcal)
say "panelcal takes $size_kb KB"
[ "$size_kb" -le 40000 ]

# What is not installed is named.
if inside panelcal serve -m /tmp/demo/machine.toml --machine-driver sim --jobs /tmp/jobs >"$work/serve.txt" 2>&1; then
  echo "serve runs without its module"
  exit 1
fi
grep -q 'the Debian package panelcal-serve has it' "$work/serve.txt"

install_packages ./packages/*.deb g++ cmake ninja-build pkg-config
say "all packages and a compiler installed"
cp -r "$source/tests/install/consumer" "$tree/tmp/consumer"
inside sh -c 'cmake -S /tmp/consumer -B /tmp/build -G Ninja && cmake --build /tmp/build' >"$work/consumer.log" 2>&1
inside sh -c 'cd /tmp/demo && /tmp/build/consumer panel.exc machine.toml images' >"$work/holes.txt"
[ "$(grep -c '^T[0-9]* X' "$work/holes.txt")" -eq 990 ]
say "the library's example built and run"

inside sh -c 'cd /tmp/demo && python3 -c "
import panelcal
machine = panelcal.read_machine(\"machine.toml\")
job = panelcal.correct(panelcal.read_program(\"panel.exc\", machine), machine, images=\"images\")
print(len(job.holes.actual_mm))"' >"$work/python.txt"
[ "$(cat "$work/python.txt")" -eq 990 ]
say "the Python module run"

inside apt-get purge -y panelcal panelcal-cameras panelcal-serve panelcal-postgresql python3-panelcal libpanelcal-dev panelcal-doc >>"$work/apt.log" 2>&1
if (cd "$tree" && find . -xdev -path ./packages -prune -o -path ./tmp -prune -o -name '*panelcal*' -print) | grep .; then
  echo "these stay behind"
  exit 1
fi
say "removed, nothing of it stays"
