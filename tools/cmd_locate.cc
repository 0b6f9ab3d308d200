// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "panelcal/calib/base/atomic_file.h"
#include "panelcal/machine/machine_config.h"
#include "panelcal/program/json_text.h"
#include "panelcal/tools/commands.h"
#include "panelcal/vision/bayer.h"
#include "panelcal/vision/image_io.h"
#include "panelcal/vision/locate.h"
#include "panelcal/vision/overlay.h"

namespace panelcal {
namespace {

using Path = std::filesystem::path;

Diagnostic usage(std::string what, std::string expected) {
  return {Code::Usage, {"panelcal locate", 0, 0}, std::move(what), std::move(expected)};
}

void append_point(std::string& out, const Eigen::Vector2d& v_px) {
  fmt::format_to(std::back_inserter(out), "[{},{}]", v_px.x(), v_px.y());
}

void append_center(std::string& out, const TargetFit& fit) {
  const Eigen::Matrix2d& cov_px2 = fit.center.cov;
  out += ",\"center_px\":";
  append_point(out, fit.center.position.in_px());
  fmt::format_to(std::back_inserter(out),
                 ",\"cov_px\":[{},{},{}],\"size_px\":{:.4f},\"angle_rad\":{:.6f},\"score\":{:.4f}",
                 cov_px2(0, 0),
                 cov_px2(0, 1),
                 cov_px2(1, 1),
                 fit.size.in_px(),
                 fit.angle.in_rad(),
                 fit.score);
}

void append_details(std::string& out, const TargetFit& fit) {
  auto to = std::back_inserter(out);
  fmt::format_to(to,
                 ",\"visible\":{:.4f},\"blur_px\":{:.4f},\"noise\":{:.4f}",
                 fit.visible,
                 fit.blur_px,
                 fit.noise);
  if (fit.axis_ratio != 1) fmt::format_to(to, ",\"axis_ratio\":{:.6f}", fit.axis_ratio);
  if (fit.blind_direction) {
    fmt::format_to(to, ",\"blind_rad\":{:.6f}", fit.blind_direction->in_rad());
  }
  if (fit.tag_id) fmt::format_to(to, ",\"id\":{}", *fit.tag_id);
  if (fit.corners.empty()) return;
  out += ",\"corners_px\":[";
  for (std::size_t i = 0; i < fit.corners.size(); ++i) {
    if (i > 0) out += ',';
    append_point(out, fit.corners[i].position.in_px());
  }
  out += ']';
}

void append_others(std::string& out, const Detection& detection) {
  out += ",\"others\":[";
  std::string_view separator = "";
  for (const Candidate& other : other_candidates(detection)) {
    out += separator;
    separator = ",";
    out += "{\"center_px\":";
    append_point(out, other.center.in_px());
    fmt::format_to(std::back_inserter(out),
                   ",\"size_px\":{:.4f},\"score\":{:.4f}",
                   other.size.in_px(),
                   other.score);
    if (!other.reason.empty()) {
      out += ",\"reason\":";
      append_json_string(out, other.reason);
    }
    out += '}';
  }
  out += ']';
}

/// docs/formats/located_targets.md
std::string to_json(const std::string& file,
                    const LocateCommandOptions& options,
                    const Detection& detection) {
  std::string out = "{\"image\":";
  append_json_string(out, file);
  auto to = std::back_inserter(out);
  fmt::format_to(to, ",\"tool\":{},\"status\":\"{}\"", options.tool, name(detection.status));
  const bool is_found = detection.status == DetectionStatus::Found;
  if (is_found) append_center(out, *detection.best);
  fmt::format_to(to, ",\"candidates\":{}", detection.n_candidates);
  if (!detection.reason.empty()) {
    out += ",\"reason\":";
    append_json_string(out, detection.reason);
  }
  if (is_found) append_details(out, *detection.best);
  if (options.lists_candidates || detection.status == DetectionStatus::Ambiguous) {
    append_others(out, detection);
  }
  return out + "}\n";
}

bool is_same_file(const Path& a, const Path& b) {
  std::error_code ignored;
  return a.lexically_normal() == b.lexically_normal() || std::filesystem::equivalent(a, b, ignored);
}

bool is_png(const Path& path) {
  const std::string extension = path.extension().string();
  return extension == ".png" || extension == ".PNG";
}

/// Where the overlay of each picture goes: OUT.png for the only one, else OUT/NAME.png.
///
/// Fails  usage (several pictures and one file; two pictures of one name; over an input)
Expected<std::vector<Path>> overlay_paths(const LocateCommandOptions& options) {
  const Path out(options.overlay);
  std::vector<Path> paths;
  if (is_png(out)) {
    if (options.images.size() > 1) {
      return failure(usage(fmt::format("--overlay {} is one file, and there are {} pictures",
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
      return failure(usage(fmt::format("the overlays of {} and {} would both be {}",
                                       quoted(options.images[static_cast<std::size_t>(first)]),
                                       quoted(options.images[i]),
                                       quoted(paths[i].string())),
                           "pictures of different names"));
    }
    for (const std::string& image : options.images) {
      if (!is_same_file(paths[i], image) && !is_same_file(paths[i], options.machine)) continue;
      return failure(
          usage(fmt::format("the overlay {} would overwrite an input", quoted(paths[i].string())),
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
  if (std::filesystem::is_directory(options.overlay)) return {};
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
                    fmt::format("there is no vision tool {}", options.tool),
                    fmt::format("[[vision.tool]] with number = {}", options.tool)});
  }
  Search search{std::move(config), tool->second, std::nullopt, {}};
  if (!options.at_px.empty()) {
    const double x_px = options.at_px[0];
    const double y_px = options.at_px[1];
    if (!std::isfinite(x_px) || !std::isfinite(y_px) || !(*options.radius_px >= 1) ||
        !std::isfinite(*options.radius_px)) {
      return failure(
          usage(fmt::format(
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

Expected<void> check_size(const std::string& file, const Image& image, const Search& search) {
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
  PANELCAL_CHECK(check_size(file, image, search));
  const Detection detection = locate(
      image, search.target, search.mapping ? &*search.mapping : nullptr, search.config.locate);
  PANELCAL_CHECK(context.output.write(to_json(file, options, detection)));
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
