// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "machine/config/machine_config.h"
#include "tools/synth/sweep/design.h"
#include <Eigen/Core>

namespace panelcal::synth {

/// A number of [sim] that differs between the points of an experiment.
struct Factor {
  std::string key;     ///< of [sim]: "noise", "debris.rim_share", "panel_offset_mm.x"
  std::string column;  ///< of the manifest
  std::optional<double> from, to;
  std::vector<double> values;  ///< instead of a range
  int n_levels = 0;            ///< equal steps from `from` to `to`, both included; 0: continuous
  bool is_log = false;         ///< equal ratios
  bool is_whole = false;       ///< by its key in machine.toml

  /// The value at a share of the range, in [0, 1): with six digits, but for ends and `values`.
  double at(double share) const;
  std::size_t n_values() const;  ///< 0: continuous
};

/// A test set as an experiment: docs/formats/sweep.md.
struct Sweep {
  std::filesystem::path file;
  std::filesystem::path machine;
  std::filesystem::path program;  ///< or:
  std::optional<int> tool;        ///< pictures of one target each
  int n_pictures = 1;             ///< of a tool, in each point
  Design design = Design::Grid;
  std::size_t n_designed = 0;  ///< different points
  int n_repeats = 1;           ///< of each, with other seeds
  std::uint64_t seed = 1;
  std::vector<Factor> factors;
  Eigen::MatrixXd shares;  ///< a row a designed point, a column a factor

  std::size_t n_points() const { return n_designed * static_cast<std::size_t>(n_repeats); }
};

/// One point of an experiment, numbered from 0.
struct Point {
  std::string id;              ///< "000001"
  std::uint64_t seed = 1;      ///< of [sim], where no factor is the seed
  std::vector<double> values;  ///< of the factors, in their order
};

/// Larger experiments are refused.
inline constexpr std::size_t kMaxPoints = 1'000'000;

/// Reads a sweep file. Names of files count from its folder.
///
/// Fails  file-unreadable; toml-syntax; config-key-unknown; config-value: a factor that [sim] does
///        not have or whose range leaves what its key takes, a factor without values or with two
///        kinds of them, one that a grid has no levels of, points of a grid, too many points
/// See    tests/tools/synth/sweep_file_test.cc
Expected<Sweep> read_sweep(const std::filesystem::path& file);
Expected<Sweep> parse_sweep(std::string_view text, const std::filesystem::path& file);

/// Point number i of n_points(): a function of the sweep alone.
Point point_of(const Sweep& sweep, std::size_t i);

/// The machine with the point's values and seed in [sim].
///
/// In     machine_text: of sweep.machine, which is valid
/// Fails  config-value, at the sweep file: values that machine.toml does not take together
Expected<MachineConfig> machine_of(const Sweep& sweep,
                                   const Point& point,
                                   const std::string& machine_text);

}  // namespace panelcal::synth
