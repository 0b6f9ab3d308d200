// SPDX-License-Identifier: Apache-2.0
#include "tools/locate/search.h"

#include <fmt/format.h>

namespace panelcal {

Expected<TargetSearch> target_search(const MachineConfig& machine, int tool) {
  const auto found = machine.vision_tools.find(tool);
  if (found == machine.vision_tools.end()) {
    return failure({Code::VisionToolUndefined,
                    {machine.file.string(), 0, 0},
                    fmt::format("vision tool {}", tool),
                    fmt::format("[[vision.tool]] with number = {}", tool)});
  }
  TargetSearch search{
      .target = found->second, .options = machine.locate, .form = machine.picture_form};
  if (machine.camera && search.target.size) {
    search.mapping = machine.camera->mapping();
    search.width_px = machine.camera->picture_width_px;
    search.height_px = machine.camera->picture_height_px;
  }
  return search;
}

Expected<void> check_picture_size(const std::string& file,
                                  const Image& image,
                                  const TargetSearch& search) {
  const bool fits = image.width() == search.width_px && image.height() == search.height_px;
  if (!search.mapping || fits) return {};
  return failure(
      {Code::PictureMismatch,
       {file, 0, 0},
       fmt::format("the picture has {} x {} px", image.width(), image.height()),
       fmt::format(
           "{} x {} px, for which [camera] is calibrated", search.width_px, search.height_px)});
}

}  // namespace panelcal
