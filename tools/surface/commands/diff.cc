// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <utility>

#include "tools/cli/output_paths.h"
#include "tools/surface/commands/subcommand.h"
#include "tools/surface/difference.h"

namespace panelcal::surface {
namespace {

const std::string kSurfaceDiff = "panelcal surface diff";

}  // namespace

Expected<Answer> diff(const SurfaceOptions& options, CommandContext& context) {
  const std::string& before = options.files.at(0);
  const std::string& after = options.files.at(1);
  PANELCAL_CHECK(check_extension(kSurfaceDiff, options.facts.report, ".html"));
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
  const auto document = [&] {
    return facts::text(difference_facts(maps, provenance_of(context, options.files)));
  };
  return state_facts(
      context, options.facts, "From " + before + " to " + after, document, {difference_text(maps)});
}

}  // namespace panelcal::surface
