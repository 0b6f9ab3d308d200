// SPDX-License-Identifier: Apache-2.0
// The functions of panelcal::vision, by way of its module (see module.h).
#include "tools/modules/module.h"
#include "tools/modules/vision_functions.h"

namespace panelcal {
namespace {

const modules::VisionFunctions& vision_functions() {
  static const auto& functions = modules::load<modules::VisionFunctions>(modules::kVisionModule);
  return functions;
}

}  // namespace

Expected<Image> read_image(const std::filesystem::path& path) {
  return vision_functions().read_image(path);
}

Expected<Image> decode_image(std::string_view bytes, std::string_view name) {
  return vision_functions().decode_image(bytes, name);
}

Expected<std::string> encode_jpeg(const Image& image, int max_side_px) {
  return vision_functions().encode_jpeg(image, max_side_px);
}

Expected<std::string> encode_png(const Image& image) {
  return vision_functions().encode_png(image);
}

Expected<void> write_png(const std::filesystem::path& path, const Image& image) {
  return vision_functions().write_png(path, image);
}

Detection locate(const Image& image,
                 const Target& target,
                 const CameraMapping* mapping,
                 const LocateOptions& options) {
  return vision_functions().locate(image, target, mapping, options);
}

Expected<std::vector<ReadTag>> read_tags(const Image& image,
                                         const Target& target,
                                         const LocateOptions& options) {
  return vision_functions().read_tags(image, target, options);
}

Expected<std::string> encode_overlay(const Image& image,
                                     const Detection& detection,
                                     const OverlayOptions& options) {
  return vision_functions().encode_overlay(image, detection, options);
}

Expected<TargetPicture> target_picture(const Image& image, const Detection& detection) {
  return vision_functions().target_picture(image, detection);
}

std::vector<SeenMark> find_marks(const Image& image, const MarkOptions& options) {
  return vision_functions().find_marks(image, options);
}

namespace internal {

std::optional<TargetProblem> target_problem(const Target& target, const CameraMapping* mapping) {
  // Nothing can be wrong with the others (see target_check.h).
  if (target.shape != Shape::Template && target.shape != Shape::Dots) return std::nullopt;
  return vision_functions().target_problem(target, mapping);
}

}  // namespace internal
}  // namespace panelcal
