#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs the main job on the bundled panel: pictures in, corrected program and report out.
set -euo pipefail
. "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

step "packages" install_packages build
step "configure" configure -DPANELCAL_BUILD_TESTS=OFF
step "build" build panelcal

echo
"$root/tools/run_demo_job.sh" "$build_dir/tools/panelcal" out/demo
echo
echo "corrected program  $root/out/demo/corrected.drl"
echo "report             file://$root/out/demo/report.html"
