#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Sets up, builds and runs all tests. With SLOW=OFF those that are labelled slow are not even built.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

step "packages" install_packages build test extra
step "configure" configure -DPANELCAL_BUILD_TESTS=ON \
  -DPANELCAL_SLOW_TESTS="${SLOW:-ON}"
step "build" build all
cd "$build_dir"
ctest --output-on-failure --no-tests=error -j "$(nproc)" --progress "$@"
