// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "program/model/pattern_file.h"
#include "program/model/placement.h"
#include "surface/control/reference_plane.h"

namespace panelcal {

/// One place where the program wants the surface probed.
struct ProbeRequest {
  std::int64_t seq = 0;  ///< from 0, in the order of execution; `probe` in files
  int line = 0;
  std::string file;         ///< of a subprogram or pattern; empty: the program itself
  std::string file_sha256;  ///< of that file's bytes; empty: not known
  std::string command;      ///< G73, G78 or G79
  Position<frame::Nominal> nominal;
  Position<frame::Actual> expected;  ///< place to probe, relative to work zero
  Position<frame::Machine> work_zero;
  InstancePath path;
  int tool = 0;
  std::optional<int> memory;    ///< L; absent: into the averaging area, or into the grid
  std::optional<Length> depth;  ///< K of G83, a depth stroke; absent: a through-hole stroke
  Length reference;             ///< the height above Z0 where the surface is expected

  PatternFile pattern() const& { return {file, file_sha256}; }
  PatternFile pattern() const&& = delete;  // it views this
  Position<frame::Machine> expected_in_machine() const {
    return work_zero + displacement_mm<frame::Machine>(expected.in_mm());
  }
};

/// "G73 probe 7 (line 12)", as messages name a request.
std::string describe(const ProbeRequest& request);

enum class ProbeStatus : std::uint8_t { Found, NotFound };

std::string_view name(ProbeStatus status);
std::optional<ProbeStatus> probe_status_from_name(std::string_view name);

/// The answer to a request. Without status Found there are no heights.
struct ProbeReading {
  ProbeRequest request;
  ProbeStatus status = ProbeStatus::NotFound;
  std::vector<HeightEstimate> heights;  ///< above Z0; one per Z axis, the first axis first
  std::string reason;                   ///< of a status other than Found
};

/// A source of true heights of the surface: machine, recorded file, simulation.
class ProbeSource {
 public:
  virtual ~ProbeSource() = default;
  /// Fails when the source itself fails (broken device, wrong file); a surface that is not touched
  /// is an answer.
  virtual Expected<ProbeReading> probe(const ProbeRequest& request) = 0;
  /// Ends a measuring walk that found no error.
  ///
  /// Fails  as probe; a reading that the program did not ask for
  virtual Expected<void> finish() { return {}; }
};

/// Answers that the surface is where it is expected, exactly: the walk over a perfect board.
class NominalProbeSource final : public ProbeSource {
 public:
  /// Precondition: n_axes >= 1.
  explicit NominalProbeSource(std::size_t n_axes = 1) : n_axes_(n_axes) {}
  Expected<ProbeReading> probe(const ProbeRequest& request) override;

 private:
  std::size_t n_axes_;
};

/// One JSON object, without a line end, in the format of docs/formats/probes.md. Numbers round-trip
/// exactly. The key `probe`, which measurement requests lack, tells the two apart.
std::string to_json(const ProbeRequest& request);

/// JSON Lines: a line for each Z axis, numbered from 0 as `zaxis`, all with the request's number; a
/// single line without `zaxis`, `height` and `sigma` if the surface was not found. Line ends stand
/// between the lines, not behind the last. Numbers round-trip exactly, so that a recorded run
/// replays bit for bit.
std::string to_json(const ProbeReading& reading);

}  // namespace panelcal
