// SPDX-License-Identifier: Apache-2.0
#include "tools/locate/suggest_command.h"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calib/base/executor.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/thread_pool.h"
#include "machine/config/machine_config.h"
#include "tools/locate/answer.h"
#include "tools/locate/located_json.h"
#include "tools/locate/overlay_paths.h"
#include "tools/locate/suggestion.h"
#include "vision/picture/files/image_io.h"
#include "vision/picture/picture_form.h"
#include "vision/show/overlay.h"
#include "vision/suggest/find_marks.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

using Path = std::filesystem::path;

/// Facts of a machine's file about its pictures, if there is one.
struct PictureFacts {
  PictureForm form;
  std::optional<Length> pixel;  ///< its length on the panel
};

Expected<PictureFacts> picture_facts(const LocateCommandOptions& options) {
  if (options.machine.empty()) return PictureFacts{};
  PANELCAL_TRY(const MachineConfig config, read_machine_config(options.machine));
  PictureFacts facts{config.picture_form, std::nullopt};
  if (config.camera) {
    facts.pixel = mm(config.camera->mapping().parameters().scale_mm_per_px);
  }
  return facts;
}

/// The marks as candidates of no target, so that all of them are drawn.
Expected<std::string> marks_overlay(const std::string& file,
                                    const Image& image,
                                    const std::vector<SeenMark>& marks) {
  Detection detection;
  detection.reason = fmt::format("{} marks", marks.size());
  for (const SeenMark& mark : marks) {
    detection.candidates.push_back(
        {mark.center, mark.size, mark.quality, describe(mark), {mark.outline_px}});
  }
  return encode_overlay(
      image, detection, {.min_side = 640, .title = Path(file).filename().string()});
}

bool is_asked_for(const SeenMark& mark, const LocateCommandOptions& options) {
  if (options.at_px.empty()) return true;
  const Eigen::Vector2d at_px(options.at_px[0], options.at_px[1]);
  return (mark.center.in_px() - at_px).norm() <= *options.radius_px;
}

struct Suggested {
  PictureMarks picture;
  std::string overlay_png;
};

Expected<Suggested> look_at(const std::string& file,
                            const LocateCommandOptions& options,
                            const PictureFacts& facts) {
  PANELCAL_TRY(Image image, read_image(file));
  image = understood(std::move(image), facts.form);
  Suggested out{{file, find_marks(image)}, ""};
  std::erase_if(out.picture.marks, [&](const SeenMark& m) { return !is_asked_for(m, options); });
  if (options.overlay.empty()) return out;
  PANELCAL_TRY(out.overlay_png, marks_overlay(file, image, out.picture.marks));
  return out;
}

/// Writes what can be written at once, and keeps the marks.
Expected<void> keep(Suggested suggested, const Path* overlay, std::vector<PictureMarks>& pictures) {
  if (overlay != nullptr) PANELCAL_CHECK(write_file(*overlay, suggested.overlay_png));
  pictures.push_back(std::move(suggested.picture));
  return {};
}

}  // namespace

Expected<Answer> suggest(const LocateCommandOptions& options, CommandContext& context) {
  PANELCAL_TRY(const PictureFacts of_machine, picture_facts(options));
  std::vector<Path> overlays;
  if (!options.overlay.empty()) {
    PANELCAL_TRY(overlays, make_overlay_paths(options, context));
  }
  DiagnosticLog log;
  std::vector<PictureMarks> pictures;
  const auto pool = make_thread_pool(options.n_threads, options.images.size());
  const auto make = [&](std::size_t i) { return look_at(options.images[i], options, of_machine); };
  const auto take = [&](std::size_t i, Expected<Suggested> suggested) {
    const Path* const overlay = overlays.empty() ? nullptr : &overlays[i];
    const Expected<void> done =
        suggested ? keep(*std::move(suggested), overlay, pictures) : failure(suggested.error());
    if (done) return true;
    context.console.print(done.error());
    log.add(done.error());
    return done.error().code != Code::DeviceWrite;
  };
  make_in_order(pool.get(), options.images.size(), make, take);
  facts::Json rows = facts::Json::array();
  if (options.facts.any())
    std::ranges::transform(pictures, std::back_inserter(rows), suggested_row);
  return locate_answer(options,
                       context,
                       rows,
                       log,
                       pictures.empty() ? "" : suggestion_toml(pictures, of_machine.pixel));
}

}  // namespace panelcal::internal
