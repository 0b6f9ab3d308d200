// SPDX-License-Identifier: Apache-2.0
#include "tests/program/writers/translation/boards.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal::test {

using Eigen::Vector2d;
using testing::IsEmpty;

FunctionSource panel_of_boards(const Vector2d& pitch_mm, const Vector2d& first_mm) {
  return FunctionSource([=](const MeasurementRequest& request) -> Vector2d {
    const Vector2d p = request.nominal.in_mm();
    const Vector2d board((p - first_mm).cwiseQuotient(pitch_mm).array().floor());
    const double k = board.x() + 3 * board.y();
    const double angle_rad = 0.0003 * std::sin(1 + 2 * k);
    const Vector2d in_board = p - first_mm - board.cwiseProduct(pitch_mm);
    const Vector2d moved = p + angle_rad * Vector2d(-in_board.y(), in_board.x()) +
                           0.04 * Vector2d(std::cos(k), std::sin(3 * k));
    return {1.0003 * moved.x() - 0.002 * moved.y() + 0.4,
            0.002 * moved.x() + 0.9998 * moved.y() - 0.2};
  });
}

namespace {

/// Both languages write six decimals of a millimetre or more.
constexpr double kSamePlace_mm = 1e-5;

/// Where a tool works.
struct WorkedPlace {
  int tool = 0;  ///< 0: routed
  Vector2d nominal_mm;
  Vector2d corrected_mm;
};

/// Holes, also those at targets of their own, slots and ends of routed pieces.
std::vector<WorkedPlace> worked_places(const WorkRun& run) {
  std::vector<WorkedPlace> places;
  const auto add = [&](int tool, const PlacedPoint& place) {
    places.push_back({tool, place.nominal.in_mm(), place.corrected.in_mm()});
  };
  for (const Event& event : work_of(run.events)) {
    if (const auto* drill = std::get_if<Drill>(&event.what)) add(drill->tool, *drill);
    if (const auto* slot = std::get_if<Slot>(&event.what)) {
      add(slot->tool, slot->start);
      add(slot->tool, slot->end);
    }
    if (const auto* rout = std::get_if<Rout>(&event.what)) add(0, *rout);
  }
  return places;
}

/// In Excellon.
bool is_target_hole(const MeasurementRequest& request) {
  return request.command == "G38" || request.command == "G48";
}

}  // namespace

double distance_um(const WorkRun& a,
                   const FunctionSource& looks_a,
                   const WorkRun& b,
                   const FunctionSource& looks_b,
                   bool loses_looks) {
  const std::vector<WorkedPlace> from = worked_places(a);
  const std::vector<WorkedPlace> to = worked_places(b);
  if (from.size() != to.size()) return -1;
  double worst_mm = 0;
  const auto compare = [&](const Vector2d& x_mm, const Vector2d& y_mm) {
    worst_mm = std::max(worst_mm, (x_mm - y_mm).norm());
  };
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (from[i].tool != to[i].tool) return -1;
    if ((from[i].nominal_mm - to[i].nominal_mm).norm() > kSamePlace_mm) return -1;
    compare(from[i].corrected_mm, to[i].corrected_mm);
  }
  if (loses_looks) return 1000 * worst_mm;
  // The source may look at targets that no series uses.
  auto look = looks_a.requests().begin();
  for (const MeasurementRequest& same : looks_b.requests()) {
    look = std::find_if(look, looks_a.requests().end(), [&](const MeasurementRequest& request) {
      return (request.nominal - same.nominal).in_mm().norm() < kSamePlace_mm;
    });
    if (look == looks_a.requests().end()) return -1;
    // The other control looks for such a target under the whole correction.
    const bool is_hole = is_target_hole(*look) || is_target_hole(same);
    if (!is_hole) compare(look->expected.in_mm(), same.expected.in_mm());
    ++look;
  }
  return 1000 * worst_mm;
}

FunctionSource small_boards() {
  return panel_of_boards({50, 50}, {0, 0});
}

Expected<ProbeReading> BulgingBoard::probe(const ProbeRequest& request) {
  const Vector2d at_mm = request.nominal.in_mm();
  const double height_mm =
      1.6 + 0.001 * at_mm.x() + 0.0005 * at_mm.y() + 0.05 * std::sin(at_mm.x() / 30);
  ProbeReading reading{.request = request, .status = ProbeStatus::Found};
  reading.heights = {{mm(height_mm), um(1)}};
  return reading;
}

