// SPDX-License-Identifier: Apache-2.0
#include "machine/config/plate/plate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "calib/base/fields/slots.h"
#include "calib/base/files/atomic_file.h"
#include "machine/config/plate/plate_tags.h"
#include "machine/config/toml/ranges.h"
#include "machine/config/toml/toml_table.h"

namespace panelcal {
namespace {

using internal::count;
using internal::field;
using internal::Field;
using internal::FileDescription;
using internal::kMaxPlace_mm;
using internal::kPlace;
using internal::Range;
using internal::Rows;
using internal::Table;
using internal::TableDescription;
using internal::TomlSource;
using internal::TomlTable;
using internal::WholeRange;
using internal::word;

constexpr Range kPlateLength_mm{0, kMaxPlace_mm, true};
constexpr Range kPlateUncertainty_um{0, 1000, true};
/// A hundred thousand dots are more than any plate has.
constexpr WholeRange kDotsPerSide{1, 300};

/// A row of [[pose]].
struct PoseKeys {
  Eigen::Vector2d origin_mm = Eigen::Vector2d::Zero();
  Angle angle;
};

std::optional<bool> is_dark_from_word(std::string_view word) {
  if (word == "dark") return true;
  if (word == "bright") return false;
  return std::nullopt;
}

#include "machine/config/plate/plate.def"

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
  FileDescription description{"the file", {&kPlate, &kPose}};
  for (const TableDescription* const table : internal::plate_tag_tables())
    description.tables.push_back(table);
  PANELCAL_TRY(const toml::table document, internal::parse_toml(source));
  PANELCAL_TRY(const TomlTable top, TomlTable::of_file(document, description, source));
  CalibrationPlate plate;
  plate.file = file;
  PANELCAL_TRY(const auto table, top.read_table(kPlate, plate));
  if (!table) return failure(top.missing("[plate]", "[plate] columns, rows, pitch_mm"));
  if (plate.dot_diameter >= plate.pitch) {
    return failure(table->problem("dot_diameter_mm", "less than the pitch", "dots would touch"));
  }
  if (plate.expanded_uncertainty && !plate.is_certified) {
    return failure(table->problem(
        "expanded_uncertainty_um", "certified = true beside it", "the plate is not certified"));
  }
  PANELCAL_TRY(const auto poses, top.tables(kPose));
  for (const TomlTable& row : poses) {
    PoseKeys pose;
    PANELCAL_CHECK(row.read(kPose, pose));
    plate.poses.push_back({pose.angle.in_rad(), pose.origin_mm});
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
