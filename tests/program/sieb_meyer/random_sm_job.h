// SPDX-License-Identifier: Apache-2.0
// Random SIEB & MEYER programs, each with its meaning.
#pragma once

#include <array>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <rapidcheck.h>

namespace panelcal::test {

/// A place or a difference in 0.001 mm, exactly as a program says it.
struct Microns {
  long x = 0;
  long y = 0;
  friend bool operator==(const Microns&, const Microns&) = default;
  friend Microns operator+(Microns a, Microns b) { return {a.x + b.x, a.y + b.y}; }
  friend Microns operator-(Microns a, Microns b) { return {a.x - b.x, a.y - b.y}; }
};

// --- what a program is spelled of ----------------------------------------------------------------

/// A code, or a letter with a length behind it.
struct SmWord {
  std::string text;
  std::optional<long> um{};
  long step_um = 1;  ///< length of one step without a decimal point
};

struct SmLine {
  std::vector<SmWord> words;  ///< in any order
  std::string tail;           ///< a last word, which has to stay last: G32, M47,text
  bool is_slashed = false;
  int style = 0;  ///< way to write the same line
};

// --- what it means -------------------------------------------------------------------------------

/// A contour's line or arc; the start is where the tool came to.
struct SmPiece {
  int turn = 0;  ///< 1 counterclockwise (G3), -1 clockwise (G2), 0 straight (G1)
  Microns to;
  long radius_um = 0;             ///< R; below zero goes the long way round
  std::optional<Microns> spoke;   ///< I and J: start less centre
  std::optional<long> corner_um;  ///< D: the end is rounded towards the next piece
  int side = 0;  ///< 1 the cutter goes left (G41), -1 right (G42), 0 on the contour
};

/// Effect of one line, or of two that belong together, in the order of the program. Places are
/// absolute ones of the section they stand in.
struct SmNode {
  enum class Kind : std::uint8_t {
    Tool,        ///< T
    Plane,       ///< Z, K, G82, G83: as far as they are set
    Hole,        ///< at `place`
    TargetHole,  ///< at `place`, where the camera sees it: G36
    Pattern,     ///< V1 to V4 from `place` to `second`
    Contour,     ///< from `place` along `pieces`
    Figure,      ///< G45 to G50 about `place`
    Correction,  ///< G31 or G30
    Section,     ///< `body`, executed at every copy; without copies where it stands
  };
  Kind kind = Kind::Hole;
  Microns place;
  int number = 0;  ///< of the tool, of V or of G
  std::optional<long> z_um;
  std::optional<long> k_um;
  std::optional<bool> depth_control;
  Microns second;               ///< of a pattern; side lengths of G49 and G50
  std::optional<int> n_in_row;  ///< W
  long radius_um = 0;           ///< of G45 to G48
  std::vector<SmPiece> pieces;
  bool is_on = false;  ///< G31
  std::vector<SmNode> body;
  /// M50 to M90 in the order of the program: the codes without their M, and the zero point.
  std::vector<std::pair<std::string, Microns>> copies;
};

struct SmJob {
  bool is_3000 = false;  ///< else 5000
  bool deletes_blocks = false;
  bool has_targets = false;
  std::vector<SmLine> lines;
  std::vector<SmNode> nodes;
};

/// Diameters of the tools T1 to T4, 0.001 mm.
inline constexpr std::array<long, 4> kSmTools_um = {1000, 2000, 800, 3000};

/// The length that a job's steps have, which are 0.001 mm where nothing else is asked for.
enum class SmUnit : std::uint8_t {
  Microns,
  InchSteps,          ///< 0.0001 inch, in a program in inch (format 5000)
  InchStepsInMetric,  ///< 0.0001 inch, in a program in millimetres: as 0.00254
};

struct SmSpelling {
  std::string line_end = "\n";
  /// Choice of the equal ways to write numbers, codes and the order of words; 0: the plainest.
  unsigned style = 0;
  SmUnit unit = SmUnit::Microns;
};

std::string text_of(const SmJob& job, const SmSpelling& spelling);
SmSpelling any_sm_spelling();
std::ostream& operator<<(std::ostream& out, const SmJob& job);

/// Targets that are drawn: targets and corrections come in format 5000 only.
enum class SmTargets : std::uint8_t { None, OfTheBoard };

/// A random valid job: holes, patterns, contours, figures, tools and planes, alone and in nested
/// sections with offsets, absolute and incremental. No text, no subprogram, no surface.
rc::Gen<SmJob> random_sm_job(SmTargets targets);

}  // namespace panelcal::test
