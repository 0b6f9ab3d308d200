// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

// Lines that GRBL writes: GRBL 1.1, grblHAL, FluidNC.
namespace panelcal::grbl {

/// `<Idle|MPos:0.000,0.000,0.000|FS:0,0|WCO:0.000,0.000,0.000|Pn:P>`, the answer to `?`. Lengths
/// are in the control's unit, which $13 states.
struct Report {
  std::string state;  ///< "Idle", "Hold:0"
  std::optional<Eigen::Vector3d> machine;
  std::optional<Eigen::Vector3d> work;
  std::optional<Eigen::Vector3d> offset;  ///< machine - work; not in each report
  bool is_probe_tripped = false;
  bool is_probe_known = true;    ///< grblHAL says if none is connected
  std::optional<bool> is_homed;  ///< grblHAL

  bool is(std::string_view name) const { return state.substr(0, state.find(':')) == name; }
};

/// Empty: the line is no report.
std::optional<Report> parse_report(std::string_view line);

/// `[PRB:1.000,2.000,-3.125:1]`, in machine coordinates and the control's unit.
struct Touch {
  Eigen::Vector3d machine;
  bool is_touched = false;
};
std::optional<Touch> parse_touch(std::string_view line);

enum class Firmware : std::uint8_t { Grbl, GrblHal, FluidNc };

/// The statements of the control before anything moves.
struct Facts {
  Firmware firmware = Firmware::Grbl;
  std::string name;                ///< "GRBL 1.1h", "grblHAL 1.1f", "FluidNC v3.7.8"
  bool has_forced_origin = false;  ///< homing sets the place to zero ($I, option Z)
  std::map<int, double> settings;  ///< $$
  std::vector<std::string> modes;  ///< $G
  /// Offsets that are not zero, for people: "G54", "G92", "tool length".
  std::vector<std::string> offsets;

  std::optional<double> setting(int number) const;
  bool is_on(int number) const { return setting(number).value_or(0) != 0; }
  bool has_mode(std::string_view mode) const;
};

/// Take an answer's lines; what they do not know they leave out.
void take_identity(const std::vector<std::string>& lines, Facts& facts);
void take_settings(const std::vector<std::string>& lines, Facts& facts);
void take_offsets(const std::vector<std::string>& lines, Facts& facts);
/// Fails by returning false: there is no `[GC:...]`.
bool take_modes(const std::vector<std::string>& lines, Facts& facts);

}  // namespace panelcal::grbl
