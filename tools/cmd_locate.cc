// SPDX-License-Identifier: Apache-2.0
#include <iterator>

#include <fmt/format.h>

#include "panelcal/machine/machine_config.h"
#include "panelcal/program/json_text.h"
#include "panelcal/tools/commands.h"
#include "panelcal/vision/image_io.h"
#include "panelcal/vision/locate.h"

namespace panelcal {
namespace {

/// docs/formats/located_targets.md
std::string to_json(const std::string& file, int tool, const Detection& detection) {
  std::string out = "{\"image\":";
  append_json_string(out, file);
  auto to = std::back_inserter(out);
  fmt::format_to(to, ",\"tool\":{},\"status\":\"{}\"", tool, name(detection.status));
  if (detection.status == DetectionStatus::Found) {
    const TargetFit& fit = *detection.best;
    const Eigen::Vector2d& center_px = fit.center.position.in_px();
    const Eigen::Matrix2d& cov_px2 = fit.center.cov;
    fmt::format_to(to,
                   ",\"center_px\":[{},{}],\"cov_px\":[{},{},{}]",
                   center_px.x(),
                   center_px.y(),
                   cov_px2(0, 0),
                   cov_px2(0, 1),
                   cov_px2(1, 1));
    fmt::format_to(to,
                   ",\"size_px\":{:.4f},\"angle_rad\":{:.6f},\"score\":{:.4f}",
                   fit.size.in_px(),
                   fit.angle.in_rad(),
                   fit.score);
  }
  fmt::format_to(to, ",\"candidates\":{}", detection.n_candidates);
  if (!detection.reason.empty()) {
    out += ",\"reason\":";
    append_json_string(out, detection.reason);
  }
  return out + "}\n";
}

}  // namespace

ExitCode run_command(const LocateCommandOptions& options, CommandContext& context) {
  const auto config = read_machine_config(options.machine);
  if (!config) {
    context.console.print(config.error());
    return exit_code(config.error());
  }
  const auto tool = config->vision_tools.find(options.tool);
  if (tool == config->vision_tools.end()) {
    const Diagnostic missing{Code::VisionToolUndefined,
                             {options.machine, 0, 0},
                             fmt::format("there is no vision tool {}", options.tool),
                             fmt::format("[[vision.tool]] with number = {}", options.tool)};
    context.console.print(missing);
    return exit_code(missing);
  }
  std::optional<CameraMapping> mapping;
  if (config->camera && tool->second.size) mapping = config->camera->mapping();

  DiagnosticLog log;
  for (const std::string& file : options.images) {
    const Expected<Image> image = read_image(file);
    if (!image) {
      context.console.print(image.error());
      log.add(image.error());
      continue;
    }
    if (mapping && (image->width() != config->camera->picture_width_px ||
                    image->height() != config->camera->picture_height_px)) {
      const Diagnostic mismatch{
          Code::PictureMismatch,
          {file, 0, 0},
          fmt::format("the picture has {} x {} px", image->width(), image->height()),
          fmt::format("{} x {} px, for which [camera] is calibrated",
                      config->camera->picture_width_px,
                      config->camera->picture_height_px)};
      context.console.print(mismatch);
      log.add(mismatch);
      continue;
    }
    const Detection detection =
        locate(*image, tool->second, mapping ? &*mapping : nullptr, config->locate);
    if (const auto written = context.output.write(to_json(file, options.tool, detection));
        !written) {
      context.console.print(written.error());
      return exit_code(written.error());
    }
  }
  return exit_code(log);
}

}  // namespace panelcal
