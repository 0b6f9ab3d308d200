// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "program/excellon/text/lexer.h"
#include "program/text/mark.h"
#include "program/text/number_format.h"
#include <Eigen/Core>

namespace panelcal::excellon {

/// Numbers as they are written: what they mean in a format can be asked for without reading them
/// again.
class WrittenNumbers {
 public:
  /// Least and greatest value, in mm.
  struct Extent {
    double least_mm = 0;
    double most_mm = 0;

    double size_mm() const { return most_mm - least_mm; }
    double farthest_mm() const;  ///< from 0
  };

  void add(std::string_view number);
  bool is_empty() const { return n_ == 0; }
  /// False if a number has more digits than the format.
  bool fit(const NumberFormat& format) const;
  /// Precondition: !is_empty()
  Extent in(const NumberFormat& format) const;
  /// True if the two formats give every number the same value.
  bool mean_the_same_in(const NumberFormat& a, const NumberFormat& b) const;
  /// Numbers with fewer digits than the format that keep zeros on either side: none would on the
  /// side where zeros may be left off. A lone 0 does not count.
  struct KeptZeros {
    int n_leading = 0;
    int n_trailing = 0;
  };
  KeptZeros short_with_zeros(const NumberFormat& format) const;
  /// A bit for each count of digits that occurs, zeros left aside.
  unsigned lengths() const;

 private:
  void add_pointed(std::string_view number);

  static constexpr std::size_t kMostDigits = 15;
  struct OfLength {
    std::int64_t least = 0;
    std::int64_t most = 0;
    int n = 0;
    int n_leading_zero = 0;
    int n_trailing_zero = 0;
  };

  std::array<OfLength, kMostDigits + 1> bare_;  ///< without a decimal point, by their digits
  double least_pointed_ = 0;                    ///< with one, in units
  double most_pointed_ = 0;
  int n_pointed_ = 0;
  int n_ = 0;
  bool has_others_ = false;  ///< a text that no format reads
};

/// A word as it is written, and where.
struct NumberPlace {
  std::string text;
  int line = 0;
  int column = 0;

  // NOLINTNEXTLINE(google-explicit-constructor): words are their own mark
  operator Mark() const { return {line, column, quoted(text)}; }
};

/// The numbers of a program that lengths of a job are known of.
struct NumberCensus {
  WrittenNumbers x;
  WrittenNumbers y;
  WrittenNumbers diameters;  ///< C of tools; 0 does not count
  /// Other lengths and rates, of which nothing is known but that the unit measures them.
  bool has_other_lengths = false;
  bool has_other_bare_lengths = false;  ///< their zeros decide what they are as well
  /// Coordinates are steps, here or there: they do not show how far the job extends.
  bool is_incremental = false;
  bool has_faults = false;  ///< a line is no block, whatever the format
  /// The first coordinate, else the first diameter; empty: there is no number.
  NumberPlace first;
};

/// Rules by which lines are executed, as far as a census asks.
struct LineRules {
  ProgramSet set = ProgramSet::FormatTwo;
  bool deletes_blocks = false;  ///< those that begin with /
};

/// The first length without a decimal point, which zeros and digits of the format decide; absent:
/// there is none.
///
/// Cost   O(n); lines of X and Y alone that all have points, or a lone 0, are counted 16 characters
///        at a time
std::optional<NumberPlace> find_bare_number(std::string_view program, const LineRules& rules);

/// Looks at every block that is executed of a program whose format is not known, up to its end.
/// Messages, texts and comments are passed over.
///
/// In     census: the program's numbers are added, so that stored patterns can be taken in as well
/// Cost   O(n), n being the text
/// See    tests/program/excellon/text/format_choice_test.cc
void take_census(std::string_view program, const LineRules& rules, NumberCensus& census);

/// Single holes that a program lists, by tool.
struct ListedHoles {
  struct OfTool {
    int tool = 0;
    std::optional<double> diameter_mm;  ///< C of the header or of the body
    std::vector<Eigen::Vector2d> at_mm;
  };

  std::vector<OfTool> tools;  ///< in the order in which they are taken
  std::size_t n_holes = 0;
  NumberPlace first_bare;   ///< the first coordinate without a decimal point; empty: there is none
  bool is_readable = true;  ///< false: the format cannot read a number, or coordinates are steps
};

/// Lists the holes of blocks of X and Y alone as they are in a format, up to a number of them.
/// Those that a cycle, a text, a stored pattern, R# or a copy makes are not listed, nor what
/// follows a cycle with lines of its own, M97 to M99 or G93 until the next tool.
///
/// Cost   O(n), n being max_holes and the lines between them
/// See    tests/program/excellon/text/digit_evidence_test.cc
ListedHoles list_holes(std::string_view program,
                       const LineRules& rules,
                       const NumberFormat& format,
                       std::size_t max_holes);

}  // namespace panelcal::excellon
