// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include "calib/base/fields/slots.h"
#include "calib/spindle/fit.h"
#include "machine/config/sections/sections.h"
#include "machine/config/toml/ranges.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr Range kCouponLength_mm{0, kMaxPlace_mm, true};
constexpr WholeRange kCount{1, 1000};
constexpr std::size_t kMaxCouponViews = 64;
constexpr std::string_view kApproach = "\"+x+y\", \"-x+y\", \"+x-y\", \"-x-y\" or one axis alone";
constexpr std::string_view kApproaches =
    "each \"+x+y\", \"-x+y\", \"+x-y\", \"-x-y\" or one axis alone";

bool put_looking(Coupon& coupon, const FieldValue& value) {
  coupon.looking.clear();
  for (const std::string& text : value.texts) {
    const auto approach = approach_from_text(text);
    if (!approach) return false;
    coupon.looking.push_back(*approach);
  }
  return true;
}

#include "machine/config/nightly/coupon.def"

Expected<void> check_lattice(const TomlTable& table, Coupon& coupon) {
  if (!table.has("rows_per_run")) coupon.rows_per_run = std::min(coupon.rows_per_run, coupon.rows);
  if (coupon.rows_per_run > coupon.rows) {
    return failure(table.problem("rows_per_run", fmt::format("at most the {} rows", coupon.rows)));
  }
  if (coupon.columns * coupon.rows_per_run >= kLeastHoles) return {};
  return failure(table.missing(
      "enough holes in a run",
      fmt::format("columns times rows_per_run of {} or more, better 9", kLeastHoles)));
}

/// Precondition: [camera] has been read
Expected<void> read_coupon(const TomlTable& top, MachineConfig& config) {
  Coupon coupon;
  PANELCAL_TRY(const auto table, top.read_table(kCoupon, coupon));
  if (!table) return {};
  coupon.place = top.place_of("coupon");
  coupon.rows_place = table->has("rows") ? table->place_of("rows") : coupon.place;
  PANELCAL_CHECK(check_lattice(*table, coupon));
  if (coupon.looking.empty() || coupon.looking.size() > kMaxCouponViews) {
    return failure(table->problem("approaches", fmt::format("1 to {} of them", kMaxCouponViews)));
  }
  if (!table->has("state")) coupon.state_file = table->folder() / coupon.state_file;
  config.coupon = coupon;
  config.walk.has_coupon = config.camera.has_value();
  return {};
}

}  // namespace

Section coupon_section() {
  return {kCouponTables, read_coupon};
}

}  // namespace panelcal::internal
