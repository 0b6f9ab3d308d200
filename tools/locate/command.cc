// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "calib/base/atomic_file.h"
#include "machine/config/machine_config.h"
#include "tools/cli/commands.h"
#include "tools/cli/output_paths.h"
#include "tools/locate/located_json.h"
#include "vision/locate/locate.h"
#include "vision/picture/bayer.h"
#include "vision/picture/image_io.h"
#include "vision/show/overlay.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using Path = std::filesystem::path;

Diagnostic locate_usage(std::string what, std::string expected) {
  return {Code::Usage, {"panelcal locate", 0, 0}, std::move(what), std::move(expected)};
}

bool is_png(const Path& path) {
  return extension_of(path) == ".png";
}

/// Whether a name is surely not meant for a folder.
bool is_other_picture(const Path& path) {
  constexpr std::array<std::string_view, 10> kExtensions = {
      ".bmp", ".gif", ".jpeg", ".jpg", ".pdf", ".pgm", ".svg", ".tif", ".tiff", ".webp"};
  std::error_code ignored;
  return std::ranges::find(kExtensions, extension_of(path)) != kExtensions.end() &&
         !std::filesystem::is_directory(path, ignored);
}

/// Where the overlay of each picture goes: OUT.png for the only one, else OUT/NAME.png.
///
/// Fails  usage (no PNG; several pictures and one file; two pictures of one name; over an input)
Expected<std::vector<Path>> overlay_paths(const LocateCommandOptions& options) {
  const Path out(options.overlay);
  if (is_other_picture(out)) {
    return failure(locate_usage(
        fmt::format("--overlay {} is not written: overlays are PNG files", quoted(options.overlay)),
        "a name that ends in .png, or a folder"));
  }
  std::vector<Path> paths;
  if (is_png(out)) {
    if (options.images.size() > 1) {
      return failure(locate_usage(fmt::format("--overlay {} is one file, and there are {} pictures",
                                              quoted(options.overlay),
                                              options.images.size()),
                                  "a folder"));
    }
    paths.push_back(out);
  } else {
    for (const std::string& image : options.images) {
      paths.push_back(out / (Path(image).stem().string() + ".png"));
    }
  }
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (const auto first = std::ranges::find(paths, paths[i]) - paths.begin();
        static_cast<std::size_t>(first) != i) {
      return failure(
          locate_usage(fmt::format("the overlays of {} and {} would both be {}",
                                   quoted(options.images[static_cast<std::size_t>(first)]),
                                   quoted(options.images[i]),
                                   quoted(paths[i].string())),
                       "pictures of different names"));
    }
    for (const std::string& image : options.images) {
      if (!is_same_file(image, paths[i]) && !is_same_file(options.machine, paths[i])) continue;
      return failure(locate_usage(
          fmt::format("the overlay {} would overwrite an input", quoted(paths[i].string())),
          "another file or folder"));
    }
  }
  return paths;
}

/// Makes the folder of several overlays.
Expected<void> make_folder(const LocateCommandOptions& options) {
  if (is_png(options.overlay)) return {};
  std::error_code error;
  std::filesystem::create_directories(options.overlay, error);
  // A path with a trailing slash exists, and yet nothing was created.
  std::error_code ignored;
  if (std::filesystem::is_directory(options.overlay, ignored)) return {};
  return failure({Code::DeviceWrite,
                  {options.overlay, 0, 0},
                  "cannot create the folder: " +
                      (error ? error.message() : std::string("a file has its name")),
                  ""});
}

/// One call of the command: what is looked for, how, and where the overlays go.
struct Search {
  MachineConfig config;
  Target target;
  std::optional<CameraMapping> mapping;
  std::vector<Path> overlays;  ///< of the images, or empty
};

Expected<Search> prepare(const LocateCommandOptions& options) {
  PANELCAL_TRY(MachineConfig config, read_machine_config(options.machine));
  const auto tool = config.vision_tools.find(options.tool);
  if (tool == config.vision_tools.end()) {
    return failure({Code::VisionToolUndefined,
                    {options.machine, 0, 0},
                    fmt::format("vision tool {}", options.tool),
                    fmt::format("[[vision.tool]] with number = {}", options.tool)});
  }
  Search search{std::move(config), tool->second, std::nullopt, {}};
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
    search.config.locate.search_center = position_px<frame::Image>(Eigen::Vector2d(x_px, y_px));
    search.config.locate.search_radius = px(*options.radius_px);
  }
  if (search.config.camera && search.target.size) {
    search.mapping = search.config.camera->mapping();
  }
  if (!options.overlay.empty()) {
    PANELCAL_TRY(search.overlays, overlay_paths(options));
    PANELCAL_CHECK(make_folder(options));
  }
  return search;
}

Expected<void> check_picture_size(const std::string& file,
                                  const Image& image,
                                  const Search& search) {
  if (!search.mapping) return {};
  const auto& camera = *search.config.camera;
  if (image.width() == camera.picture_width_px && image.height() == camera.picture_height_px) {
    return {};
  }
  return failure({Code::PictureMismatch,
                  {file, 0, 0},
                  fmt::format("the picture has {} x {} px", image.width(), image.height()),
                  fmt::format("{} x {} px, for which [camera] is calibrated",
                              camera.picture_width_px,
                              camera.picture_height_px)});
}

/// A target's middle is in its picture, so a place elsewhere is a mistake.
Expected<void> check_place(const std::string& file, const Image& image, const Search& search) {
  if (!search.config.locate.search_center) return {};
  const Eigen::Vector2d& at_px = search.config.locate.search_center->in_px();
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

Expected<void> write_overlay(const Path& path,
                             const std::string& file,
                             const Image& image,
                             const Detection& detection,
                             const Search& search) {
  const OverlayOptions overlay{.min_side = 640,
                               .title = fmt::format("{}, vision tool {}: {}",
                                                    Path(file).filename().string(),
                                                    search.target.number,
                                                    name(search.target.shape)),
                               .search_center = search.config.locate.search_center,
                               .search_radius = search.config.locate.search_radius};
  PANELCAL_TRY(const std::string png, encode_overlay(image, detection, overlay));
  return write_file(path, png);
}

/// Locates the target in one picture and writes what is asked for.
Expected<void> locate_one(std::size_t i_image,
                          const LocateCommandOptions& options,
                          const Search& search,
                          CommandContext& context) {
  const std::string& file = options.images[i_image];
  PANELCAL_TRY(Image image, read_image(file));
  if (search.config.bayer) image = from_bayer(image, *search.config.bayer);
  PANELCAL_CHECK(check_picture_size(file, image, search));
  PANELCAL_CHECK(check_place(file, image, search));
  const Detection detection = locate(
      image, search.target, search.mapping ? &*search.mapping : nullptr, search.config.locate);
  PANELCAL_CHECK(context.output.write(
      located_json({file, options.tool, options.lists_candidates}, detection)));
  if (search.overlays.empty()) return {};
  return write_overlay(search.overlays[i_image], file, image, detection, search);
}

}  // namespace

ExitCode run_command(const LocateCommandOptions& options, CommandContext& context) {
  const auto search = prepare(options);
  if (!search) {
    context.console.print(search.error());
    return exit_code(search.error());
  }
  DiagnosticLog log;
  for (std::size_t i = 0; i < options.images.size(); ++i) {
    const auto done = locate_one(i, options, *search, context);
    if (done) continue;
    context.console.print(done.error());
    // A disk that is full will not have room for the next one.
    if (done.error().code == Code::DeviceWrite) return exit_code(done.error());
    log.add(done.error());
  }
  return exit_code(log);
}

}  // namespace panelcal
