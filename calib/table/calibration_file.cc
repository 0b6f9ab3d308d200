// SPDX-License-Identifier: Apache-2.0
#include "calib/table/calibration_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "calib/base/fields/json.h"
#include "calib/base/fields/noted_head.h"
#include "calib/base/fields/slots.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/statistics/covariance_check.h"
#include "calib/json_files.h"
#include <Eigen/LU>
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// What a file holds: the map is of `grid` and `coefficients_mm`.
struct TableFile {
  TableCalibration table;
  TableGrid grid;
  std::vector<Eigen::Vector2d> coefficients_mm;
};

/// Larger errors are no errors of a table but a wrong unit.
constexpr double kMostError_mm = 100;
constexpr Range kTablePlace = {-1e5, 1e5};
/// Steps of the lattice on which a map is looked at, between two knots.
constexpr int kPerStep = 4;

/// One number of the geometry.
template <TableGeometry::Index i>
constexpr Field figure(std::string_view key, std::string_view meaning) {
  Field number = by_rule<TableGeometry>(key, FieldKind::Number, meaning);
  number.store = [](void* geometry, const FieldValue& value) {
    static_cast<TableGeometry*>(geometry)->value[i] = value.number;
    return true;
  };
  number.load = [](const void* geometry, FieldValue& value) {
    value.number = static_cast<const TableGeometry*>(geometry)->value[i];
    return true;
  };
  return number;
}

#include "calib/table/calibration.def"

Diagnostic invalid_table_file(const std::string& file, std::string what, std::string expected) {
  return {Code::CalibrationInvalid, {file, 0, 0}, std::move(what), std::move(expected)};
}

/// Calls `visit` at places all over a map's rectangle, its rim included, until it says false.
template <class Visit>
bool all_over(const TableGrid& grid, const Visit& visit) {
  const int nx = grid.nx * kPerStep;
  const int ny = grid.ny * kPerStep;
  for (int j = 0; j <= ny; ++j) {
    for (int i = 0; i <= nx; ++i) {
      const Eigen::Vector2d part(static_cast<double>(i) / nx, static_cast<double>(j) / ny);
      const Eigen::Vector2d place_mm = grid.low_mm + part.cwiseProduct(grid.high_mm - grid.low_mm);
      if (!visit(position_mm<frame::Machine>(place_mm))) return false;
    }
  }
  return true;
}

/// Everywhere the stage goes where it is sent, within what no table errs by, and turns nothing
/// over.
bool is_one_to_one(const TableMap& map) {
  return all_over(map.grid(), [&](const Position<frame::Machine>& place) {
    const Eigen::Matrix2d slope = Eigen::Matrix2d::Identity() + map.error_slope(place);
    return slope.determinant() > 0.5 && map.error_mm(place).norm() <= kMostError_mm;
  });
}

/// Checks what the rows of the file cannot express.
Expected<void> check_table_file(const TableFile& read, const std::string& file) {
  if (!read.grid.is_valid()) {
    return failure(invalid_table_file(
        file, "the grid has no area or no steps", "low_mm below high_mm, 1 to 256 steps"));
  }
  const auto n = static_cast<std::size_t>(read.grid.n_coefficients());
  if (read.coefficients_mm.size() != n) {
    return failure(
        invalid_table_file(file,
                           fmt::format("there are {} coefficients_mm", read.coefficients_mm.size()),
                           fmt::format("{}, (steps + 3) along each side", n)));
  }
  for (const Eigen::Vector2d& knot_mm : read.coefficients_mm) {
    if (knot_mm.norm() <= kMostError_mm) continue;
    return failure(
        invalid_table_file(file,
                           fmt::format("a knot is ({}, {}) mm", knot_mm.x(), knot_mm.y()),
                           fmt::format("errors of at most {} mm", kMostError_mm)));
  }
  if (!is_one_to_one(TableMap(read.grid, read.coefficients_mm))) {
    return failure(invalid_table_file(file,
                                      "the map is not one to one: it folds the table over itself",
                                      "errors that grow much slower than the way"));
  }
  if (const auto flaw = covariance_flaw(read.table.geometry.cov)) {
    return failure(invalid_table_file(file, std::string(flaw->what), std::string(flaw->expected)));
  }
  return {};
}

}  // namespace

JsonFile table_file() {
  return {"table.cal.json",
          "The calibration of a table: `panelcal calibrate table` writes it, `[table] calibration` "
          "of machine.toml names it. A map that folds the table over itself is refused.",
          {&kTable},
          true};
}

}  // namespace panelcal::internal

namespace panelcal {

TableCalibration calibration_of(const TableFit& fit) {
  TableCalibration c;
  c.map = fit.map;
  c.geometry = fit.geometry;
  c.undetermined = fit.undetermined;
  double sum_mm2 = 0;
  int n = 0;
  internal::all_over(fit.map.grid(), [&](const Position<frame::Machine>& place) {
    sum_mm2 += 0.5 * fit.covariance_at(place).trace();
    ++n;
    return true;
  });
  c.sigma = mm(std::sqrt(std::max(0.0, sum_mm2 / n)));
  c.rms = mm(fit.rms_mm);
  if (fit.held_out_rms_mm) c.held_out_rms = mm(*fit.held_out_rms_mm);
  return c;
}

Expected<TableCalibration> parse_table_calibration(std::string_view text, const std::string& file) {
  PANELCAL_TRY(const nlohmann::json document, internal::parse_calibration_json(text, file));
  PANELCAL_TRY(auto read,
               internal::read_json(internal::kTable, document, Code::CalibrationInvalid, file));
  PANELCAL_CHECK(internal::check_table_file(read, file));
  read.table.map = TableMap(read.grid, std::move(read.coefficients_mm));
  return std::move(read.table);
}

Expected<TableCalibration> read_table_calibration(const std::filesystem::path& path) {
  PANELCAL_TRY(const std::string text, read_file(path, kMaxTableCalibrationBytes));
  return parse_table_calibration(text, path.string());
}

std::string table_calibration_text(const TableCalibration& c) {
  const internal::TableFile file = {c, c.map.grid(), c.map.coefficients_mm()};
  return internal::json_text(internal::kTable, file, internal::JsonStyle::File);
}

Expected<void> write_table_calibration(const std::filesystem::path& path,
                                       const TableCalibration& calibration) {
  const std::string text = table_calibration_text(calibration);
  PANELCAL_CHECK(parse_table_calibration(text, path.string()));
  return write_file(path, text);
}

}  // namespace panelcal
