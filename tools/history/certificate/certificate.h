// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "machine/config/plate/plate.h"

// The quality certificate of a machine, from its ledger: plain data, everything that the page
// shows. Words and evaluation are those of the GUM (JCGM 100:2008), see docs/how_sure.md.
namespace panelcal::history {

/// The coverage of expanded uncertainties: that of k = 2 for a normal distribution.
inline constexpr double kCoverage = 0.9545;

/// A scatter that was observed: type A.
struct Scatter {
  double variance = 0;            ///< in the square of the unit
  double degrees_of_freedom = 0;  ///< above 0

  double sigma() const;
  /// The interval that holds the true sigma in 95 of 100 cases (chi-square); the upper end is
  /// infinite where there is next to no degree of freedom.
  std::array<double, 2> interval() const;
};

/// A scatter that nights have observed again and again, put together with the weights of their
/// degrees of freedom.
struct Repeatability {
  std::string subject;  ///< "spindle-camera spindle 1 station 1"
  std::string name;     ///< "looks at a hole"
  std::string unit;     ///< of sigma
  int n_nights = 0;
  Scatter scatter;
};

/// Gauge study of the camera on its stage (AIAG, Measurement Systems Analysis): looks at one hole
/// are the trials, nights stand where a study has its operators.
///
///   EV^2 = scatter of looks at a hole
///   S^2  = scatter of the offset over the nights,  u^2 = what each night's own covariance explains
///   AV^2 = max(0, S^2 - u^2),   R&R^2 = EV^2 + AV^2,   %tolerance = 100 * 6 R&R / (2 T)
struct GaugeStudy {
  Scatter repeatability;       ///< EV^2, mm^2
  Scatter over_nights;         ///< S^2
  double within_variance = 0;  ///< u^2, the mean over nights and axes
  double reproducibility_variance() const;
  /// By Welch and Satterthwaite.
  Scatter both() const;
  std::optional<double> percent_of_tolerance;
};

/// A row of an uncertainty budget.
struct BudgetRow {
  std::string source;              ///< "offset", "nights", "look", "drill", "map", "table", "plate"
  char type = 'A';                 ///< or B
  std::array<double, 2> sigma_mm;  ///< standard uncertainty along x and y
  std::optional<double> degrees_of_freedom;  ///< absent: unlimited, or not known
  std::string origin;                        ///< entries, or the key that states it
};

/// Position of a drilled hole about the place that its targets give it, along each axis.
struct UncertaintyBudget {
  std::vector<BudgetRow> rows;
  std::vector<std::string> missing;  ///< sources of which nothing is known: U is without them
  /// Combined, mm: the root of the sum of squares.
  std::array<double, 2> combined_mm() const;
  /// Effective ones by Welch and Satterthwaite; absent: unlimited.
  std::array<std::optional<double>, 2> degrees_of_freedom() const;
  /// Student's t of kCoverage.
  std::array<double, 2> coverage_factor() const;
};

/// One calibration that was installed.
struct CertifiedNight {
  std::int64_t entry = 0;
  std::chrono::sys_seconds time{};
  std::string asked_by;
  std::array<double, 2> value_mm = {};
  std::array<double, 2> sigma_mm = {};
};

/// A spindle with the camera that sees its holes.
struct SpindleCertificate {
  std::string subject;
  std::optional<std::int64_t> in_force;     ///< entry
  std::vector<CertifiedNight> nights;       ///< installed since the newest fresh start
  int n_refused = 0;                        ///< since then, left out
  int n_rolled_back = 0;                    ///< likewise
  std::optional<std::int64_t> fresh_start;  ///< its entry
  std::optional<GaugeStudy> gauge;
  std::optional<UncertaintyBudget> budget;
};

/// A figure of the stage, in the words of ISO 230-1 and 230-2.
struct StageFigure {
  std::string axis;      ///< "x", "y", "xy"
  std::string quantity;  ///< "reversal", "repeatability", "range", "scale", "squareness", ...
  double value = 0;      ///< in `unit`
  std::optional<double> sigma;
  std::string unit;  ///< mm, rad, 1
  int n_nights = 1;
  std::string origin;  ///< entries
};

/// The plate that a table's calibration in force was made on, as its file has it.
struct PlateTrace {
  CalibrationPlate plate;
  std::string sha256;
  std::int64_t entry = 0;  ///< the table's, among whose inputs the file is
};

/// Something that the certificate does not state, and why.
struct NotMeasured {
  std::string what;
  std::string why;  ///< with what to do
};

struct Certificate {
  std::string machine;
  std::optional<double> tolerance_mm;  ///< T: the largest error of a place along an axis
  std::string tolerance_origin;        ///< the key that states it
  std::vector<Repeatability> repeatability;
  std::vector<SpindleCertificate> spindles;
  std::optional<std::int64_t> table_entry;  ///< in force
  std::vector<StageFigure> stage;
  std::optional<PlateTrace> plate;
  std::vector<NotMeasured> not_measured;
};

/// Student's t that a variable exceeds in absolute value with the chance 1 - coverage; of no limit
/// the normal distribution's. GUM G.3.
double coverage_factor_of(double coverage, const std::optional<double>& degrees_of_freedom);

}  // namespace panelcal::history
