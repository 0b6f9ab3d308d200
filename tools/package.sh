#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# package.sh: builds the Debian packages into build/release/packages and has lintian read them.
#
# An explained override of lintian stands in share/package/lintian-overrides.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
. tools/setup.sh

packages=$build_dir/packages
step "packages for the build" install_packages build test site package
step "configure" configure
step "build" build all
step "manual" build site
rm -rf "$packages"
step "packages" cmake -E chdir "$build_dir" cpack
step "lintian" lintian --allow-root --fail-on error,warning --tag-display-limit 0 "$packages"/*.deb
ls -l "$packages"/*.deb | awk '{ sub(".*/", "", $9); printf "%-44s %6.1f MB\n", $9, $5 / 1e6 }'
