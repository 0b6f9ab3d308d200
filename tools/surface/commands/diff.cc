// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "tools/surface/commands/subcommand.h"
#include "tools/surface/difference.h"

namespace panelcal::surface {
namespace {

const std::string kSurfaceDiff = "panelcal surface diff";

}  // namespace

Expected<Answer> diff(const SurfaceOptions& options, CommandContext& context) {
  const std::string& before = options.files.at(0);
  const std::string& after = options.files.at(1);
  PANELCAL_CHECK(check_extension(kSurfaceDiff, options.plot, ".svg"));
  PANELCAL_TRY(StoredMap earlier, read_zone_of(before, kSurfaceDiff, options));
  PANELCAL_TRY(StoredMap later, read_zone_of(after, kSurfaceDiff, options));
  auto difference = difference_of(earlier, later);
  if (!difference) {
    Diagnostic problem = std::move(difference).error();
    problem.place.file = after;
    return failure(std::move(problem));
  }
  const ComparedMaps maps{
      before, after, std::move(earlier), std::move(later), *std::move(difference)};
  if (!options.plot.empty()) {
    const Provenance provenance = provenance_of(context, options.files);
    PANELCAL_CHECK(write_file(options.plot, difference_svg(maps, provenance)));
  }
  return Answer{options.json ? difference_json(maps) : difference_text(maps)};
}

}  // namespace panelcal::surface
