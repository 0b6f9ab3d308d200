// SPDX-License-Identifier: Apache-2.0
#include "tests/program/sieb_meyer/manual_run.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <numbers>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include "tests/support/matchers.h"

namespace panelcal::test {
namespace {

using Eigen::Vector2d;

constexpr double kSamePlace_mm = 1e-6;
/// Plunge points are rounded to the manual's 0.707, and then to what a program can say.
constexpr double kRadiusRounding_mm = 2e-3;

std::string in_capitals(std::string_view text) {
  std::string out(text);
  std::ranges::transform(
      out, out.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return out;
}

double cross(const Vector2d& a, const Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

double sweep_of(RoutKind kind, const Vector2d& from, const Vector2d& to) {
  const double left_turn_rad = std::atan2(cross(from, to), from.dot(to));
  const double sweep_rad = kind == RoutKind::Clockwise ? -left_turn_rad : left_turn_rad;
  constexpr double kNoTurn_rad = 1e-9;
  return sweep_rad < -kNoTurn_rad ? sweep_rad + 2 * std::numbers::pi : sweep_rad;
}

bool continues(const Piece& before, const Piece& piece) {
  return piece.kind != RoutKind::Line && before.kind == piece.kind &&
         (before.center_mm - piece.center_mm).norm() < kSamePlace_mm;
}

bool precedes(const Vector2d& a, const Vector2d& b) {
  if (std::abs(a.x() - b.x()) > kSamePlace_mm) return a.x() < b.x();
  return a.y() < b.y();
}

}  // namespace

std::string format_5000(std::string_view body) {
  return "%%5000\n" + std::string(body) + std::string(kToolTable);
}

std::string ended(std::string_view program) {
  const bool is_1000 = program.starts_with("%%\n");
  return std::string(program) + (is_1000 ? std::string(91, '$') + "\n" : "$\n$\n");
}

ProgramRun run_5000(std::string_view body, const WalkOptions& options, MeasurementSource& source) {
  ProgramRun run = run_program(format_5000(body), options, source);
  EXPECT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  return run;
}

ProgramRun run_5000(std::string_view body, const WalkOptions& options, ReadOptions reading) {
  ProgramRun run = run_program(format_5000(body), options, std::move(reading));
  EXPECT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  return run;
}

Places hole_places(const ProgramRun& run) {
  Places places;
  for (const Hole& hole : run.holes()) places.push_back(hole.nominal_mm());
  return places;
}

Places rout_ends(const ProgramRun& run) {
  Places places;
  for (const Rout& rout : run.executed.routs()) places.push_back(rout.nominal.in_mm());
  return places;
}

Places shifted(Places places, const Vector2d& offset_mm) {
  for (Vector2d& place : places) place += offset_mm;
  return places;
}

Places joined(Places first, const Places& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

void expect_places(const Places& found, const Places& expected, double tolerance_mm) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_THAT(found[i], IsNearMatrix(expected[i], tolerance_mm))
        << "place " << i << " is (" << found[i].transpose() << "), expected ("
        << expected[i].transpose() << ")";
  }
}

void expect_same_places(Places found, Places expected, double tolerance_mm) {
  std::ranges::sort(found, precedes);
  std::ranges::sort(expected, precedes);
  expect_places(found, expected, tolerance_mm);
}

std::vector<std::string> steps_of(const ProgramRun& run) {
  std::vector<std::string> steps;
  bool is_compensated = false;
  for (const std::string& line : run.executed.lines()) {
    std::string step = line.substr(line.find(' ') + 1);
    if (step.starts_with("retract")) {
      is_compensated = false;
      if (!steps.empty() && steps.back().starts_with("compensation off")) steps.pop_back();
    }
    if (step.starts_with("compensation")) {
      const bool is_off = step.starts_with("compensation off");
      if (is_off && !is_compensated) continue;
      is_compensated = !is_off;
    }
    steps.push_back(std::move(step));
  }
  return steps;
}

Vector2d Piece::direction_at(const Vector2d& p_mm) const {
  if (kind == RoutKind::Line) return (end_mm - start_mm).normalized();
  const Vector2d out = (p_mm - center_mm).normalized();
  return kind == RoutKind::Clockwise ? Vector2d(out.y(), -out.x()) : Vector2d(-out.y(), out.x());
}

std::vector<Piece> pieces_from(const Vector2d& start_mm, const std::vector<Rout>& routs) {
  std::vector<Piece> pieces;
  Vector2d at_mm = start_mm;
  for (const Rout& rout : routs) {
    Piece piece{rout.kind, at_mm, rout.actual.in_mm(), Vector2d::Zero(), 0};
    at_mm = piece.end_mm;
    if (piece.kind != RoutKind::Line) {
      piece.center_mm = rout.center.in_mm();
      piece.sweep_rad =
          sweep_of(piece.kind, piece.start_mm - piece.center_mm, piece.end_mm - piece.center_mm);
      EXPECT_NEAR((piece.start_mm - piece.center_mm).norm(), piece.radius_mm(), kRadiusRounding_mm);
      EXPECT_LE(piece.sweep_rad, std::numbers::pi + 1e-9) << "operations are half a circle at most";
    }
    if (!pieces.empty() && continues(pieces.back(), piece)) {
      pieces.back().end_mm = piece.end_mm;
      pieces.back().sweep_rad += piece.sweep_rad;
    } else {
      pieces.push_back(piece);
    }
  }
  return pieces;
}

void expect_refused(const ProgramRun& run,
                    int line,
                    std::initializer_list<std::string_view> words) {
  EXPECT_TRUE(run.has_errors);
  const bool is_found = std::ranges::any_of(run.texts, [&](const std::string& text) {
    if (!text.starts_with(fmt::format("p.exc:{}:", line))) return false;
    const std::size_t error = text.find(" error[");
    if (error == std::string::npos) return false;
    const std::string capitals = in_capitals(text.substr(text.find('[', error) + 1));
    return std::ranges::any_of(words, [&](std::string_view word) {
      return capitals.find(in_capitals(word)) != std::string::npos;
    });
  });
  EXPECT_TRUE(is_found) << "no error in line " << line << " that names one of "
                        << testing::PrintToString(std::vector<std::string_view>(words)) << ": "
                        << testing::PrintToString(run.diagnostics);
}

SubprogramFolder::SubprogramFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "panelcal-XXXXXX").string();
  path_ = mkdtemp(name.data());
}

SubprogramFolder::~SubprogramFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

SubprogramFolder& SubprogramFolder::with(const std::string& name, const std::string& text) {
  std::ofstream(path_ / name, std::ios::binary) << text;
  return *this;
}

ReadOptions SubprogramFolder::reading() const {
  ReadOptions options;
  options.pattern_folders = {path_};
  return options;
}

}  // namespace panelcal::test
