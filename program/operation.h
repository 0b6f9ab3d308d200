// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include <Eigen/Core>

#include "panelcal/calib/base/frames.h"
#include "panelcal/calib/base/units.h"
#include "panelcal/program/number_format.h"

namespace panelcal {

/// What a program knows of a drill or router bit; absent where it says nothing.
struct Tool {
  int number = 0;
  std::optional<Length> diameter;
  std::optional<Feed> infeed;
  std::optional<Feed> retract;
  std::optional<SpindleSpeed> speed;
  std::optional<int> max_hits;
  std::optional<Length> depth_offset;

  friend bool operator==(const Tool&, const Tool&) = default;
};

/// Takes a tool; number 0 puts the tool away.
struct ToolChange {
  Tool tool;
  std::optional<int> compensation_index;
};

/// Drills one hole.
struct Drill {
  int tool = 0;
  Position<frame::Nominal> nominal;   ///< after placement, before any correction
  Position<frame::Actual> corrected;  ///< relative to work zero
  Position<frame::Machine> actual;    ///< what the machine is told
  Eigen::Matrix2d cov_mm2;            ///< of the corrected place; zero without a correction
};

enum class StopKind { EndNoRewind, EndRewind };

/// Stops, at a place that the program gives relative to absolute zero if it gives one (CNC-7
/// manual, Stop Commands).
struct Stop {
  StopKind kind = StopKind::EndRewind;
  std::optional<Displacement<frame::Machine>> from_absolute_zero;
  std::optional<Position<frame::Machine>> actual;
};

/// Shows a text to the operator and waits.
struct Message {
  std::string_view text;
};

enum class SettingKind { Header, Body, Vision };

/// Something the machine has to know or do that moves nothing, passed on as written.
struct Setting {
  std::string_view text;
  SettingKind kind = SettingKind::Body;
};

/// Sets work zero (G93); later machine coordinates already contain it.
struct ZeroSet {
  Displacement<frame::Machine> zero_set;
  Position<frame::Machine> work_zero;
};

/// One thing the machine is told. Views are valid only during the call that passes it.
struct Operation {
  int line = 0;
  std::span<const int> path;
  std::variant<ToolChange, Drill, Stop, Message, Setting, ZeroSet> what;
};

/// tool, drill, stop, message, setting, zero_set: the `op` of output files.
std::string_view operation_name(const Operation& operation);

/// What a writer may need before the first operation.
struct ProgramInfo {
  std::string file;
  NumberFormat format;  ///< the program's own: rates are whole in its unit, settings in its zeros
  std::map<int, Tool> tools;
};

/// Takes operations one at a time; writers are sinks.
class OperationSink {
 public:
  virtual ~OperationSink() = default;
  virtual void begin(const ProgramInfo&) {}
  /// A sink that cannot go on remembers why and says so in finish().
  virtual void put(const Operation& operation) = 0;
};

}  // namespace panelcal
