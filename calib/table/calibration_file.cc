// SPDX-License-Identifier: Apache-2.0
#include "calib/table/calibration_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "calib/base/append_format.h"
#include "calib/base/clock.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/json/noted_head.h"
#include "calib/base/json/strict_json.h"
#include "calib/base/statistics/covariance_check.h"
#include <Eigen/LU>
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::StrictObject;

constexpr std::string_view kTableKind = "table";
constexpr int kTableVersion = 1;
/// Larger errors are no errors of a table but a wrong unit.
constexpr double kMostError_mm = 100;
constexpr double kMostPlace_mm = 1e5;
/// Steps of the lattice on which a map is looked at, between two knots.
constexpr int kPerStep = 4;

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

Expected<void> check_grid(const TableGrid& grid, const std::string& file) {
  const bool is_near = grid.low_mm.cwiseAbs().maxCoeff() <= kMostPlace_mm &&
                       grid.high_mm.cwiseAbs().maxCoeff() <= kMostPlace_mm;
  if (grid.is_valid() && is_near) return {};
  return failure(invalid_table_file(
      file,
      "the grid has no area or no steps",
      "low_mm below high_mm, both within 100 m, 1 to 256 steps along each axis"));
}

Expected<void> check_table_calibration(const TableCalibration& c, const std::string& file) {
  PANELCAL_CHECK(check_grid(c.map.grid(), file));
  for (const Eigen::Vector2d& knot_mm : c.map.coefficients_mm()) {
    if (knot_mm.allFinite() && knot_mm.norm() <= kMostError_mm) continue;
    return failure(
        invalid_table_file(file,
                           fmt::format("a coefficient is ({}, {}) mm", knot_mm.x(), knot_mm.y()),
                           fmt::format("errors of at most {} mm", kMostError_mm)));
  }
  if (!is_one_to_one(c.map)) {
    return failure(invalid_table_file(file,
                                      "the map is not one to one: it folds the table over itself",
                                      "errors that grow much slower than the way"));
  }
  if (!c.geometry.value.allFinite()) {
    return failure(invalid_table_file(file, "the geometry is not finite", "finite numbers"));
  }
  if (const auto flaw = internal::covariance_flaw(c.geometry.cov)) {
    return failure(invalid_table_file(file, std::string(flaw->what), std::string(flaw->expected)));
  }
  for (const Length size : {c.sigma, c.rms, c.held_out_rms.value_or(Length())}) {
    if (std::isfinite(size.in_mm()) && size >= Length()) continue;
    return failure(invalid_table_file(
        file, "sigma_mm, rms_mm or held_out_rms_mm is negative or not finite", "mm, 0 or more"));
  }
  return {};
}

/// "straightness_x_2", as the file has it.
std::string key_of(int i) {
  std::string key(TableGeometry::name(static_cast<TableGeometry::Index>(i)));
  std::ranges::replace(key, ' ', '_');
  return key;
}

Expected<TableMap> read_map(const StrictObject& top, const std::string& file) {
  constexpr std::array<std::string_view, 3> kGridKeys = {"low_mm", "high_mm", "steps"};
  PANELCAL_TRY(
      const StrictObject object,
      StrictObject::make(top.member("grid"), "grid", kGridKeys, Code::CalibrationInvalid, file));
  TableGrid grid;
  PANELCAL_TRY(const std::vector<double> low_mm, object.numbers("low_mm", 2));
  PANELCAL_TRY(const std::vector<double> high_mm, object.numbers("high_mm", 2));
  PANELCAL_TRY(const std::vector<double> steps, object.numbers("steps", 2));
  grid.low_mm << low_mm[0], low_mm[1];
  grid.high_mm << high_mm[0], high_mm[1];
  for (const double n : steps) {
    if (n >= 1 && n <= 256 && n == std::floor(n)) continue;
    return failure(invalid_table_file(file, fmt::format("a number of steps is {}", n), "1 to 256"));
  }
  grid.nx = static_cast<int>(steps[0]);
  grid.ny = static_cast<int>(steps[1]);
  PANELCAL_CHECK(check_grid(grid, file));
  const auto n = static_cast<std::size_t>(grid.n_coefficients());
  PANELCAL_TRY(const std::vector<double> numbers, top.matrix("coefficients_mm", n, 2));
  std::vector<Eigen::Vector2d> coefficients_mm;
  for (std::size_t i = 0; i < n; ++i) {
    coefficients_mm.emplace_back(numbers[2 * i], numbers[2 * i + 1]);
    if (!coefficients_mm.back().allFinite()) {
      return failure(invalid_table_file(file, "a coefficient is not finite", "finite numbers"));
    }
  }
  return TableMap(grid, std::move(coefficients_mm));
}

