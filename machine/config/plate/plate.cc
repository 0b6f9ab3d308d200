// SPDX-License-Identifier: Apache-2.0
#include "machine/config/plate/plate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "calib/base/files/atomic_file.h"
#include "machine/config/plate/plate_tags.h"
#include "machine/config/toml/ranges.h"
#include "machine/config/toml/toml_table.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::Range;
using internal::TomlSource;
using internal::TomlTable;

constexpr std::array<std::string_view, 4> kPlateFileKeys = {"plate", "pose", "tag", "tags"};
constexpr std::array<std::string_view, 7> kPlateKeys = {
    "certified", "columns", "dot_diameter_mm", "name", "pitch_mm", "polarity", "rows"};
constexpr std::array<std::string_view, 2> kPoseKeys = {"angle_deg", "origin_mm"};
/// A hundred thousand dots are more than any plate has.
constexpr int kMaxDotsPerSide = 300;
constexpr Range kPlateLength_mm{0, internal::kMaxPlace_mm, true};

/// Precondition: the table has the key.
Expected<int> count(const TomlTable& table, std::string_view key) {
  PANELCAL_TRY(const auto n, table.integer(key, 1, kMaxDotsPerSide));
  return static_cast<int>(n.value());
}

Expected<void> read_plate_dots(const TomlTable& table, CalibrationPlate& plate) {
  PANELCAL_CHECK(table.require({{"columns", "columns = 9, or the number that the plate has"},
                                {"rows", "rows = 9, or the number that the plate has"},
                                {"pitch_mm", "pitch_mm = 2, the distance of the dots"}}));
  PANELCAL_TRY(plate.columns, count(table, "columns"));
  PANELCAL_TRY(plate.rows, count(table, "rows"));
  PANELCAL_TRY(const auto pitch_mm, table.number("pitch_mm", kPlateLength_mm));
  plate.pitch = mm(pitch_mm.value());
  PANELCAL_TRY(const auto diameter_mm, table.number("dot_diameter_mm", kPlateLength_mm));
  if (!diameter_mm) return {};
  plate.dot_diameter = mm(*diameter_mm);
  if (plate.dot_diameter < plate.pitch) return {};
  return failure(table.problem("dot_diameter_mm", "less than the pitch", "dots would touch"));
}

Expected<void> read_plate_table(const TomlTable& table, CalibrationPlate& plate) {
  PANELCAL_CHECK(read_plate_dots(table, plate));
  PANELCAL_TRY(const auto name, table.text("name"));
  if (name) plate.name = *name;
  PANELCAL_TRY(const auto certified, table.truth("certified"));
  plate.is_certified = certified.value_or(false);
  PANELCAL_TRY(const auto polarity, table.text("polarity"));
  if (!polarity) return {};
  if (*polarity != "dark" && *polarity != "bright") {
    return failure(table.problem("polarity", "\"dark\" or \"bright\""));
  }
  plate.is_dark = *polarity == "dark";
  return {};
}

Expected<PlatePose> read_pose(const TomlTable& table) {
  PANELCAL_TRY(const auto origin_mm,
               table.pair("origin_mm", {-internal::kMaxPlace_mm, internal::kMaxPlace_mm}));
  if (!origin_mm) return failure(table.missing("origin_mm", "where the first dot lies, [x, y]"));
  PANELCAL_TRY(const double angle_deg, table.number_or("angle_deg", {-360, 360}, 0));
  return PlatePose{deg(angle_deg).in_rad(), *origin_mm};
}

}  // namespace

std::vector<PlateDot> CalibrationPlate::dots() const {
  std::vector<PlateDot> out;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      out.push_back({position_mm<frame::Plate>(column * pitch.in_mm(), row * pitch.in_mm()),
                     is_certified,
                     0.5 * dot_diameter});
    }
  }
  return out;
}

std::vector<bool> CalibrationPlate::covered_dots() const {
  std::vector<bool> covered(n_dots(), false);
  if (!tags) return covered;
  const std::vector<PlateDot> all = dots();
  const Length half_side = half_side_of(*tags);
  // However a tag is turned, it reaches no farther than its corners.
  const double reach = std::sqrt(2) * half_side / pitch + 1;
  const auto from = [&](double at) {
    return static_cast<int>(std::max(0.0, std::ceil(at - reach)));
  };
  const auto to = [&](double at, int n) {
    return static_cast<int>(std::min(n - 1.0, std::floor(at + reach)));
  };
  for (const PlateTag& tag : tags->tags) {
    const Eigen::Vector2d cell = tag.center.in_mm() / pitch.in_mm();
    for (int row = from(cell.y()); row <= to(cell.y(), rows); ++row) {
      for (int column = from(cell.x()); column <= to(cell.x(), columns); ++column) {
        const std::size_t i = index(column, row);
        if (covers_dot(tag, half_side, all[i])) covered[i] = true;
      }
    }
  }
  return covered;
}

Position<frame::Machine> place_in(const PlatePose& pose, const Position<frame::Plate>& on_plate) {
  const double c = std::cos(pose.angle_rad);
  const double s = std::sin(pose.angle_rad);
  const Eigen::Vector2d& p = on_plate.in_mm();
  return position_mm<frame::Machine>(
      (Eigen::Vector2d(c * p.x() - s * p.y(), s * p.x() + c * p.y()) + pose.shift_mm).eval());
}

Expected<CalibrationPlate> parse_plate(std::string_view text, const std::filesystem::path& file) {
  const TomlSource source{file.string(), text};
  PANELCAL_TRY(const toml::table document, internal::parse_toml(source));
  PANELCAL_TRY(
      const TomlTable top,
      TomlTable::make(document, "the file", document.source(), {kPlateFileKeys, {}}, source));
  PANELCAL_TRY(const auto table, top.table("plate", "[plate]", {kPlateKeys, {}}));
  if (!table) return failure(top.missing("[plate]", "[plate] columns, rows, pitch_mm"));
  CalibrationPlate plate;
  plate.file = file;
  PANELCAL_CHECK(read_plate_table(*table, plate));
  PANELCAL_TRY(const auto poses, top.tables("pose", "[[pose]]", {kPoseKeys, {}}));
  for (const TomlTable& pose : poses) {
    PANELCAL_TRY(plate.poses.emplace_back(), read_pose(pose));
  }
  PANELCAL_TRY(plate.tags, internal::read_plate_tags(top, plate.pitch));
  if (std::ranges::all_of(plate.covered_dots(), [](bool is) { return is; })) {
    return failure(top.missing("dot that no tag covers", "dots beside the tags"));
  }
  return plate;
}

Expected<CalibrationPlate> read_plate(const std::filesystem::path& file) {
  PANELCAL_TRY(const std::string text, read_file(file, kMaxPlateBytes));
  return parse_plate(text, file);
}

}  // namespace panelcal
