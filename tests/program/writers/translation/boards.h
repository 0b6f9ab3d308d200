// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "tests/program/program_run.h"
#include "tests/program/writers/translation/run.h"

namespace panelcal::test {

/// A panel that lies turned and stretched, with boards that lie on it each in its own way.
FunctionSource panel_of_boards(const Eigen::Vector2d& pitch_mm, const Eigen::Vector2d& first_mm);
/// Of boards of 50 mm, from zero on.
FunctionSource small_boards();

/// One fit from where targets are nominally, instead of two that follow each other, lacks a shear
/// that is the product of a turn and a difference of stretches: 2 mrad times 500 ppm here. Holes on
/// their own board are 50 mm from its targets, others (behind the pattern) as far as the panel
/// goes.
inline constexpr double kShear_um_per_mm = 1e3 * 0.002 * 500e-6;
inline constexpr double kSameOnBoard_um = 2 * kShear_um_per_mm * 50;
inline constexpr double kSameOnPanel_um = 2 * kShear_um_per_mm * 250;

/// A board that leans and bulges by some tenths of a millimetre.
class BulgingBoard final : public ProbeSource {
 public:
  Expected<ProbeReading> probe(const ProbeRequest& request) override;
};

/// Both ask for the same targets by the same vision tools (G35), from where the same corrections
/// put them, and the same probes.
bool asks_alike(const WorkRun& a, const WorkRun& b);

/// Fits of the same targets from the same places; programs are written in 0.001 um.
inline constexpr double kSameFit_um = 0.002;

/// The largest distance in um of two runs, `a` on the panel `looks_a`: of the places that are
/// worked at, in the same order by the same tools, and of those where `b` looks for targets of
/// series (unless that is known to be lost). Negative if they are not the same places.
double distance_um(const WorkRun& a,
                   const FunctionSource& looks_a,
                   const WorkRun& b,
                   const FunctionSource& looks_b,
                   bool loses_looks = false);

/// The translation of a program, expected to do the same on this panel, but for `n_losses` things:
/// looks for targets under the correction in force.
std::string same_holes(const std::string& text,
                       double limit_um = kSameOnBoard_um,
                       FunctionSource panel = small_boards(),
                       const WalkOptions& options = {},
                       std::size_t n_losses = 0);

/// The translation, expected to work at the same places on small boards that bulge; in its own
/// language, in the same way. Losses are others' affair.
std::string same_strokes(const std::string& text, Dialect to, const WalkOptions& options = {});

/// The same of a SIEB & MEYER program in its own language, expected to ask for the same as well,
/// and to lose nothing.
std::string same_orders(const std::string& text, const WalkOptions& options = {});

/// A program with tools 1 and 2 and vision tool 1; lines of the body count from 7.
std::string boards_in_excellon(const std::string& body);

}  // namespace panelcal::test
