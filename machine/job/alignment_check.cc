// SPDX-License-Identifier: Apache-2.0
#include "machine/job/alignment_check.h"

#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "program/geometry/bounding_box.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using NominalBox = BoundingBox<frame::Nominal>;

/// All places at which a tool works.
class WorkedExtent final : public OperationSink {
 public:
  void put(const Operation& operation) override {
    std::visit([this](const auto& what) { see(what); }, operation.what);
  }
  const NominalBox& box() const { return box_; }

 private:
  template <class What>
  void see(const What& what) {
    if constexpr (std::is_same_v<What, Drill> || std::is_same_v<What, Rout>) {
      box_.add(what.nominal);
    } else if constexpr (requires { what.start.nominal, what.end.nominal; }) {
      box_.add(what.start.nominal);
      box_.add(what.end.nominal);
    }
  }

  NominalBox box_;
};

bool overlap(const NominalBox& a, const NominalBox& b) {
  const auto reaches = [](const NominalBox& low, const NominalBox& high) {
    return (low.low().in_mm().array() <= high.high().in_mm().array()).all();
  };
  return reaches(a, b) && reaches(b, a);
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
  WorkedExtent worked;
  DiagnosticLog said_later;
  execute(program, options, checked, worked, said_later);
  NominalBox pads;
  for (const Measurement& pad : options.aligned->measurements) pads.add(pad.request.nominal);
  if (worked.box().is_empty() || overlap(worked.box(), pads)) return {};
  return failure(
      misfit_of_program(program,
                        0,
                        fmt::format("the program works from {}, and the pads of --align lie from "
                                    "{}",
                                    extent_text(worked.box()),
                                    extent_text(pads)),
                        "files with one origin: export them again with the same one"));
}

}  // namespace panelcal
