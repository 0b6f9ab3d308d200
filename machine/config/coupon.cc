// SPDX-License-Identifier: Apache-2.0
#include "machine/config/coupon.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "calib/spindle/fit.h"
#include "machine/config/ranges.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr std::array<std::string_view, 13> kCouponTableKeys = {"approach_mm",
                                                               "approaches",
                                                               "columns",
                                                               "drill_approach",
                                                               "drill_tool",
                                                               "entry_material",
                                                               "name",
                                                               "origin_mm",
                                                               "pitch_mm",
                                                               "rows",
                                                               "rows_per_run",
                                                               "state",
                                                               "vision_tool"};
constexpr Range kCouponLength_mm{0, kMaxPlace_mm, true};
constexpr int kMaxCount = 1000;
constexpr std::size_t kMaxCouponViews = 64;
constexpr std::string_view kApproach = "\"+x+y\", \"-x+y\", \"+x-y\", \"-x-y\" or one axis alone";

Expected<void> read_count(const TomlTable& table, std::string_view key, int low, int& count) {
  PANELCAL_TRY(const auto value, table.integer(key, low, kMaxCount));
  if (value) count = static_cast<int>(*value);
  return {};
}

Expected<void> read_lattice(const TomlTable& table, Coupon& coupon) {
  PANELCAL_TRY(const auto origin_mm, table.pair("origin_mm", kPlace));
  if (!origin_mm) return failure(table.missing("origin_mm", "origin_mm = [x, y]"));
  coupon.origin = position_mm<frame::Machine>(*origin_mm);
  PANELCAL_CHECK(read_count(table, "columns", 1, coupon.columns));
  PANELCAL_CHECK(read_count(table, "rows", 1, coupon.rows));
  coupon.rows_per_run = std::min(coupon.rows_per_run, coupon.rows);
  PANELCAL_CHECK(read_count(table, "rows_per_run", 1, coupon.rows_per_run));
  if (coupon.rows_per_run > coupon.rows) {
    return failure(table.problem("rows_per_run", fmt::format("at most the {} rows", coupon.rows)));
  }
  if (coupon.columns * coupon.rows_per_run < kLeastHoles) {
    return failure(table.missing(
        "enough holes in a run",
        fmt::format("columns times rows_per_run of {} or more, better 9", kLeastHoles)));
  }
  PANELCAL_TRY(const double pitch_mm,
               table.number_or("pitch_mm", kCouponLength_mm, coupon.pitch.in_mm()));
  coupon.pitch = mm(pitch_mm);
  return {};
}

Expected<void> read_approaches(const TomlTable& table, Coupon& coupon) {
  PANELCAL_TRY(const auto drilling, table.text("drill_approach"));
  if (drilling) {
    const auto approach = approach_from_text(*drilling);
    if (!approach) return failure(table.problem("drill_approach", std::string(kApproach)));
    coupon.drilling = *approach;
  }
  PANELCAL_TRY(const double distance_mm,
               table.number_or("approach_mm", kCouponLength_mm, coupon.approach_distance.in_mm()));
  coupon.approach_distance = mm(distance_mm);
  PANELCAL_TRY(const std::vector<std::string> looking, table.texts("approaches"));
  if (!table.has("approaches")) return {};
  if (looking.empty() || looking.size() > kMaxCouponViews) {
    return failure(table.problem("approaches", fmt::format("1 to {} of them", kMaxCouponViews)));
  }
  coupon.looking.clear();
  for (const std::string& text : looking) {
    const auto approach = approach_from_text(text);
    if (!approach) return failure(table.problem("approaches", "each " + std::string(kApproach)));
    coupon.looking.push_back(*approach);
  }
  return {};
}

Expected<void> read_coupon_tools(const TomlTable& table, Coupon& coupon) {
  PANELCAL_TRY(const auto drill, table.integer("drill_tool", 1, kMaxToolNumber));
  if (drill) coupon.drill_tool = static_cast<int>(*drill);
  PANELCAL_TRY(const auto vision, table.integer("vision_tool", 1, kMaxToolNumber));
  if (vision) coupon.vision_tool = static_cast<int>(*vision);
  PANELCAL_TRY(const auto entry, table.truth("entry_material"));
  coupon.has_entry_material = entry.value_or(coupon.has_entry_material);
  return {};
}

}  // namespace

Expected<std::optional<Coupon>> read_coupon_config(const TomlTable& top,
                                                   const std::filesystem::path& folder) {
  PANELCAL_TRY(const auto table, top.table("coupon", "[coupon]", {kCouponTableKeys, {}}));
  if (!table) return std::nullopt;
  Coupon coupon;
  coupon.place = top.problem("coupon", "").place;
  coupon.rows_place = table->has("rows") ? table->problem("rows", "").place : coupon.place;
  PANELCAL_TRY(const auto name, table->text("name"));
  if (name && name->empty())
    return failure(table->problem("name", "the name that is written on it"));
  coupon.name = name.value_or(coupon.name);
  PANELCAL_CHECK(read_lattice(*table, coupon));
  PANELCAL_CHECK(read_coupon_tools(*table, coupon));
  PANELCAL_CHECK(read_approaches(*table, coupon));
  PANELCAL_TRY(const auto state, table->text("state"));
  if (state && state->empty()) return failure(table->problem("state", "the name of a file"));
  coupon.state_file = folder / state.value_or(coupon.state_file.string());
  return coupon;
}

}  // namespace panelcal::internal
