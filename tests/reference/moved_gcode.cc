// SPDX-License-Identifier: Apache-2.0
// Moves a G-code program by formulas, and prints it.
//
//   moved_gcode FILE a b c d tx ty bend [mm|inch]
//
//   x' = a x + b (y + bend x^2) + tx
//   y' = c x + d (y + bend x^2) + ty,   mm
//
// Out    exit 1 and the diagnostic if the program is refused
// See    tests/reference/moved_gcode_test.py
#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "program/gcode/mover.h"

namespace panelcal {
namespace {

class FormulaPlaces final : public BoardPlaces {
 public:
  explicit FormulaPlaces(const std::array<double, 7>& numbers) : n_(numbers) {}

  Eigen::Vector2d actual_mm(const Eigen::Vector2d& p_mm) const override {
    const double x = p_mm.x();
    const double y = p_mm.y() + n_[6] * x * x;
    return {n_[0] * x + n_[1] * y + n_[4], n_[2] * x + n_[3] * y + n_[5]};
  }
  Expected<Length> sigma(const Eigen::Vector2d&) const override { return um(1); }

 private:
  std::array<double, 7> n_;
};

int move(int argc, char** argv) {
  std::array<double, 7> numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = std::strtod(argv[2 + i], nullptr);
  MoveOptions options;
  if (argc > 9) options.unit_mm = std::string_view(argv[9]) == "inch" ? inch(1).in_mm() : 1;
  const auto program = read_source(argv[1]);
  if (!program) return EXIT_FAILURE;
  const auto moved = move_gcode(*program, FormulaPlaces(numbers), options);
  if (!moved) {
    std::fputs(moved.error().text().c_str(), stderr);
    return EXIT_FAILURE;
  }
  std::fputs(moved->text.c_str(), stdout);
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace panelcal

int main(int argc, char** argv) {
  return argc < 9 ? EXIT_FAILURE : panelcal::move(argc, argv);
}
