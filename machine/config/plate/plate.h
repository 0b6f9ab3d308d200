// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/calibration_plate.h"
#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "machine/config/plate/tags.h"

namespace panelcal {

/// A calibration plate: a lattice of round dots, and how it lay while it was looked at.
struct CalibrationPlate {
  std::string name = "plate";
  int columns = 0;  ///< dots along the plate's x
  int rows = 0;     ///< along y
  Length pitch;
  Length dot_diameter;        ///< 0: not said
  bool is_dark = true;        ///< dots against the plate
  bool is_certified = false;  ///< dots lie where the drawing has them; otherwise about there
  // What the certificate states, for the record; the fit does not use it.
  std::string certificate;                     ///< its number; empty: not said
  std::optional<Length> expanded_uncertainty;  ///< of a dot's place along an axis, U = k u
  double coverage_factor = 2;                  ///< k
  /// By number: roughly, to a quarter of the pitch at every dot. With tags only their count
  /// matters.
  std::vector<PlatePose> poses;
  std::optional<PlateTags> tags;  ///< tell which dot is which, and how the plate lay
  std::filesystem::path file;

  std::size_t n_dots() const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  }
  /// Dot (0, 0) is the plate's zero; they are numbered along x first.
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(column);
  }
  std::vector<PlateDot> dots() const;
  /// Of every dot whether a tag is in its place.
  std::vector<bool> covered_dots() const;
};

/// The machine's place of a place on the plate.
Position<frame::Machine> place_in(const PlatePose& pose, const Position<frame::Plate>& on_plate);

inline constexpr std::size_t kMaxPlateBytes = std::size_t{1} << 20;

/// Reads a plate's file:
///
///   [plate]
///   name = "B 17"          columns = 9          rows = 9          pitch_mm = 25
///   dot_diameter_mm = 1    polarity = "dark"    certified = true
///   certificate = "123 of 2026"                 # optional, as the next two
///   expanded_uncertainty_um = 0.5               coverage_factor = 2
///   [[pose]]
///   origin_mm = [100, 80]  angle_deg = 0        # where dot (0, 0) lies, machine directions
///
/// and its tags (plate_tags.h).
///
/// Fails  file-unreadable; toml-syntax; config-key-unknown; config-value
/// See    tests/machine/config/plate/plate_test.cc
Expected<CalibrationPlate> read_plate(const std::filesystem::path& file);
Expected<CalibrationPlate> parse_plate(std::string_view text, const std::filesystem::path& file);

}  // namespace panelcal