Expected<TableGeometry> read_geometry(const StrictObject& top, const std::string& file) {
  std::vector<std::string> names;
  for (int i = 0; i < TableGeometry::kSize; ++i) names.push_back(key_of(i));
  const std::vector<std::string_view> keys(names.begin(), names.end());
  PANELCAL_TRY(
      const StrictObject object,
      StrictObject::make(top.member("geometry"), "geometry", keys, Code::CalibrationInvalid, file));
  TableGeometry geometry;
  for (int i = 0; i < TableGeometry::kSize; ++i) {
    PANELCAL_TRY(geometry.value[i], object.number(keys[static_cast<std::size_t>(i)]));
  }
  constexpr std::size_t kN = TableGeometry::kSize;
  PANELCAL_TRY(const std::vector<double> cov, top.matrix("geometry_covariance", kN, kN));
  geometry.cov = Eigen::Map<
      const Eigen::Matrix<double, TableGeometry::kSize, TableGeometry::kSize, Eigen::RowMajor>>(
      cov.data());
  return geometry;
}

Expected<std::vector<std::string>> read_undetermined_modes(const StrictObject& top,
                                                           const std::string& file) {
  std::vector<std::string> out;
  const nlohmann::json& list = top.member("undetermined");
  bool is_list = list.is_array();
  for (const nlohmann::json& element : list) {
    const auto* text = element.get_ptr<const std::string*>();
    is_list = is_list && text != nullptr;
    if (text != nullptr) out.push_back(*text);
  }
  if (is_list) return out;
  return failure(
      invalid_table_file(file, "\"undetermined\" is no array of texts", "[\"scale\", ...] or []"));
}

Expected<void> check_table_units(const StrictObject& top, const std::string& file) {
  constexpr std::array<std::string_view, 2> kKeys = {"length", "angle"};
  PANELCAL_TRY(
      const StrictObject units,
      StrictObject::make(top.member("units"), "units", kKeys, Code::CalibrationInvalid, file));
  PANELCAL_CHECK(units.constant("length", "mm"));
  return units.constant("angle", "rad");
}

Expected<void> read_table_record(const StrictObject& top,
                                 const std::string& file,
                                 TableCalibration& c) {
  PANELCAL_TRY(const std::string date, top.text("date"));
  const auto time = from_iso_8601(date);
  if (!time) {
    return failure(invalid_table_file(
        file, "\"date\" is " + quoted(date), "a time such as 2026-11-21T08:37:38Z"));
  }
  c.date = *time;
  PANELCAL_TRY(c.provenance, top.text("provenance"));
  PANELCAL_TRY(const double sigma_mm, top.number("sigma_mm"));
  PANELCAL_TRY(const double rms_mm, top.number("rms_mm"));
  c.sigma = mm(sigma_mm);
  c.rms = mm(rms_mm);
  if (top.member("held_out_rms_mm").is_null()) return {};
  PANELCAL_TRY(const double held_out_mm, top.number("held_out_rms_mm"));
  c.held_out_rms = mm(held_out_mm);
  return {};
}

