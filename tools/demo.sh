#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# demo.sh [job|nightly]. job: the main job on the bundled panel, pictures in, corrected program and
# report out. nightly: nights in which a simulated machine calibrates itself, three of them shown.
set -euo pipefail
what=${1:-job}
case $what in
  job | nightly) ;;
  *)
    echo "usage: tools/demo.sh [job|nightly]" >&2
    exit 2
    ;;
esac
. "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

step "packages" install_packages build
step "configure" configure -DPANELCAL_BUILD_TESTS=OFF
step "build" build panelcal

echo
if [ "$what" = nightly ]; then
  "$root/tools/run_demo_nightly.sh" "$build_dir/tools/panelcal" "$root/out/nightly"
  echo
  echo "reports            file://$root/out/nightly/reports/"
  exit
fi
"$root/tools/run_demo_job.sh" "$build_dir/tools/panelcal" out/demo
echo
echo "corrected program  $root/out/demo/corrected.drl"
echo "report             file://$root/out/demo/report.html"
