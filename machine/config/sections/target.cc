// SPDX-License-Identifier: Apache-2.0
#include "machine/config/sections/target.h"

#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "machine/config/toml/ranges.h"
#include "vision/locate/target_check.h"
#include "vision/picture/files/image_io.h"
#include "vision/tag/family.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

using Words = std::string_view;

constexpr std::array<Words, 18> kTargetTableKeys = {"angle_deg",
                                                    "angle_tolerance_deg",
                                                    "dots_mm",
                                                    "dots_px",
                                                    "family",
                                                    "id",
                                                    "inner_mm",
                                                    "inner_px",
                                                    "number",
                                                    "picture",
                                                    "polarity",
                                                    "reference_px",
                                                    "shape",
                                                    "size_mm",
                                                    "size_px",
                                                    "size_tolerance",
                                                    "width_mm",
                                                    "width_px"};
constexpr std::array<Words, 1> kPlanned = {"algorithm"};
/// Larger ones are no targets: drawing or looking for one takes time as its outline is long.
constexpr Range kTargetLength_mm{.low = 0, .high = 1000, .low_is_open = true};
constexpr Range kTargetLength_px{.low = 0, .high = 1e5, .low_is_open = true};
constexpr std::string_view kShapeWords =
    "\"disc\", \"hole\", \"ring\", \"square\", \"diamond\", \"cross\", \"slot\", \"dots\", "
    "\"template\" or \"apriltag\"";

/// Names a missing size only beside other keys: what the size is, read_sizes() says of the shape.
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

/// Precondition: the table has the key.
Expected<Shape> read_target_shape(const TomlTable& table) {
  PANELCAL_TRY(const auto word, table.text("shape"));
  if (const auto shape = shape_from_name(*word)) return *shape;
  return failure(table.problem("shape", std::string(kShapeWords)));
}

/// Meaning of a shape's size, for messages.
std::string_view size_words(Shape shape) {
  switch (shape) {
    case Shape::Square:
    case Shape::Diamond:
    case Shape::AprilTag:
      return "the side";
    case Shape::Cross:
      return "the bars' length";
    case Shape::Slot:
      return "the width between the long edges";
    case Shape::Template:
      return "the width of the picture on the panel";
    default:
      return "the outer diameter";
  }
}

/// A key of one shape only, in mm or px as the size is; the other unit's value is empty.
template <class Value>
struct InUnits {
  std::optional<Value> mm;
  std::optional<Value> px;
};

Expected<InUnits<double>> read_target_length(const TomlTable& table,
                                             std::string_view name,
                                             Shape owner,
                                             const Target& target) {
  const std::string key_mm = std::string(name) + "_mm";
  const std::string key_px = std::string(name) + "_px";
  InUnits<double> length;
  PANELCAL_TRY(length.mm, table.number(key_mm, kTargetLength_mm));
  PANELCAL_TRY(length.px, table.number(key_px, kTargetLength_px));
  if (!length.mm && !length.px) return length;
  const std::string& key = length.mm ? key_mm : key_px;
  if (target.shape != owner) {
    const std::string_view what =
        owner == Shape::Ring ? "rings have an inner diameter" : "crosses have bars with a width";
    return failure(table.problem(key, "none", fmt::format("only {}", what)));
  }
  if ((length.mm && !target.size) || (length.px && !target.size_px)) {
    return failure(table.problem(key, "both sizes in the same unit"));
  }
  const double size = target.size ? target.size->in_mm() : target.size_px->in_px();
  if ((length.mm ? *length.mm : *length.px) >= size) {
    return failure(table.problem(
        key, owner == Shape::Ring ? "less than the outer diameter" : "less than the bars' length"));
  }
  return length;
}

Expected<void> read_sizes(const TomlTable& table, bool has_camera, Target& target) {
  PANELCAL_TRY(const auto size_mm, table.number("size_mm", kTargetLength_mm));
  PANELCAL_TRY(const auto size_px, table.number("size_px", kTargetLength_px));
  if (!size_mm && !size_px) {
    return failure(table.missing(
        "size_mm", fmt::format("{} (size_px without [camera])", size_words(target.shape))));
  }
  if (size_mm && size_px) {
    return failure(table.problem("size_px", "one of the two", "size_mm is given as well"));
  }
  if (size_mm && !has_camera) {
    return failure(table.problem(
        "size_mm", "[camera] calibration, or size_px", "pictures are not in mm without a camera"));
  }
  if (size_mm) target.size = mm(*size_mm);
  if (size_px) target.size_px = px(*size_px);
  PANELCAL_TRY(const auto inner, read_target_length(table, "inner", Shape::Ring, target));
  if (inner.mm) target.inner_size = mm(*inner.mm);
  if (inner.px) target.inner_size_px = px(*inner.px);
  PANELCAL_TRY(const auto width, read_target_length(table, "width", Shape::Cross, target));
  if (width.mm) target.width = mm(*width.mm);
  if (width.px) target.width_px = px(*width.px);
  if (target.shape == Shape::Cross && !width.mm && !width.px) {
    return failure(table.missing("width_mm", "the width of a cross's bars, or width_px"));
  }
  return {};
}

/// Refuses a key that only another shape has.
Expected<void> check_owner(const TomlTable& table,
                           std::string_view key,
                           bool is_owner,
                           Shape shape) {
  if (!table.has(key) || is_owner) return {};
  return failure(table.problem(
      key, "the key removed", fmt::format("not allowed for shape {}", quoted(name(shape)))));
}

