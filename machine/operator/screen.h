// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/diagnostic.h"
#include "program/model/placement.h"
#include <Eigen/Core>

// The document "screen" as plain data: share/schema/screen.schema.json has the meaning of each key.
namespace panelcal::internal {

/// A program that may be opened.
struct ScreenProgram {
  std::string name;
  std::uintmax_t size_bytes = 0;

  bool operator==(const ScreenProgram&) const = default;
};

/// One target of the job; places in work coordinates.
struct ScreenTarget {
  std::int64_t seq = 0;
  int line = 0;
  std::string command;
  int tool = 0;
  InstancePath path;
  Eigen::Vector2d nominal_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d expected_mm = Eigen::Vector2d::Zero();
  std::string status = "waiting";
  std::optional<Eigen::Vector2d> measured_mm;
  std::optional<Eigen::Vector2d> sigma_um;
  std::optional<Eigen::Vector2d> residual_um;  ///< measured minus fitted
  std::string reason;
  std::string by;  ///< as name(Decider), or "camera" of the source's own; empty: not decided
  std::string who;
  std::string when;
  bool has_picture = false;
};

struct ScreenSeries {
  int line = 0;
  InstancePath path;
  std::size_t n_targets = 0;
  bool is_fitted = false;
  bool is_accepted = false;
  std::string words;
};

struct ScreenCandidate {
  Eigen::Vector2d at_px = Eigen::Vector2d::Zero();
  double size_px = 0;
  double score = 0;
};

/// A question to a person about one target, or something that the person has to do.
struct ScreenQuestion {
  int id = 0;
  std::optional<std::int64_t> seq;  ///< absent: of no target
  std::string reason;
  std::vector<ScreenCandidate> candidates;
  std::vector<std::string> choices;
  std::map<std::string, std::string> why_not;  ///< of the other choices
  std::optional<double> exposure_us;           ///< in force; absent: it is not known
  double jog_limit_mm = 0;                     ///< of all jogs together
  // Not in the document, as are further terms of a jog:
  Eigen::Vector2d jogged_mm = Eigen::Vector2d::Zero();
  std::string why_no_jog;         ///< empty: it may
  std::uint64_t first_frame = 0;  ///< that shows the place since the last jog
  bool is_jogging = false;        ///< a jog was ordered, and its picture is still to come
};

struct ScreenVerdict {
  bool may_drill = false;
  std::string words;
};

/// Two measured targets that are looked at again.
struct ScreenAgain {
  std::vector<std::int64_t> seqs;
  std::string words;
};

enum class JobState : std::uint8_t {
  Checked,
  Measuring,
  Asking,
  Done,
  Held,
  Failed,
  Stopped,
  Resumable,
};
std::string_view name(JobState state);
std::optional<JobState> job_state_from_name(std::string_view name);
/// The machine thread works on it.
inline bool is_running(JobState state) {
  return state == JobState::Measuring || state == JobState::Asking;
}

struct ScreenJob {
  std::string id;
  std::string program;
  JobState state = JobState::Checked;
  std::vector<Diagnostic> findings;
  std::vector<ScreenTarget> targets;  ///< by seq
  std::vector<ScreenSeries> series;
  std::optional<ScreenQuestion> question;
  std::optional<ScreenAgain> again;
  std::optional<ScreenVerdict> verdict;
  bool has_report = false;
  bool has_facts = false;
  std::vector<std::string> outputs;
  std::optional<std::int64_t> n_holes;
  std::string output_format;  ///< "excellon", "sieb-meyer"; empty: the program cannot be read
  // Not in the document:
  std::string program_sha256;  ///< of what was checked
};

struct ScreenEllipse {
  Eigen::Vector2d at_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d axes_px = Eigen::Vector2d::Zero();  ///< one standard deviation along its axes
  double angle_rad = 0;  ///< of the first axis, from x towards y, which points down
};

/// The contents of the camera's last picture; px of that picture.
struct ScreenView {
  int width_px = 0;
  int height_px = 0;
  double um_per_px = 0;
  Eigen::Vector2d place_mm = Eigen::Vector2d::Zero();  ///< optical axis, in work coordinates
  std::optional<Eigen::Vector2d> search_px;
  std::optional<double> search_radius_px;
  std::vector<Eigen::Vector2d> outline_px;
  std::optional<ScreenEllipse> ellipse;
  std::optional<double> lamp;      ///< as `$uvis,lamp` writes it
  std::optional<double> contrast;  ///< of full scale
  std::optional<double> sharpness;
};

struct ScreenCalibration {
  std::string kind;
  std::string state;  ///< "running", "done", "failed"
  std::vector<std::string> lines;
  std::string verdict;
  bool has_page = false;
};

struct ScreenHistory {
  std::string kind;
  std::string entry;  ///< as the ledger numbers it
  std::string when;
  bool in_force = false;
  std::string words;
};

struct Screen {
  std::string machine;
  std::string source;
  std::vector<ScreenProgram> programs;
  std::optional<ScreenJob> job;
  std::uint64_t frame = 0;  ///< of `view`
  std::optional<ScreenView> view;
  std::optional<ScreenCalibration> calibration;
  std::vector<std::string> kinds;  ///< of calibrations that can be made
  std::vector<ScreenHistory> history;
};

/// The document; the same bytes for the same screen.
std::string to_json(const Screen& screen);

}  // namespace panelcal::internal
