// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/spindle/coupon.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <system_error>
#include <vector>

#include "calib/base/amount.h"
#include "calib/base/fields/json.h"
#include "calib/base/fields/slots.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/json/strict_json.h"
#include "calib/ledger/ledger.h"
#include "machine/config/json_files.h"
#include "machine/config/machine_name.h"
#include <fmt/format.h>

namespace panelcal {
namespace internal {
namespace {

constexpr int kMaxCouponRows = 1'000'000;

/// Content of the state file.
struct CouponState {
  std::string name;
  int n_used = 0;
};

#include "machine/calibrate/spindle/coupon.def"

}  // namespace

JsonFile coupon_file() {
  return {"coupon.json",
          "Rows of a coupon that are used up: `[coupon] state` of machine.toml names it. It is "
          "written before the first hole of a run is drilled; with a ledger it is the result of an "
          "entry of kind `coupon` too.",
          {&kCouponState}};
}

}  // namespace internal

namespace {

using State = internal::CouponState;

constexpr std::size_t kMaxStateBytes = std::size_t{1} << 16;
constexpr std::string_view kRowsUsed = "rows_used";

std::string state_text(const State& state) {
  return internal::json_text(internal::kCouponState, state, internal::JsonStyle::File);
}

LedgerKey coupon_key(const MachineConfig& config) {
  return {machine_name(config), LedgerKind::Coupon, config.coupon->name};
}

Expected<int> rows_of_file(const Coupon& coupon) {
  std::error_code ignored;
  // Only what is certainly not there is a new coupon; what cannot be read is an error.
  const auto status = std::filesystem::symlink_status(coupon.state_file, ignored);
  if (status.type() == std::filesystem::file_type::not_found) return 0;
  PANELCAL_TRY(const std::string text, read_file(coupon.state_file, kMaxStateBytes));
  const std::string file = coupon.state_file.string();
  PANELCAL_TRY(const nlohmann::json document, internal::parse_strict_json(text, file));
  PANELCAL_TRY(
      const State state,
      internal::read_json(internal::kCouponState, document, Code::CalibrationInvalid, file));
  return state.name == coupon.name ? state.n_used : 0;
}

Expected<std::optional<int>> rows_of_ledger(const Ledger& ledger, const LedgerKey& key) {
  std::optional<int> rows;
  PANELCAL_TRY(const std::vector<LedgerEntry> newest, ledger.list(key, 1));
  if (newest.empty()) return rows;
  const LedgerRecord& record = newest.front().record;
  const auto i = record.find(kRowsUsed);
  const double n_used = i ? record.parameters[*i].value : -1;
  if (!(n_used >= 0 && n_used <= internal::kMaxCouponRows)) {
    return failure({Code::CalibrationInvalid,
                    {fmt::format("ledger entry {}", newest.front().id), 0, 0},
                    "it does not say how many rows are used",
                    fmt::format("{} from 0 to {}", kRowsUsed, internal::kMaxCouponRows)});
  }
  rows = static_cast<int>(n_used);
  return rows;
}

Expected<void> record_rows(const MachineConfig& config, const State& state, const TakenBy& by) {
  if (!by.clock) {
    return failure({Code::LedgerEntryInvalid,
                    {config.ledger_file.string(), 0, 0},
                    "rows of the coupon are taken at a time that is not known",
                    "a clock in CalibrationDevices::taken_by"});
  }
  LedgerDraft draft;
  draft.record.key = coupon_key(config);
  draft.record.asked_by = by.asked_by;
  draft.record.software = by.software;
  draft.record.parameters = {{std::string(kRowsUsed), static_cast<double>(state.n_used), "1"}};
  draft.result = state_text(state);
  PANELCAL_TRY(Ledger ledger, Ledger::open(config.ledger_file, by.clock));
  PANELCAL_CHECK(ledger.append(draft));
  return {};
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

Expected<UsedRows> used_rows(const MachineConfig& config) {
  const Coupon& coupon = *config.coupon;
  UsedRows used;
  PANELCAL_TRY(used.by_file, rows_of_file(coupon));
  std::error_code ignored;
  if (config.ledger_file.empty() || !std::filesystem::exists(config.ledger_file, ignored)) {
    return used;
  }
  PANELCAL_TRY(const Ledger ledger, Ledger::open_to_read(config.ledger_file));
  PANELCAL_TRY(used.by_ledger, rows_of_ledger(ledger, coupon_key(config)));
  return used;
}

std::string missing_rows_text(const Coupon& coupon, const UsedRows& used) {
  if (used.by_file >= used.by_ledger.value_or(0)) return {};
  return fmt::format("{} has {} used, the ledger {}: the ledger counts",
                     quoted(coupon.state_file.filename().string()),
                     amount(used.by_file, "row"),
                     *used.by_ledger);
}

Expected<int> take_rows(const MachineConfig& config, const TakenBy& by) {
  const Coupon& coupon = *config.coupon;
  if (by.check_ledger) PANELCAL_CHECK(by.check_ledger());
  PANELCAL_TRY(const UsedRows used, used_rows(config));
  const int n_used = used.count();
  if (n_used > coupon.rows - coupon.rows_per_run) {
    return failure(
        {Code::ConfigValue,
         coupon.place,
         fmt::format(
             "{}, and a calibration takes {}", free_rows_text(coupon, n_used), coupon.rows_per_run),
         "a new coupon on the table, and its name in [coupon]"});
  }
  const State state = {coupon.name, n_used + coupon.rows_per_run};
  if (!config.ledger_file.empty()) PANELCAL_CHECK(record_rows(config, state, by));
  PANELCAL_CHECK(write_file(coupon.state_file, state_text(state)));
  return n_used;
}

}  // namespace panelcal