Expected<void> read_target_dots(const TomlTable& table, Target& target) {
  const bool is_dots = target.shape == Shape::Dots;
  PANELCAL_CHECK(check_owner(table, "dots_mm", is_dots, target.shape));
  PANELCAL_CHECK(check_owner(table, "dots_px", is_dots, target.shape));
  if (!is_dots) return {};
  const std::string_view key = target.size ? "dots_mm" : "dots_px";
  const std::string_view other = target.size ? "dots_px" : "dots_mm";
  if (table.has(other)) return failure(table.problem(other, "both sizes in the same unit"));
  PANELCAL_TRY(const auto numbers, table.numbers(key, kPlace));
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

Expected<void> read_picture(const TomlTable& table,
                            const std::filesystem::path& folder,
                            Target& target) {
  const bool is_template = target.shape == Shape::Template;
  PANELCAL_CHECK(check_owner(table, "picture", is_template, target.shape));
  PANELCAL_CHECK(check_owner(table, "reference_px", is_template, target.shape));
  if (!is_template) return {};
  PANELCAL_TRY(const auto file, table.text("picture"));
  if (!file || file->empty()) {
    return failure(table.missing("picture", "picture = \"FILE\", a picture of the target"));
  }
  PANELCAL_TRY(Image image, read_image(folder / *file));
  const Eigen::Vector2d middle(0.5 * (image.width() - 1), 0.5 * (image.height() - 1));
  PANELCAL_TRY(const auto reference_px, table.pair("reference_px", kPlace));
  target.picture = std::make_shared<const TemplatePicture>(
      TemplatePicture{*file, std::move(image), reference_px.value_or(middle)});
  return {};
}

Expected<void> read_tag(const TomlTable& table, Target& target) {
  const bool is_tag = target.shape == Shape::AprilTag;
  PANELCAL_CHECK(check_owner(table, "family", is_tag, target.shape));
  PANELCAL_CHECK(check_owner(table, "id", is_tag, target.shape));
  if (!is_tag) return {};
  PANELCAL_TRY(const auto family, table.text("family"));
  if (family) target.tag_family = *family;
  if (!tag_pattern(target.tag_family, 0)) {
    return failure(table.problem("family", "a family of the AprilTag library, such as tag36h11"));
  }
  PANELCAL_TRY(const auto id, table.integer("id", 0, kMaxTagId));
  if (id) target.tag_id = static_cast<int>(*id);
  if (target.tag_id && !tag_pattern(target.tag_family, *target.tag_id)) {
    return failure(table.problem("id", fmt::format("a tag of {}", target.tag_family)));
  }
  return {};
}

Expected<void> read_angles(const TomlTable& table, Target& target) {
  const bool has_angle = target.shape != Shape::Disc && target.shape != Shape::Hole &&
                         target.shape != Shape::Ring && target.shape != Shape::AprilTag;
  PANELCAL_CHECK(check_owner(table, "angle_deg", has_angle, target.shape));
  PANELCAL_CHECK(check_owner(table, "angle_tolerance_deg", has_angle, target.shape));
  PANELCAL_TRY(const auto angle, table.number("angle_deg", {-360, 360}));
  if (angle) target.angle = deg(*angle);
  PANELCAL_TRY(const auto tolerance, table.number("angle_tolerance_deg", {0, 180}));
  if (tolerance) target.angle_tolerance = deg(*tolerance);
  return {};
}

/// Key that a target as a whole is blamed on.
Words blamed_key(Shape shape, const TomlTable& table) {
  if (shape == Shape::Template) return "picture";
  if (shape == Shape::Dots) return table.has("dots_mm") ? "dots_mm" : "dots_px";
  return "shape";
}

/// Checks the values of several keys together.
Expected<void> check_whole(const TomlTable& table,
                           const std::optional<CameraCalibration>& camera,
                           const Target& target) {
  const Words key = blamed_key(target.shape, table);
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
      table.problem(has_tolerance ? Words("angle_tolerance_deg") : key,
                    "less than half of that angle, or a mark without rotational symmetry",
                    problem->why));
}

}  // namespace

const TomlKeys kTargetKeys{kTargetTableKeys, kPlanned};

Expected<Target> read_target(const TomlTable& table,
                             const std::optional<CameraCalibration>& camera,
                             const std::filesystem::path& folder) {
  Target target;
  PANELCAL_CHECK(require_target_keys(table, camera.has_value()));
  PANELCAL_TRY(const auto number, table.integer("number", 1, kMaxToolNumber));
  target.number = static_cast<int>(number.value());
  PANELCAL_TRY(target.shape, read_target_shape(table));
  if (target.shape == Shape::Hole) target.polarity = Polarity::Dark;
  PANELCAL_CHECK(read_sizes(table, camera.has_value(), target));
  PANELCAL_CHECK(read_angles(table, target));
  PANELCAL_CHECK(read_target_dots(table, target));
  PANELCAL_CHECK(read_picture(table, folder, target));
  PANELCAL_CHECK(read_tag(table, target));
  PANELCAL_TRY(const auto polarity, table.text("polarity"));
  if (polarity) {
    const auto known = polarity_from_name(*polarity);
    if (!known) return failure(table.problem("polarity", "\"bright\" or \"dark\""));
    target.polarity = *known;
  }
  PANELCAL_TRY(target.size_tolerance,
               table.number_or("size_tolerance", {0, 0.5, true}, target.size_tolerance));
  PANELCAL_CHECK(check_whole(table, camera, target));
  return target;
}

}  // namespace panelcal::internal
