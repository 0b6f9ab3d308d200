// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/estimate.h"
#include "calib/base/expected.h"
#include "calib/base/machine_uncertainty.h"
#include "calib/base/units.h"
#include "calib/panel/fit.h"
#include "program/model/calibration_order.h"
#include "program/model/pattern_file.h"
#include "program/model/placement.h"

namespace panelcal {

/// Settings of the camera: those of G34 and the `$uvis` commands when the target came.
struct VisionSettings {
  std::vector<int> tools;             ///< G34: one vision tool, or four for a large target
  std::optional<Length> delta;        ///< G34: distance of the four views from the centre
  int inspections = 1;                ///< $uvis,insp
  std::optional<bool> search;         ///< $uvis,search
  std::optional<Length> search_area;  ///< $uvis,searcharea: radius, in the program's unit
  std::optional<double> lamp;         ///< $uvis,lamp, as written
  std::optional<double> zoom;         ///< $uvis,zoom, as written
  std::optional<int> algorithm;       ///< $uvis,alg
  /// A person's, for one look; absent: the camera's own.
  std::optional<double> exposure_us = {};
};

/// One target that the program wants measured.
struct MeasurementRequest {
  std::int64_t seq = 0;  ///< from 0, in the order of execution
  int line = 0;
  std::string file;         ///< of a stored pattern (M99); empty: the program itself
  std::string file_sha256;  ///< of that file's bytes; empty: not known
  std::string command;      ///< G35, G36, G38, G45, G46 or G48
  VisionSettings settings;
  Position<frame::Nominal> nominal;
  Position<frame::Actual> expected;  ///< place to look at, relative to work zero
  Position<frame::Machine> work_zero;
  InstancePath path;
  bool is_of_left_out_board = false;  ///< its answer places nothing
  /// The coordinates that count: both, but of slots (SIEB & MEYER, measurement mode 5).
  ObservedAxes axes = ObservedAxes::Both;

  PatternFile pattern() const& { return {file, file_sha256}; }
  PatternFile pattern() const&& = delete;  // it views this
  /// Place of the optical axis to see the expected place in the middle.
  Position<frame::Machine> expected_in_machine() const {
    return work_zero + displacement_mm<frame::Machine>(expected.in_mm());
  }
};

/// Skipped: a person has left the target out of its series. BoardLeftOut: a person has left out the
/// whole board that it is of.
enum class MeasurementStatus : std::uint8_t {
  Found,
  NotFound,
  Ambiguous,
  Rejected,
  Skipped,
  BoardLeftOut,
};

std::string_view name(MeasurementStatus status);
std::optional<MeasurementStatus> measurement_status_from_name(std::string_view name);

/// The kinds of decisions of a person at the machine about a target.
enum class Decider : std::uint8_t {
  Source,         ///< nothing: the answer is the source's own
  Camera,         ///< to look again, perhaps elsewhere: the place is what the camera then saw
  Candidate,      ///< it is that one of the picture's candidates
  Hand,           ///< it is at that place of the picture
  Skip,           ///< to leave it out
  LeaveBoardOut,  ///< to leave out the board that it is of
};

/// "camera", "candidate", "hand", "skip", "leave_board_out"; empty for the source's own.
std::string_view name(Decider decider);
std::optional<Decider> decider_from_name(std::string_view name);

struct Decision {
  Decider by = Decider::Source;
  std::string who;   ///< a person's name, as that person has written it
  std::string when;  ///< ISO 8601, UTC

  bool is_by_person() const { return by != Decider::Source; }
};

/// A place in a target's picture that looks like it, or stands where it may be.
struct MeasuredCandidate {
  PositionEstimate<frame::Actual> place;  ///< relative to work zero
  double score = 0;                       ///< as Measurement::score
  bool counts = false;                    ///< false: it cannot be the target
  CameraJacobian by_camera = CameraJacobian::Zero();
};

/// The area in which a picture's candidates are all listed.
struct ListedArea {
  std::array<Position<frame::Actual>, 4> corners;  ///< of a convex quadrilateral, in order
  std::optional<Length> radius;  ///< [vision] search_radius_mm, about the expected place
};

/// The answer to a request. Without status Found there is no measured position.
struct Measurement {
  MeasurementRequest request;
  MeasurementStatus status = MeasurementStatus::NotFound;
  PositionEstimate<frame::Actual> measured;  ///< relative to work zero
  std::optional<double> score;
  /// Derivative of the place by the camera's calibration, whose error all targets share.
  std::optional<CameraJacobian> by_camera;
  /// One standard deviation of repeated inspections in each axis, if there were any.
  std::optional<Displacement<frame::Actual>> scatter;
  std::string image;   ///< file name of the picture, empty if there is none
  std::string reason;  ///< of a status other than Found
  /// All places of the picture, for the series to choose among; the measured one is one of them.
  /// Empty: unknown.
  std::vector<MeasuredCandidate> candidates;
  std::optional<ListedArea> listed;  ///< absent: unknown, or more places than were fitted
  Decision decision;

