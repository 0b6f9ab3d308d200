// SPDX-License-Identifier: Apache-2.0
#include "machine/check/coupon_rules.h"

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "machine/calibrate/surface/run.h"
#include <Eigen/Core>
#include <fmt/format.h>

namespace panelcal {
namespace {

/// A rectangle of the machine, mm.
struct MachineArea {
  Eigen::Vector2d low_mm;
  Eigen::Vector2d high_mm;

  std::string text() const {
    return fmt::format("({:.3f}, {:.3f}) to ({:.3f}, {:.3f}) mm",
                       low_mm.x(),
                       low_mm.y(),
                       high_mm.x(),
                       high_mm.y());
  }
};

/// Touching counts.
bool do_meet(const MachineArea& one, const MachineArea& other) {
  return (one.low_mm.array() <= other.high_mm.array()).all() &&
         (other.low_mm.array() <= one.high_mm.array()).all();
}

/// Diameter of the holes as [coupon] vision_tool has it; empty if that tool is not defined, or has
/// pixels and there is no camera.
std::optional<double> coupon_hole_mm(const MachineConfig& config) {
  const auto tool = config.vision_tools.find(config.coupon->vision_tool);
  if (tool == config.vision_tools.end()) return std::nullopt;
  const Target& target = tool->second;
  if (target.size) return target.size->in_mm();
  if (!config.camera || !target.size_px) return std::nullopt;
  return target.size_px->in_px() * config.camera->parameters.scale_mm_per_px;
}

/// All rows that runs take, the holes' rims included.
MachineArea drilled_area(const MachineConfig& config) {
  const Coupon& coupon = *config.coupon;
  const Eigen::Vector2d rim_mm = Eigen::Vector2d::Constant(coupon_hole_mm(config).value_or(0) / 2);
  const int n_rows = coupon.rows - coupon.rows % coupon.rows_per_run;
  const Eigen::Vector2d steps(coupon.columns - 1, n_rows - 1);
  const Eigen::Vector2d origin_mm = coupon.origin.in_mm();
  return {origin_mm - rim_mm, origin_mm + coupon.pitch.in_mm() * steps + rim_mm};
}

bool does_calibrate(const NightlyConfig& nightly, std::string_view kind) {
  return std::ranges::find(nightly.calibrate, kind) != nightly.calibrate.end();
}

void check_pitch(const MachineConfig& config, const StatedKeys& keys, DiagnosticLog& log) {
  const Coupon& coupon = *config.coupon;
  const std::optional<double> size_mm = coupon_hole_mm(config);
  if (!size_mm || coupon.pitch.in_mm() > *size_mm) return;
  log.add({Code::ConfigValue,
           keys.place("coupon.pitch_mm"),
           fmt::format("pitch_mm in [coupon] is {:.4g}, and its holes are {:.4g} mm wide "
                       "([[vision.tool]] {}): they overlap",
                       coupon.pitch.in_mm(),
                       *size_mm,
                       coupon.vision_tool),
           fmt::format("more than {:.4g} mm from hole to hole", *size_mm)});
}

void check_min_holes(const MachineConfig& config, const StatedKeys& keys, DiagnosticLog& log) {
  const Coupon& coupon = *config.coupon;
  const int n_holes = coupon.columns * coupon.rows_per_run;
  const int n_wanted = config.nightly->limits.min_used;
  if (!does_calibrate(*config.nightly, "spindle-camera") || n_wanted <= n_holes) return;
  log.add(
      {Code::ConfigValue,
       keys.place("nightly.gates.min_holes"),
       fmt::format("min_holes in [nightly.gates] is {}, and a night drills {} holes ([coupon] {} "
                   "columns, {} rows_per_run): every night is held",
                   n_wanted,
                   n_holes,
                   coupon.columns,
                   coupon.rows_per_run),
       fmt::format("at most {}", n_holes)});
}

void check_mark_is_apart(const MachineConfig& config, const StatedKeys& keys, DiagnosticLog& log) {
  if (!config.nightly->mark) return;
  const Eigen::Vector2d mark_mm = config.nightly->mark->in_mm();
  const MachineArea drilled = drilled_area(config);
  if (!do_meet({mark_mm, mark_mm}, drilled)) return;
  log.add({Code::ConfigValue,
           keys.place("nightly.mark_mm"),
           fmt::format("mark_mm in [nightly] is ({:.3f}, {:.3f}), within the rows of [coupon] that "
                       "are drilled, {}",
                       mark_mm.x(),
                       mark_mm.y(),
                       drilled.text()),
           "a mark beside the coupon"});
}

void check_surface_is_apart(const MachineConfig& config,
                            const StatedKeys& keys,
                            DiagnosticLog& log) {
  if (!does_calibrate(*config.nightly, "surface")) return;
  const std::vector<Eigen::Vector2d> probed_mm = probed_places_mm(config.nightly->surface);
  const MachineArea drilled = drilled_area(config);
  const auto is_drilled = [&](const Eigen::Vector2d& at_mm) {
    return do_meet({at_mm, at_mm}, drilled);
  };
  const auto found = std::ranges::find_if(probed_mm, is_drilled);
  if (found == probed_mm.end()) return;
  log.add({Code::ConfigValue,
           keys.place("nightly.surface.low_mm"),
           fmt::format("[nightly.surface] probes ({:.3f}, {:.3f}), among the rows of [coupon], {}",
                       found->x(),
                       found->y(),
                       drilled.text()),
           "places beside the coupon, whose board and holes are not the table's surface"});
}

}  // namespace

void check_coupon_rules(const MachineConfig& config, const StatedKeys& keys, DiagnosticLog& log) {
  if (!config.coupon) return;
  check_pitch(config, keys, log);
  if (!config.nightly) return;
  check_min_holes(config, keys, log);
  check_mark_is_apart(config, keys, log);
  check_surface_is_apart(config, keys, log);
}

}  // namespace panelcal
