// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/diagnostic.h"
#include "program/model/operation.h"
#include "program/walk/control_settings.h"
#include "program/walk/probing.h"
#include "program/walk/reporter.h"
#include "program/walk/survey.h"
#include "surface/control/grid_map.h"
#include "surface/control/memory.h"
#include <Eigen/Core>

namespace panelcal::sieb_meyer {

/// The surface detection of one walk: SLM with its memory, and the measured grid.
///
/// With a source it probes and fills the survey (first walk); without one it takes the readings
/// from the survey in the same order. Operations carry the first Z axis' heights; the survey has
/// all.
///
/// Source SIEB & MEYER CNC 8x.00 Command Set, 10 Surface detection; semantics page, Surface
/// See    tests/program/sieb_meyer/measuring/surface_manual_test.cc
class SurfaceSession {
 public:
  SurfaceSession(const Settings& settings,
                 Survey& survey,
                 ProbeSource* source,
                 const Reporter& reporter,
                 DiagnosticLog& log);

  void switch_on() { is_on_ = true; }    // G71
  void switch_off() { is_on_ = false; }  // G70
  bool is_on() const { return is_on_; }
  void clear_memory();  // G72

  /// G73 with coordinates: probes, and stores under L or for averaging.
  void detect(ProbeRequest request);
  /// G73 without coordinates: stores the surface that was probed last once more.
  void store_last(int line, std::optional<int> memory);
  void average(int line, int memory);         // G74
  void take_reference(int line, int memory);  // L alone
  void record(ProbeRequest request);          // G76
  void grid_reference(ProbeRequest request);  // G78
  void grid_point(ProbeRequest request);      // G79

  /// SPAV, by its letter; false: there is no such letter.
  bool set_average(std::string_view letter);
  std::string_view average_letter() const;
  /// In     name: BOTT, TOPT or MAPT; each holds by itself
  void set_tolerance(const std::string& name, Length tolerance);
  /// BOTR or TOPR; false: another height was set before.
  bool set_reference_height(Length height);

  /// The reference surface of SLM, one a Z axis; empty where none was taken.
  std::vector<Length> reference() const;
  /// True if that was probed: a perfect board, of which a program is checked, has no sigma.
  bool is_measured() const { return !current_.empty() && current_.front().sigma > Length(); }
  bool has_grid() const { return !points_.empty(); }
  /// The surface that was probed last is one of the grid's (G78, G79).
  bool last_is_of_grid() const { return last_is_of_grid_; }
  /// The surface of the grid at a nominal place; stops the walk where the points make no grid, or
  /// far outside of it.
  struct GridSurface {
    std::vector<Length> heights;  ///< one a Z axis
    Length deviation;             ///< of the first axis: how much above the grid's reference
    std::optional<PredictedHeight>
        predicted;  ///< a node about it is not probed: [surface] fill_gaps
  };
  std::optional<GridSurface> grid_surface_at(int line, const Eigen::Vector2d& nominal_mm);
  /// The same where it was measured; empty if the control was told it.
  std::optional<PlaneReference> measured_reference() const;
  /// The grid itself, to cut contours; null if there is none.
  const GridMap* grid(int line);

  bool must_stop() const { return must_stop_; }

 private:
  /// The meaning of a probe that finds nothing.
  enum class Missing : std::uint8_t {
    StopsTheJob,
    LeavesGap,  ///< if [surface] fill_gaps allows it
  };
  std::optional<std::vector<HeightEstimate>> probe(ProbeRequest request,
                                                   Missing missing = Missing::StopsTheJob);
  void forget_filled();
  void store(int line, std::optional<int> memory, const std::vector<HeightEstimate>& heights);
  void stop(Code code, int line, std::string what, std::string expected);
  void clear_grid();
  bool holds_tolerances(int line,
                        const Eigen::Vector2d& nominal_mm,
                        const std::vector<HeightEstimate>& heights);
  std::vector<Length> grid_references() const;
  bool fill_gaps(int line);
  std::optional<PredictedHeight> predicted_at(const GridHeight& found,
                                              const Eigen::Vector2d& nominal_mm) const;

  const Settings& settings_;
  Survey& survey_;
  ProbeSource* source_;
  const Reporter& reporter_;
  DiagnosticLog& log_;

  bool is_on_ = false;
  SurfaceMemory memory_;
  AverageKind average_;
  std::vector<HeightEstimate> current_;  ///< reference of SLM; empty: none
  std::vector<HeightEstimate> last_;     ///< the surface that was probed last
  bool last_is_of_grid_ = false;
  std::vector<HeightEstimate> grid_reference_;
  Position<frame::Nominal> grid_reference_place_;
  std::optional<Length> configured_reference_;
  std::map<std::string, Length> tolerances_;  ///< by name
  std::vector<GridPoint> points_;
  std::vector<int> point_lines_;
  std::optional<GridMap> grid_;
  std::vector<FilledNode> filled_;  ///< of that grid
  std::size_t n_probed_ = 0;
  bool must_stop_ = false;
};

}  // namespace panelcal::sieb_meyer
