// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/spindle/coupon.h"

#include <array>
#include <string_view>
#include <system_error>

#include "calib/base/amount.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/json/strict_json.h"
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace panelcal {
namespace {

constexpr std::size_t kMaxStateBytes = std::size_t{1} << 16;
constexpr int kMaxRows = 1'000'000;

/// Content of the state file.
struct State {
  std::string name;
  int n_used = 0;
};

Expected<State> parse_state(const std::string& text, const std::string& file) {
  constexpr std::array<std::string_view, 4> kKeys = {"kind", "version", "coupon", "rows_used"};
  PANELCAL_TRY(const nlohmann::json document, internal::parse_strict_json(text, file));
  PANELCAL_TRY(const auto top,
               internal::StrictObject::make(
                   document, "the coupon's state", kKeys, Code::CalibrationInvalid, file));
  PANELCAL_CHECK(top.constant("kind", "coupon"));
  PANELCAL_TRY(const int version, top.integer("version", 1, 1));
  static_cast<void>(version);
  State state;
  PANELCAL_TRY(state.name, top.text("coupon"));
  PANELCAL_TRY(state.n_used, top.integer("rows_used", 0, kMaxRows));
  return state;
}

std::string state_text(const State& state) {
  const nlohmann::ordered_json document = {
      {"kind", "coupon"}, {"version", 1}, {"coupon", state.name}, {"rows_used", state.n_used}};
  // A name that is no UTF-8 must not throw.
  return document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace

std::vector<Position<frame::Machine>> places_from(const Coupon& coupon,
                                                  const Position<frame::Machine>& first) {
  std::vector<Position<frame::Machine>> places;
  const double pitch_mm = coupon.pitch.in_mm();
  for (int row = 0; row < coupon.rows_per_run; ++row) {
    for (int i = 0; i < coupon.columns; ++i) {
      const int column = row % 2 == 0 ? i : coupon.columns - 1 - i;
      places.push_back(first + displacement_mm<frame::Machine>(pitch_mm * column, pitch_mm * row));
    }
  }
  return places;
}

std::vector<Position<frame::Machine>> places_of_row(const Coupon& coupon, int i_row) {
  const auto up = displacement_mm<frame::Machine>(0, coupon.pitch.in_mm() * i_row);
  return places_from(coupon, coupon.origin + up);
}

std::string free_rows_text(const Coupon& coupon, int n_used) {
  const int n_free = coupon.rows - n_used;
  if (n_free <= 0) {
    return fmt::format(
        "all {} of coupon {} are used up", amount(coupon.rows, "row"), quoted(coupon.name));
  }
  return fmt::format("rows {} to {} of coupon {} are free ({} of {}): {} of {}",
                     n_used + 1,
                     coupon.rows,
                     quoted(coupon.name),
                     n_free,
                     coupon.rows,
                     amount(n_free / coupon.rows_per_run, "run"),
                     amount(coupon.rows_per_run, "row"));
}

Expected<int> used_rows(const Coupon& coupon) {
  std::error_code ignored;
  // Only what is certainly not there is a new coupon; what cannot be read is an error.
  const auto status = std::filesystem::symlink_status(coupon.state_file, ignored);
  if (status.type() == std::filesystem::file_type::not_found) return 0;
  PANELCAL_TRY(const std::string text, read_file(coupon.state_file, kMaxStateBytes));
  PANELCAL_TRY(const State state, parse_state(text, coupon.state_file.string()));
  return state.name == coupon.name ? state.n_used : 0;
}

Expected<int> take_rows(const Coupon& coupon) {
  PANELCAL_TRY(const int n_used, used_rows(coupon));
  if (n_used > coupon.rows - coupon.rows_per_run) {
    return failure(
        {Code::ConfigValue,
         coupon.place,
         fmt::format(
             "{}, and a calibration takes {}", free_rows_text(coupon, n_used), coupon.rows_per_run),
         "a new coupon on the table, and its name in [coupon]"});
  }
  PANELCAL_CHECK(
      write_file(coupon.state_file, state_text({coupon.name, n_used + coupon.rows_per_run})));
  return n_used;
}

}  // namespace panelcal
