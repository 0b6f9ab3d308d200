// SPDX-License-Identifier: Apache-2.0
#include "machine/config/sections/target.h"

#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "calib/base/fields/slots.h"
#include "machine/config/sections/sections.h"
#include "machine/config/toml/ranges.h"
#include "vision/locate/target_check.h"
#include "vision/picture/files/image_io.h"
#include "vision/tag/family.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// A row of [[vision.tool]], as it is written: lengths are in mm or px as the size is.
struct TargetKeys {
  Target target;
  std::optional<std::vector<double>> dots_mm;
  std::optional<std::vector<double>> dots_px;
  std::optional<std::filesystem::path> picture;
  std::optional<Eigen::Vector2d> reference_px;
  std::optional<Polarity> polarity;
};

/// Larger ones are no targets: drawing or looking for one takes time as its outline is long.
constexpr Range kTargetLength_mm{.low = 0, .high = 1000, .low_is_open = true};
constexpr Range kTargetLength_px{.low = 0, .high = 1e5, .low_is_open = true};
constexpr std::string_view kShapeWords =
    "\"disc\", \"hole\", \"ring\", \"square\", \"diamond\", \"cross\", \"slot\", \"dots\", "
    "\"template\" or \"apriltag\"";

#include "machine/config/sections/target.def"

/// Names a missing size only beside other keys: what the size is, check_sizes() says of the shape.
Expected<void> require_target_keys(const TomlTable& table, bool has_camera) {
  const std::string shape = "shape = " + std::string(kShapeWords);
  std::vector<RequiredKey> keys = {{"number", "number = 1, as in G34,1"}, {"shape", shape}};
  const bool has_size = table.has("size_mm") || table.has("size_px");
  if (!has_size && !(table.has("number") && table.has("shape"))) {
    keys.push_back(has_camera ? RequiredKey{"size_mm", "size_mm = 1"}
                              : RequiredKey{"size_px", "size_px = 40"});
  }
  return table.require(keys);
}

/// A length that only one shape has, in mm or px as the size is.
struct OwnLength {
  std::string_view key_mm;
  std::string_view key_px;
  Shape owner;
  std::optional<Length> Target::*length;
  std::optional<PixelLength> Target::*length_px;
  std::string_view others_have;  ///< of another shape that states it
  std::string_view limit;
};
constexpr std::array<OwnLength, 2> kOwnLengths = {{
    {"inner_mm",
     "inner_px",
     Shape::Ring,
     &Target::inner_size,
     &Target::inner_size_px,
     "only rings have an inner diameter",
     "less than the outer diameter"},
    {"width_mm",
     "width_px",
     Shape::Cross,
     &Target::width,
     &Target::width_px,
     "only crosses have bars with a width",
     "less than the bars' length"},
}};

Expected<void> check_own_length(const TomlTable& table,
                                const OwnLength& own,
                                const Target& target) {
  const auto& in_mm = target.*own.length;
  const auto& in_px = target.*own.length_px;
  if (!in_mm && !in_px) return {};
  const std::string_view key = in_mm ? own.key_mm : own.key_px;
  if (target.shape != own.owner) {
    return failure(table.problem(key, "none", std::string(own.others_have)));
  }
  if ((in_mm && !target.size) || (in_px && !target.size_px)) {
    return failure(table.problem(key, "both sizes in the same unit"));
  }
  if (in_mm ? *in_mm >= *target.size : *in_px >= *target.size_px) {
    return failure(table.problem(key, std::string(own.limit)));
  }
  return {};
}

Expected<void> check_sizes(const TomlTable& table, bool has_camera, const Target& target) {
  if (!target.size && !target.size_px) {
    return failure(table.missing(
        "size_mm", fmt::format("{} (size_px without [camera])", size_words(target.shape))));
  }
  if (target.size && target.size_px) {
    return failure(table.problem("size_px", "one of the two", "size_mm is given as well"));
  }
  if (target.size && !has_camera) {
    return failure(table.problem(
        "size_mm", "[camera] calibration, or size_px", "pictures are not in mm without a camera"));
  }
  for (const OwnLength& own : kOwnLengths) PANELCAL_CHECK(check_own_length(table, own, target));
  if (target.shape == Shape::Cross && !target.width && !target.width_px) {
    return failure(table.missing("width_mm", "the width of a cross's bars, or width_px"));
  }
  return {};
}

/// Refuses keys that only other shapes have.
Expected<void> check_owner(const TomlTable& table,
                           std::initializer_list<std::string_view> keys,
                           bool is_owner,
                           Shape shape) {
  for (const std::string_view key : keys) {
    if (is_owner || !table.has(key)) continue;
    return failure(table.problem(
        key, "the key removed", fmt::format("not allowed for shape {}", quoted(name(shape)))));
  }
  return {};
}

Expected<void> check_angles(const TomlTable& table, const Target& target) {
  const bool has_angle = target.shape != Shape::Disc && target.shape != Shape::Hole &&
                         target.shape != Shape::Ring && target.shape != Shape::AprilTag;
  return check_owner(table, {"angle_deg", "angle_tolerance_deg"}, has_angle, target.shape);
}