bool asks_alike(const WorkRun& a, const WorkRun& b) {
  const auto is_near = [](const auto& p, const auto& q) {
    return (p - q).in_mm().norm() < kLastDigit_mm;
  };
  if (a.requests.size() != b.requests.size() || a.probes.size() != b.probes.size()) return false;
  for (std::size_t i = 0; i < a.requests.size(); ++i) {
    const MeasurementRequest& p = a.requests[i];
    const MeasurementRequest& q = b.requests[i];
    if (p.command != q.command || p.axes != q.axes || p.settings.tools != q.settings.tools ||
        !is_near(p.nominal, q.nominal) || !is_near(p.expected, q.expected)) {
      return false;
    }
  }
  for (std::size_t i = 0; i < a.probes.size(); ++i) {
    const ProbeRequest& p = a.probes[i];
    const ProbeRequest& q = b.probes[i];
    if (p.command != q.command || p.tool != q.tool || p.memory != q.memory || p.depth != q.depth ||
        !is_near(p.nominal, q.nominal)) {
      return false;
    }
  }
  return true;
}

std::string same_holes(const std::string& text,
                       double limit_um,
                       FunctionSource panel,
                       const WalkOptions& options,
                       std::size_t n_losses) {
  const Translation translation = translate(text, other_language(text), options);
  EXPECT_THAT(translation.errors, IsEmpty());
  EXPECT_EQ(translation.losses.size(), n_losses) << testing::PrintToString(translation.losses);
  EXPECT_FALSE(translation.is_refused) << testing::PrintToString(translation.losses);
  FunctionSource panel_after = panel;
  const WorkRun before = run_on(panel, text, options);
  const WorkRun after = run_on(panel_after, translation.text, options);
  EXPECT_THAT(before.errors, IsEmpty());
  EXPECT_THAT(after.errors, IsEmpty()) << translation.text;
  EXPECT_FALSE(before.events.empty());
  const double worst_um = distance_um(before, panel, after, panel_after, n_losses > 0);
  EXPECT_GE(worst_um, 0) << translation.text;
  EXPECT_LT(worst_um, limit_um) << translation.text;
  return translation.text;
}

namespace {

enum class Asks : std::uint8_t { Anything, Alike };

void expect_same_strokes(const std::string& text,
                         const Translation& there,
                         const WalkOptions& options,
                         Asks asks) {
  EXPECT_THAT(there.errors, IsEmpty());
  EXPECT_FALSE(there.is_refused) << testing::PrintToString(there.losses);
  FunctionSource panel = small_boards();
  FunctionSource panel_after = small_boards();
  BulgingBoard board;
  const WorkRun before = run_on(panel, board, text, options);
  const WorkRun after = run_on(panel_after, board, there.text, options);
  EXPECT_THAT(before.errors, IsEmpty());
  EXPECT_THAT(after.errors, IsEmpty()) << there.text;
  EXPECT_FALSE(work_of(before.events).empty());
  const double worst_um = distance_um(before, panel, after, panel_after, true);
  EXPECT_GE(worst_um, 0) << there.text;
  EXPECT_LT(worst_um, kSameFit_um) << there.text;
  if (other_language(text) == other_language(there.text)) {
    EXPECT_EQ(difference_of_work(before, after), "") << there.text;
  }
  if (asks == Asks::Alike) {
    EXPECT_TRUE(asks_alike(before, after)) << there.text;
  }
}

}  // namespace

std::string same_strokes(const std::string& text, Dialect to, const WalkOptions& options) {
  const Translation there = translate(text, to, options);
  expect_same_strokes(text, there, options, Asks::Anything);
  return there.text;
}

std::string same_orders(const std::string& text, const WalkOptions& options) {
  const Translation same = translate(text, Dialect::SiebMeyer, options);
  EXPECT_THAT(same.losses, IsEmpty());
  expect_same_strokes(text, same, options, Asks::Alike);
  return same.text;
}

std::string boards_in_excellon(const std::string& body) {
  return "M48\nMETRIC,LZ\nT1C1.0\nT2C2.0\n%\nG34,1\n" + body + "M30\n";
}

}  // namespace panelcal::test
