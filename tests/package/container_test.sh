#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds the image of share/package/Containerfile on an imported minimal Debian 12, and runs the
# demo's job in it as its ENTRYPOINT does.
#
# usage: container_test.sh PACKAGES SOURCE WORK; as root, with Debian's mirror of this machine. It
# needs neither a daemon nor a registry: buildah works in WORK alone.
set -euo pipefail
packages=$(realpath "$1") source=$(realpath "$2") work=$3
rm -rf "$work"
mkdir -p "$work/job"
work=$(realpath "$work")
trap 'rm -rf --one-file-system "$work/storage" "$work/run" "$work/tree.tar"' EXIT

store=(--root "$work/storage" --runroot "$work/run" --storage-driver vfs)
build() { buildah "$1" "${store[@]}" "${@:2}"; }
say() { printf '%4d s  %s\n' $SECONDS "$*"; }

mmdebstrap --variant=minbase bookworm "$work/tree.tar" >"$work/mmdebstrap.log" 2>&1
tree=$(build from scratch)
build add -q "$tree" "$work/tree.tar" / >"$work/import.log"
build commit -q "$tree" localhost/debian-tree >>"$work/import.log"
say "imported tree"

# The mirror of this machine, for the build alone.
mirror=()
for part in apt.conf.d sources.list sources.list.d; do
  if [ -e "/etc/apt/$part" ]; then mirror+=(-v "/etc/apt/$part:/etc/apt/$part:ro"); fi
done
build bud --isolation chroot --pull=false --build-arg BASE=localhost/debian-tree "${mirror[@]}" -t panelcal \
  -f "$source/share/package/Containerfile" "$packages" >"$work/build.log" 2>&1
say "image built"

entry=$(build inspect --type image --format '{{index .OCIv1.Config.Entrypoint 0}}' panelcal)
[ "$entry" = panelcal ]
cp -r "$source/datasets/demo/." "$work/job"
container=$(build from --pull=false panelcal)
inside() { build run --isolation chroot -v "$work/job:/work" "$container" -- "$@"; }
inside "$entry" run panel.exc -m machine.toml --images images -o corrected.drl --truth images/truth.json >"$work/job.txt" 2>&1
grep -q '990 holes written' "$work/job.txt"
[ "$(grep -c '^X' "$work/job/corrected.drl")" -ge 990 ]
say "the demo's job in the container"

# Neither the packages nor apt's lists are in the image.
[ -z "$(inside find / -xdev -name '*.deb' -print)" ]
[ -z "$(inside find /var/lib/apt/lists -type f -print)" ]
say "nothing of the build stays in the image"
