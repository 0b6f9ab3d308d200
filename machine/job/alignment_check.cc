// SPDX-License-Identifier: Apache-2.0
#include "machine/job/alignment_check.h"

#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "program/geometry/bounding_box.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using NominalBox = BoundingBox<frame::Nominal>;

/// Zeros that are nearer to each other than this are one: far above rounding.
constexpr double kSameZero_mm = 1e-6;

/// All places at which a tool works.
class WorkedExtent final : public OperationSink {
 public:
  /// The first operation that counts from another zero than the pads.
  struct Astray {
    int line = 0;
    Position<frame::Machine> zero;
  };

  explicit WorkedExtent(const Position<frame::Machine>& zero) : zero_(zero) {}

  void put(const Operation& operation) override {
    std::visit([&](const auto& what) { see(operation.line, what); }, operation.what);
  }
  const NominalBox& box() const { return box_; }
  const std::optional<Astray>& astray() const { return astray_; }

 private:
  template <class What>
  void see(int line, const What& what) {
    if constexpr (std::is_same_v<What, Drill> || std::is_same_v<What, Rout>) {
      add(line, what);
    } else if constexpr (requires { what.start.nominal, what.end.nominal; }) {
      add(line, what.start);
      add(line, what.end);
    }
  }

  void add(int line, const PlacedPoint& point) {
    box_.add(point.nominal);
    const Position<frame::Machine> zero = point.actual - point.commanded;
    if (!astray_ && (zero - zero_).in_mm().norm() > kSameZero_mm) astray_ = {line, zero};
  }

  Position<frame::Machine> zero_;
  NominalBox box_;
  std::optional<Astray> astray_;
};

bool overlap(const NominalBox& a, const NominalBox& b) {
  const auto reaches = [](const NominalBox& low, const NominalBox& high) {
    return (low.low().in_mm().array() <= high.high().in_mm().array()).all();
  };
  return reaches(a, b) && reaches(b, a);
}

/// Each reaches beyond the other, at opposite sides, by more than half of the pads' extent: what
/// two origins make of one board. Holes around the pads, or pads around the holes, reach beyond on
/// their own.
bool is_shifted(const NominalBox& worked, const NominalBox& pads) {
  constexpr double kShift = 0.5;
  // Pads nearly in a line say nothing across it.
  constexpr double kLeast = 0.05;
  const Eigen::Array2d extent_mm = (pads.high() - pads.low()).in_mm().array();
  const Eigen::Array2d limit_mm = (kShift * extent_mm).max(kLeast * extent_mm.maxCoeff());
  const Eigen::Array2d below_mm = (pads.low() - worked.low()).in_mm().array();
  const Eigen::Array2d above_mm = (worked.high() - pads.high()).in_mm().array();
  return ((below_mm > limit_mm && -above_mm > limit_mm) ||
          (above_mm > limit_mm && -below_mm > limit_mm))
      .any();
}

std::string zero_text(const Eigen::Vector2d& at_mm) {
  return fmt::format("({:.3f}, {:.3f}) mm", at_mm.x(), at_mm.y());
}

std::string extent_text(const NominalBox& box) {
  return fmt::format("({:.3f}, {:.3f}) to ({:.3f}, {:.3f}) mm",
                     box.low().in_mm().x(),
                     box.low().in_mm().y(),
                     box.high().in_mm().x(),
                     box.high().in_mm().y());
}

Diagnostic misfit_of_program(const Program& program,
                             int line,
                             std::string what,
                             std::string expected) {
  return {Code::Usage, {program.source.file, line, 0}, std::move(what), std::move(expected)};
}

Diagnostic measures_itself(const Program& program, int line, const std::string& command) {
  return misfit_of_program(
      program,
      line,
      command + " asks the camera, and --align has measured the panel already",
      "`panelcal run` without --align, or a program without commands for the camera");
}

}  // namespace

Expected<void> check_fits_alignment(const Program& program,
                                    const WalkOptions& options,
                                    const Survey& checked) {
  const std::size_t n_aligned = options.aligned->measurements.size();
  if (checked.measurements.size() > n_aligned) {
    const MeasurementRequest& request = checked.measurements[n_aligned].request;
    return failure(measures_itself(program, request.line, request.command));
  }
  if (!checked.calibrations.empty()) {
    const CalibrationOrder& order = checked.calibrations.front().order;
    return failure(measures_itself(program, order.line, order.command));
  }
  const Position<frame::Machine> zero = configured_zero(options);
  WorkedExtent worked(zero);
  DiagnosticLog said_later;
  execute(program, options, checked, worked, said_later);
  if (const auto& astray = worked.astray()) {
    return failure(misfit_of_program(
        program,
        astray->line,
        fmt::format("the program counts from another work zero than the pads of --align: from {}, "
                    "they from {}",
                    zero_text(astray->zero.in_mm()),
                    zero_text(zero.in_mm())),
        "a program without Z, ZC"));
  }
  return check_one_origin(program.source.file, worked.box(), *options.aligned);
}

Expected<void> check_one_origin(const std::string& file,
                                const NominalBox& worked,
                                const Survey& aligned) {
  NominalBox pads;
  for (const Measurement& pad : aligned.measurements) pads.add(pad.request.nominal);
  if (worked.is_empty() || (overlap(worked, pads) && !is_shifted(worked, pads))) return {};
  return failure({Code::Usage,
                  {file, 0, 0},
                  fmt::format("the program works from {}, and the pads of --align lie from {}",
                              extent_text(worked),
                              extent_text(pads)),
                  "files with one origin: export them again with the same one"});
}

}  // namespace panelcal