std::string json_text(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

std::string map_text(const TableMap& map) {
  const TableGrid& grid = map.grid();
  std::string text = fmt::format(
      R"(  "grid": {{"low_mm": [{}, {}], "high_mm": [{}, {}], "steps": [{}, {}]}},
  "coefficients_mm": [
)",
      grid.low_mm.x(),
      grid.low_mm.y(),
      grid.high_mm.x(),
      grid.high_mm.y(),
      grid.nx,
      grid.ny);
  const auto& knots_mm = map.coefficients_mm();
  for (std::size_t i = 0; i < knots_mm.size(); ++i) {
    const char* end = i + 1 < knots_mm.size() ? "," : "";
    text += fmt::format("    [{}, {}]{}\n", knots_mm[i].x(), knots_mm[i].y(), end);
  }
  return text + "  ],\n";
}

std::string geometry_text(const TableGeometry& geometry) {
  std::string text = "  \"geometry\": {\n";
  constexpr int kN = TableGeometry::kSize;
  for (int i = 0; i < kN; ++i) {
    text += fmt::format("    \"{}\": {}{}\n", key_of(i), geometry.value[i], i + 1 < kN ? "," : "");
  }
  text += "  },\n  \"geometry_covariance\": [\n";
  for (int i = 0; i < kN; ++i) {
    const Eigen::Matrix<double, 1, kN> row = geometry.cov.row(i);
    text += fmt::format(
        "    [{}]{}\n", internal::joined({row.data(), kN}, ", "), i + 1 < kN ? "," : "");
  }
  return text + "  ],\n";
}

}  // namespace

TableCalibration calibration_of(const TableFit& fit) {
  TableCalibration c;
  c.map = fit.map;
  c.geometry = fit.geometry;
  c.undetermined = fit.undetermined;
  double sum_mm2 = 0;
  int n = 0;
  all_over(fit.map.grid(), [&](const Position<frame::Machine>& place) {
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
  constexpr std::array<std::string_view, 13> kKeys = {"kind",
                                                      "version",
                                                      "date",
                                                      "provenance",
                                                      "units",
                                                      "grid",
                                                      "coefficients_mm",
                                                      "geometry",
                                                      "geometry_covariance",
                                                      "undetermined",
                                                      "sigma_mm",
                                                      "rms_mm",
                                                      "held_out_rms_mm"};
  PANELCAL_TRY(const nlohmann::json document, internal::parse_calibration_json(text, file));
  PANELCAL_TRY(
      const StrictObject top,
      StrictObject::make(document, "the calibration", kKeys, Code::CalibrationInvalid, file));
  PANELCAL_CHECK(top.constant("kind", kTableKind));
  PANELCAL_CHECK(top.integer("version", kTableVersion, kTableVersion));
  PANELCAL_CHECK(check_table_units(top, file));
  TableCalibration c;
  PANELCAL_CHECK(read_table_record(top, file, c));
  PANELCAL_TRY(c.map, read_map(top, file));
  PANELCAL_TRY(c.geometry, read_geometry(top, file));
  PANELCAL_TRY(c.undetermined, read_undetermined_modes(top, file));
  PANELCAL_CHECK(check_table_calibration(c, file));
  return c;
}

Expected<TableCalibration> read_table_calibration(const std::filesystem::path& path) {
  PANELCAL_TRY(const std::string text, read_file(path, kMaxTableCalibrationBytes));
  return parse_table_calibration(text, path.string());
}

std::string table_calibration_text(const TableCalibration& c) {
  std::string undetermined;
  for (const std::string& name : c.undetermined) {
    undetermined += (undetermined.empty() ? "" : ", ") + json_text(name);
  }
  const std::string held_out = c.held_out_rms ? fmt::format("{}", c.held_out_rms->in_mm()) : "null";
  return fmt::format(R"({{
  "kind": "{}",
  "version": {},
  "date": "{}",
  "provenance": {},
  "units": {{"length": "mm", "angle": "rad"}},
)",
                     kTableKind,
                     kTableVersion,
                     iso_8601(c.date),
                     json_text(c.provenance)) +
         map_text(c.map) + geometry_text(c.geometry) +
         fmt::format(R"(  "undetermined": [{}],
  "sigma_mm": {},
  "rms_mm": {},
  "held_out_rms_mm": {}
}}
)",
                     undetermined,
                     c.sigma.in_mm(),
                     c.rms.in_mm(),
                     held_out);
}

Expected<void> write_table_calibration(const std::filesystem::path& path,
                                       const TableCalibration& calibration) {
  PANELCAL_CHECK(check_table_calibration(calibration, path.string()));
  return write_file(path, table_calibration_text(calibration));
}

}  // namespace panelcal
