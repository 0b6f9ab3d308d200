// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "calib/base/units.h"
#include "program/geometry/dot_font.h"
#include "surface/control/memory.h"

// Settings of the controls whose languages need some: the machine states them, before any program.
namespace panelcal::sieb_meyer {

/// The most holes that &P drills; more is taken for a slip.
inline constexpr int kMaxSpindle = 64;

/// The values of the text variables of M97 and M98. Small letters are drilled as capitals.
struct TextVariables {
  std::string date;           ///< &D, dd/mm/yyyy (the manual's second slash in dd//mm is a slip)
  std::string time;           ///< &T, hh:mm:ss
  std::string file;           ///< &F, without its extension
  std::string extension;      ///< &E, without the dot
  std::string module;         ///< &M
  int spindle = 1;            ///< &P and &S; counts from 1
  int breakage_counter = 0;   ///< &B
  int run = 1;                ///< &N and &V
  std::string operator_text;  ///< *, what the OPID setting says
};

/// The control's own settings when a program starts; M49 may change some of them.
struct Settings {
  CharacterSet characters = CharacterSet::Dots5x7;
  TextVariables text;         ///< values of the variables of M97 and M98
  int measurement_mode = 1;   ///< 1, 2, 3 or 5
  bool pattern_mode = false;  ///< CAMA: G36 aligns a pattern; else NOCAMA: a hole
  bool fits_scale = false;    ///< two points give one scale as well
  int vision_tool = 1;        ///< until a G35 names another
  /// PRGM,C: M56 to M58 are obeyed; absent: not stated.
  std::optional<bool> obeys_areas;

  AverageKind average = AverageKind::Mean;  ///< SPAV
  Length surface_height;                    ///< expected height of the board's surface above Z0
  std::optional<Length> surface_tolerance;  ///< BOTT, MAPT: the most that a probe may differ
  Length grid_hold = mm(10);  ///< distance outside the grid to which its edge's value holds
  /// [surface] fill_gaps: nodes of the grid that are not probed get the height that the others
  /// predict; else they are an error.
  bool fills_gaps = false;
};

}  // namespace panelcal::sieb_meyer
