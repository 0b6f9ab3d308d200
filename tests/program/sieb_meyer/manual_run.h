// SPDX-License-Identifier: Apache-2.0
// Helpers of the tests of the SIEB & MEYER manual's examples.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>

#include "tests/program/program_run.h"

namespace panelcal::test {

/// Tools 1, 4 and 6 to 9 of 1 mm and 2, 3 and 5 of 2 mm, as the end of a program.
inline constexpr std::string_view kToolTable =
    "$\nT1D1.\nT2D2.\nT3D2.\nT4D1.\nT5D2.\nT6D1.\nT7D1.\nT8D1.\nT9D1.\n$\n";

/// A program in format 5000 with that tool table; body lines count from 2.
std::string format_5000(std::string_view body);

/// A program with the tool table of a program without tools: two dollar signs, in format 1000 91.
std::string ended(std::string_view program);

/// Runs a program that nothing is wrong with; warnings are allowed.
ProgramRun run_5000(std::string_view body,
                    const WalkOptions& options = {},
                    ReadOptions reading = {});
ProgramRun run_5000(std::string_view body, const WalkOptions& options, MeasurementSource& source);

using Places = std::vector<Eigen::Vector2d>;

/// Nominal places of the holes, mm, in the order of drilling.
Places hole_places(const ProgramRun& run);
/// Nominal ends of routs, mm.
Places rout_ends(const ProgramRun& run);
Places shifted(Places places, const Eigen::Vector2d& offset_mm);
Places joined(Places first, const Places& second);

/// Every place is the expected one, in this order.
void expect_places(const Places& found, const Places& expected, double tolerance_mm = 1e-9);
/// The same places in any order, each as often.
void expect_same_places(Places found, Places expected, double tolerance_mm = 1e-9);

/// Everything that is executed, without line numbers. Compensation is shown where it changes while
/// the router is down or about to go down; it ends where the router comes up.
std::vector<std::string> steps_of(const ProgramRun& run);

/// A straight piece or an arc, its start included. Consecutive arcs that continue each other are
/// one, since operations split arcs beyond half a circle.
struct Piece {
  RoutKind kind = RoutKind::Line;
  Eigen::Vector2d start_mm;
  Eigen::Vector2d end_mm;
  Eigen::Vector2d center_mm;  ///< of an arc
  double sweep_rad = 0;       ///< of an arc, positive

  double radius_mm() const { return (end_mm - center_mm).norm(); }
  Eigen::Vector2d direction_at(const Eigen::Vector2d& p_mm) const;
};

/// Pieces of routs that begin at a place, as the machine is told.
std::vector<Piece> pieces_from(const Eigen::Vector2d& start_mm, const std::vector<Rout>& routs);

/// The program is refused: an error in this line of `p.exc` that names one of the words, in capital
/// or small letters.
void expect_refused(const ProgramRun& run, int line, std::initializer_list<std::string_view> words);

/// A folder of subprogram files that goes away with the test.
class SubprogramFolder {
 public:
  SubprogramFolder();
  ~SubprogramFolder();
  SubprogramFolder(const SubprogramFolder&) = delete;
  SubprogramFolder& operator=(const SubprogramFolder&) = delete;

  SubprogramFolder& with(const std::string& name, const std::string& text);
  ReadOptions reading() const;

 private:
  std::filesystem::path path_;
};

}  // namespace panelcal::test
