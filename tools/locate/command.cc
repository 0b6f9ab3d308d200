// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calib/base/executor.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/thread_pool.h"
#include "machine/config/machine_config.h"
#include "tools/cli/commands.h"
#include "tools/locate/answer.h"
#include "tools/locate/located_json.h"
#include "tools/locate/overlay_paths.h"
#include "tools/locate/search.h"
#include "tools/locate/suggest_command.h"
#include "vision/locate/locate.h"
#include "vision/picture/files/image_io.h"
#include "vision/picture/picture_form.h"
#include "vision/show/overlay.h"
#include "vision/suggest/common_scale.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using Path = std::filesystem::path;
using internal::locate_usage;

/// One call of the command: what is looked for, how, and where the overlays go.
struct Search : TargetSearch {
  std::vector<Path> overlays;  ///< of the images, or empty
};

Expected<Search> prepare(const LocateCommandOptions& options, const CommandContext& context) {
  PANELCAL_TRY(const MachineConfig config, read_machine_config(options.machine));
  PANELCAL_TRY(TargetSearch target, target_search(config, *options.tool));
  Search search{std::move(target), {}};
  if (!options.at_px.empty()) {
    const double x_px = options.at_px[0];
    const double y_px = options.at_px[1];
    if (!std::isfinite(x_px) || !std::isfinite(y_px) || !(*options.radius_px >= 1) ||
        !std::isfinite(*options.radius_px)) {
      return failure(locate_usage(
          fmt::format(
              "--at {},{} --radius {} is no place to search", x_px, y_px, *options.radius_px),
          "numbers, and a radius of at least 1 px"));
    }
    search.options.search_center = position_px<frame::Image>(Eigen::Vector2d(x_px, y_px));
    search.options.search_radius = px(*options.radius_px);
  }
  if (!options.overlay.empty()) {
    PANELCAL_TRY(search.overlays, internal::make_overlay_paths(options, context));
  }
  return search;
}

/// A target's middle is in its picture, so a place elsewhere is a mistake.
Expected<void> check_place(const std::string& file, const Image& image, const Search& search) {
  if (!search.options.search_center) return {};
  const Eigen::Vector2d& at_px = search.options.search_center->in_px();
  const double right_px = image.width() - 0.5;
  const double bottom_px = image.height() - 0.5;
  if (at_px.x() >= -0.5 && at_px.x() <= right_px && at_px.y() >= -0.5 && at_px.y() <= bottom_px) {
    return {};
  }
  return failure({Code::PictureMismatch,
                  {file, 0, 0},
                  fmt::format("--at {},{} is outside of the picture", at_px.x(), at_px.y()),
                  fmt::format("a place in its {} x {} px", image.width(), image.height())});
}

Expected<std::string> overlay_of(const std::string& file,
                                 const Image& image,
                                 const Detection& detection,
                                 const Search& search) {
  const OverlayOptions overlay{.min_side = 640,
                               .title = fmt::format("{}, vision tool {}: {}",
                                                    Path(file).filename().string(),
                                                    search.target.number,
                                                    name(search.target.shape)),
                               .search_center = search.options.search_center,
                               .search_radius = search.options.search_radius};
  return encode_overlay(image, detection, overlay);
}

/// The result of one picture, as it is written.
struct Located {
  facts::Json row;
  std::string overlay_png;  ///< empty: none is asked for
  Detection detection;
};

/// Locates the target in one picture; called on several threads.
Expected<Located> locate_one(const std::string& file,
                             const LocateCommandOptions& options,
                             const Search& search) {
  PANELCAL_TRY(Image image, read_image(file));
  image = understood(std::move(image), search.form);
  PANELCAL_CHECK(check_picture_size(file, image, search));
  PANELCAL_CHECK(check_place(file, image, search));
  const Detection detection =
      locate(image, search.target, search.mapping ? &*search.mapping : nullptr, search.options);
  Located located{
      located_row({file, *options.tool, options.lists_candidates}, detection), "", detection};
  if (search.overlays.empty()) return located;
  PANELCAL_TRY(located.overlay_png, overlay_of(file, image, detection, search));
  return located;
}

Expected<void> write(const Located& located,
                     std::size_t i_image,
                     const LocateCommandOptions& options,
                     const Search& search,
                     CommandContext& context) {
  if (options.facts.json != "-") PANELCAL_CHECK(context.output.write(facts::text(located.row)));
  if (search.overlays.empty()) return {};
  return write_file(search.overlays[i_image], located.overlay_png);
}

}  // namespace

Expected<Answer> run_command(const LocateCommandOptions& options, CommandContext& context) {
  if (options.suggests) return internal::suggest(options, context);
  PANELCAL_TRY(const Search search, prepare(options, context));
  DiagnosticLog log;
  facts::Json rows = facts::Json::array();
  CommonScale scale;
  bool is_refused = false;
  const auto pool = make_thread_pool(options.n_threads, options.images.size());
  const auto make = [&](std::size_t i) { return locate_one(options.images[i], options, search); };
  const auto take = [&](std::size_t i, const Expected<Located>& located) {
    const Expected<void> done =
        located ? write(*located, i, options, search, context) : failure(located.error());
    if (located) {
      if (options.facts.any()) rows.push_back(located->row);
      scale.add(located->detection);
      is_refused |= located->detection.status != DetectionStatus::Found;
    }
    if (done) return true;
    context.console.print(done.error());
    log.add(done.error());
    // A disk that is full will not have room for the next one.
    return done.error().code != Code::DeviceWrite;
  };
  make_in_order(pool.get(), options.images.size(), make, take);
  if (is_refused) {
    if (const auto warning = scale.warning(options.machine)) {
      context.console.print(*warning);
      log.add(*warning);
    }
  }
  return internal::locate_answer(options, context, rows, log);
}

}  // namespace panelcal