Expected<void> take_dots(const TomlTable& table, TargetKeys& keys) {
  Target& target = keys.target;
  const bool is_dots = target.shape == Shape::Dots;
  PANELCAL_CHECK(check_owner(table, {"dots_mm", "dots_px"}, is_dots, target.shape));
  if (!is_dots) return {};
  const std::string_view key = target.size ? "dots_mm" : "dots_px";
  const std::string_view other = target.size ? "dots_px" : "dots_mm";
  if (table.has(other)) return failure(table.problem(other, "both sizes in the same unit"));
  const auto& numbers = target.size ? keys.dots_mm : keys.dots_px;
  if (!numbers) {
    return failure(
        table.missing(key, fmt::format("{} = [x1, y1, x2, y2, ...], the dots' middles", key)));
  }
  if (numbers->size() % 2 != 0) {
    return failure(table.problem(key, "an even count of numbers, x and y of each dot"));
  }
  for (std::size_t i = 0; i + 1 < numbers->size(); i += 2) {
    target.dots.emplace_back((*numbers)[i], (*numbers)[i + 1]);
  }
  return {};
}

Expected<void> take_picture(const TomlTable& table, TargetKeys& keys) {
  Target& target = keys.target;
  const bool is_template = target.shape == Shape::Template;
  PANELCAL_CHECK(check_owner(table, {"picture", "reference_px"}, is_template, target.shape));
  if (!is_template) return {};
  if (!keys.picture) {
    return failure(table.missing("picture", "picture = \"FILE\", a picture of the target"));
  }
  PANELCAL_TRY(Image image, read_image(*keys.picture));
  const Eigen::Vector2d middle(0.5 * (image.width() - 1), 0.5 * (image.height() - 1));
  PANELCAL_TRY(const auto file, table.text("picture"));
  target.picture = std::make_shared<const TemplatePicture>(
      TemplatePicture{*file, std::move(image), keys.reference_px.value_or(middle)});
  return {};
}

Expected<void> check_tag(const TomlTable& table, const Target& target) {
  const bool is_tag = target.shape == Shape::AprilTag;
  PANELCAL_CHECK(check_owner(table, {"family", "id"}, is_tag, target.shape));
  if (!is_tag) return {};
  if (!tag_pattern(target.tag_family, 0)) {
    return failure(table.problem("family", "a family of the AprilTag library, such as tag36h11"));
  }
  if (target.tag_id && !tag_pattern(target.tag_family, *target.tag_id)) {
    return failure(table.problem("id", fmt::format("a tag of {}", target.tag_family)));
  }
  return {};
}

/// Key that a target as a whole is blamed on.
std::string_view blamed_key(Shape shape, const TomlTable& table) {
  if (shape == Shape::Template) return "picture";
  if (shape == Shape::Dots) return table.has("dots_mm") ? "dots_mm" : "dots_px";
  return "shape";
}

/// Checks the values of several keys together.
Expected<void> check_whole(const TomlTable& table,
                           const std::optional<CameraCalibration>& camera,
                           const Target& target) {
  const std::string_view key = blamed_key(target.shape, table);
  if (auto valid = target.validate(); !valid) {
    Diagnostic diagnostic = std::move(valid).error();
    diagnostic.code = Code::ConfigValue;
    diagnostic.place = table.problem(key, "").place;
    return failure(std::move(diagnostic));
  }
  const bool is_mapped = camera && target.size;
  const auto mapping = is_mapped ? std::optional(camera->mapping()) : std::nullopt;
  const auto problem = target_problem(target, mapping ? &*mapping : nullptr);
  if (!problem) return {};
  if (!problem->is_of_angle) return failure(table.problem(key, "another picture", problem->why));
  const bool has_tolerance = table.has("angle_tolerance_deg");
  return failure(
      table.problem(has_tolerance ? std::string_view("angle_tolerance_deg") : key,
                    "less than half of that angle, or a mark without rotational symmetry",
                    problem->why));
}

Expected<Target> read_target(const TomlTable& table,
                             const std::optional<CameraCalibration>& camera) {
  TargetKeys keys;
  Target& target = keys.target;
  PANELCAL_CHECK(require_target_keys(table, camera.has_value()));
  PANELCAL_CHECK(table.read(kTarget, keys));
  target.polarity =
      keys.polarity.value_or(target.shape == Shape::Hole ? Polarity::Dark : Polarity::Bright);
  PANELCAL_CHECK(check_sizes(table, camera.has_value(), target));
  PANELCAL_CHECK(check_angles(table, target));
  PANELCAL_CHECK(take_dots(table, keys));
  PANELCAL_CHECK(take_picture(table, keys));
  PANELCAL_CHECK(check_tag(table, target));
  PANELCAL_CHECK(check_whole(table, camera, target));
  return target;
}

}  // namespace

Section target_section() {
  return {kTargetTables, nullptr};
}

Expected<void> read_targets(const TomlTable& vision, MachineConfig& config) {
  PANELCAL_TRY(const auto tools, vision.tables(kTarget));
  for (const TomlTable& tool : tools) {
    PANELCAL_TRY(const Target target, read_target(tool, config.camera));
    if (!config.vision_tools.emplace(target.number, target).second) {
      return failure(tool.problem("number", "each number once", "another tool has it"));
    }
  }
  return {};
}

}  // namespace panelcal::internal
