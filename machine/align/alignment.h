// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/expected.h"
#include "program/model/measurement.h"
#include <Eigen/Core>

namespace panelcal {

/// A file that an alignment depends on, known by its content.
struct AlignmentInput {
  std::string what;    ///< "machine file", "camera calibration", "zoom 3"
  std::string name;    ///< without folders
  std::string sha256;  ///< 64 digits

  friend bool operator==(const AlignmentInput&, const AlignmentInput&) = default;
};

/// The numbers of the pads' fit, for people and other programs: panelcal itself fits anew, from the
/// measurements, and holds that against this.
struct AlignmentFit {
  std::string model;
  Eigen::Matrix2d linear = Eigen::Matrix2d::Identity();  ///< of a smooth fit the map nearest to it
  Eigen::Vector2d translation_mm = Eigen::Vector2d::Zero();
  Eigen::Matrix<double, 6, 6> cov = Eigen::Matrix<double, 6, 6>::Zero();  ///< l00 l01 l10 l11 tx ty
  double chi_square = 0;
  int degrees_of_freedom = 0;
};

/// One limit against one number, as GateVerdict.
struct AlignmentGate {
  std::string gate;
  double value = 0;
  double limit = 0;
  std::string unit;
  bool is_accepted = true;
};

/// Pads that were looked at again.
struct AlignmentCheck {
  std::chrono::sys_seconds time{};  ///< UTC
  std::string by;
  std::vector<int> pads;  ///< their numbers, from 1
  /// Of the pads in their order; fewer than these, in a failed check: the next one was not found.
  std::vector<Position<frame::Actual>> seen;
  double chi_square = 0;  ///< of their moves since the alignment
  double limit = 0;
  bool is_accepted = false;

  bool has_seen_all() const { return seen.size() == pads.size(); }
};

/// A panel that was measured once, for all of its programs: board.align.json.
struct Alignment {
  std::string file;  ///< as diagnostics name it; not in the file itself
  std::string made_by;
  std::string machine;  ///< [machine] name
  std::string panel;    ///< the panel's name, in the words of who measured it; may be empty
  std::chrono::sys_seconds time{};  ///< UTC, of the measurement
  std::string by;
  std::string source;  ///< of the measurements, in words
  std::string pads;    ///< origin of the pads, in words
  std::vector<AlignmentInput> inputs;
  std::vector<std::string> names;         ///< of the pads; empty ones have none
  std::vector<Measurement> measurements;  ///< of the pads, in their order
  std::optional<AlignmentFit> fit;        ///< absent: a pad was not found
  std::vector<AlignmentGate> gates;
  std::string held;  ///< the reason why nothing may be drilled by it; empty: it may
  std::vector<AlignmentCheck> checks;

  /// Time at which the panel was last seen to lie there.
  std::chrono::sys_seconds last_seen() const;
};

/// Reads an alignment, strictly: unknown and missing keys, wrong types, numbers of pads that
/// differ, covariances that are not positive definite and times that run backwards are refused.
///
/// Fails  file-unreadable; json-syntax; calibration-invalid; measurement-file; measurement-invalid
/// See    docs/formats/json_files.md; tests/machine/align/alignment_test.cc
Expected<Alignment> read_alignment(const std::filesystem::path& path);
/// The same from text. Any bytes give a value or a diagnostic.
Expected<Alignment> parse_alignment(std::string_view text, const std::string& file);
/// Numbers in the fewest digits that read back exactly.
std::string alignment_text(const Alignment& alignment);

}  // namespace panelcal