  /// Candidates to choose among: a lone one is chosen by its picture.
  bool has_choice() const;
};

/// A person has decided to do without it.
inline bool is_left_out(const Measurement& measurement) {
  return measurement.status == MeasurementStatus::Skipped ||
         measurement.status == MeasurementStatus::BoardLeftOut;
}

/// The answer to an autofocus request.
struct FocusResult {
  struct Sample {
    Length z;
    double sharpness = 0;
  };

  MeasurementRequest request;  ///< seq is -1: focusing measures no target
  bool is_found = false;
  Length z;      ///< if found: where the camera is sharpest
  Length sigma;  ///< one standard deviation of z
  std::string reason;
  std::vector<Sample> curve;  ///< in the order in which it was taken
};

/// The requests that will come from now on, in their order, if every target that is still to be
/// measured lies where it is expected. Empty where that is not worth knowing. The places of a
/// series that is open are exact, and those of later ones as long as nothing that they depend on is
/// unmeasured.
using RequestForecast = std::function<std::vector<MeasurementRequest>()>;

/// A hole that the spindle drills while a program is measured.
struct DrilledHole {
  Position<frame::Nominal> nominal;
  Position<frame::Actual> place;  ///< by the corrections in force, relative to work zero
  Position<frame::Machine> work_zero;
};

/// A panel that the spindle drills into: the virtual machine's.
class DrilledPanel {
 public:
  virtual ~DrilledPanel() = default;
  virtual void drill(const DrilledHole& hole) = 0;
};

/// A series that its targets do not agree about, and the target that disagrees most.
struct Contradiction {
  const Measurement& worst;
  std::string reason;
};

/// A source of true places of targets: camera, picture folder, recorded file, simulation.
class MeasurementSource {
 public:
  virtual ~MeasurementSource() = default;
  /// Lets the source prepare what it will be asked for. No answer may depend on it.
  virtual void foresee(RequestForecast /*forecast*/) {}
  /// Fails when the source itself fails (missing picture, broken device); a target that is not to
  /// be seen is an answer.
  virtual Expected<Measurement> measure(const MeasurementRequest& request) = 0;
  /// It has a word on series that gates refuse because of a target.
  virtual bool reconsiders() const { return false; }
  /// Another answer for the worst target of such a series, which is then fitted again. Empty: it
  /// stays as it is.
  ///
  /// Fails  as measure
  virtual Expected<std::optional<Measurement>> reconsider(const Contradiction& contradiction);
  /// Focuses on what is to be seen at the request's expected place, and keeps that focus for later
  /// measurements. Empty where there is nothing to focus.
  ///
  /// Fails  as measure
  virtual Expected<std::optional<FocusResult>> focus(const MeasurementRequest& request);
  /// Calibrates the spindle-camera offset, and measures with it from then on. Empty where the
  /// source cannot: then the stored calibration stays in force.
  ///
  /// Fails  as measure; a calibration that is refused
  virtual Expected<std::optional<CalibrationAnswer>> calibrate(const CalibrationOrder& order);
  /// The panel that has to know the holes which the control drills between its measurements; null:
  /// none. Of a language whose control measures everything before it drills (Excellon) it is told
  /// none.
  virtual DrilledPanel* drilled_panel() { return nullptr; }
  /// Ends a measuring walk that found no error.
  ///
  /// Fails  as measure; an answer that the program did not ask for
  virtual Expected<void> finish() { return {}; }
};

/// Answers that every target is where it is expected, and that every calibration finds what was
/// known: the walk over a perfect panel.
class NominalSource final : public MeasurementSource {
 public:
  Expected<Measurement> measure(const MeasurementRequest& request) override;
  Expected<std::optional<CalibrationAnswer>> calibrate(const CalibrationOrder& order) override;
};

/// One JSON object, without a line end, in the format of docs/formats/measurements.md. Numbers
/// round-trip exactly, so that a recorded run replays bit for bit.
std::string to_json(const MeasurementRequest& request);
std::string to_json(const Measurement& measurement);

}  // namespace panelcal
