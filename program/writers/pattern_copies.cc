// SPDX-License-Identifier: Apache-2.0
#include "program/writers/pattern_copies.h"

#include <array>

namespace panelcal {
namespace {

/// Greatest error of sums of sines and cosines of whole quarter turns.
constexpr double kRounding = 1e-9;

bool is_same(const Eigen::Matrix2d& a, const Eigen::Matrix2d& b) {
  return (a - b).cwiseAbs().maxCoeff() < kRounding;
}

bool is_upright(const CopyRun& run) {
  return !run.mirror_x && !run.mirror_y && !run.swap_axes;
}

}  // namespace

WorkMap work_map(const Placement& copy) {
  return {copy.linear(), copy.translation()};
}

std::optional<CopyRun> copy_run(const Eigen::Matrix2d& linear) {
  for (int bits = 0; bits < 8; ++bits) {
    CopyRun run;
    run.mirror_x = (bits & 1) != 0;
    run.mirror_y = (bits & 2) != 0;
    run.swap_axes = (bits & 4) != 0;
    if (is_same(linear, copy_orientation(run))) return run;
  }
  return std::nullopt;
}

std::string_view offset_command(const Eigen::Matrix2d& linear) {
  struct Offset {
    double xx, xy, yx, yy;  // x' = xx x + xy y, y' = yx x + yy y
    std::string_view command;
  };
  constexpr std::array<Offset, 8> kOffsets = {{{1, 0, 0, 1, "M50"},
                                               {0, -1, 1, 0, "M60"},
                                               {-1, 0, 0, 1, "M70"},
                                               {1, 0, 0, -1, "M80"},
                                               {-1, 0, 0, -1, "M90"},
                                               {0, 1, 1, 0, "M60M70"},
                                               {0, -1, -1, 0, "M60M80"},
                                               {0, 1, -1, 0, "M60M90"}}};
  for (const Offset& offset : kOffsets) {
    Eigen::Matrix2d of_command;
    of_command << offset.xx, offset.xy, offset.yx, offset.yy;
    if (is_same(linear, of_command)) return offset.command;
  }
  return {};
}

std::vector<EqualCopies> rows_of(std::span<const SteppedCopy> copies, std::int64_t most) {
  std::vector<EqualCopies> rows;
  std::int64_t x = 0;
  std::int64_t y = 0;
  for (const SteppedCopy& copy : copies) {
    const EqualCopies next{copy.orientation, 1, copy.x - x, copy.y - y};
    x = copy.x;
    y = copy.y;
    if (!rows.empty() && rows.back().count < most && rows.back().step_x == next.step_x &&
        rows.back().step_y == next.step_y && is_upright(rows.back().orientation) &&
        is_upright(next.orientation)) {
      ++rows.back().count;
    } else {
      rows.push_back(next);
    }
  }
  return rows;
}

}  // namespace panelcal
