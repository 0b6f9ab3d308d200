// SPDX-License-Identifier: Apache-2.0
#include "tests/calib/faults/simulated_faults.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <locale>
#include <numbers>
#include <sstream>
#include <utility>

#include <Eigen/LU>

namespace panelcal::test {
namespace {

using internal::ExaminedTarget;
using Vector = Eigen::Vector2d;
using Matrix = Eigen::Matrix2d;

constexpr double kPanel_mm = 300;
constexpr double kView_mm = 3;  ///< distance from its axis to which a camera takes a pad

std::size_t pick(Random& random, std::size_t n) {
  return std::min(n - 1, static_cast<std::size_t>(random.uniform() * static_cast<double>(n)));
}

double log_uniform(Random& random, double low, double high) {
  return low * std::pow(high / low, random.uniform());
}

Vector in_any_direction(Random& random, double length_mm) {
  const double angle = random.uniform(0, 2 * std::numbers::pi);
  return {length_mm * std::cos(angle), length_mm * std::sin(angle)};
}

Matrix rotation_by(double angle) {
  Matrix r;
  r << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  return r;
}

/// An affine map of the plane.
struct Map {
  Matrix linear = Matrix::Identity();
  Vector shift_mm = Vector::Zero();
  Vector operator()(const Vector& p_mm) const { return linear * p_mm + shift_mm; }
};

/// Pose and stretch of the panel, by a third of the limits.
Map draw_lie(Random& random, const FaultSettings& settings, const Vector& center_mm) {
  const GateLimits& limits = settings.limits;
  const double stretch = *limits.stretch_ppm * 1e-6 / 3;
  const double theta = limits.rotation->in_rad() / 3 * random.normal();
  double sx = 1 + stretch * random.normal();
  double sy = 1 + stretch * random.normal();
  const double shear = settings.model == PanelModel::Affine ? stretch * random.normal() : 0;
  if (settings.model == PanelModel::Similarity) sy = sx;
  if (settings.model == PanelModel::Rigid) sx = sy = 1;
  Map map;
  map.linear << sx, shear, 0, sy;
  map.linear = rotation_by(theta) * map.linear;
  const double offset_mm = limits.offset->in_mm() / 3;
  map.shift_mm =
      center_mm - map.linear * center_mm + offset_mm * Vector(random.normal(), random.normal());
  return map;
}

std::vector<Vector> draw_fiducials(Random& random, int n) {
  std::vector<Vector> out;
  for (int i = 0; i < n; ++i) {
    const double x_mm = random.uniform(10, i < 4 ? 50 : kPanel_mm - 10);
    const double y_mm = random.uniform(10, i < 4 ? 50 : kPanel_mm - 10);
    const bool is_right = i == 1 || i == 2;
    const bool is_upper = i == 2 || i == 3;
    out.push_back({is_right ? kPanel_mm - x_mm : x_mm, is_upper ? kPanel_mm - y_mm : y_mm});
  }
  return out;
}

std::vector<KnownPad> draw_pads(Random& random, std::span<const Vector> fiducials) {
  std::vector<KnownPad> pads;
  for (const Vector& fiducial : fiducials) {
    pads.push_back({.place_mm = fiducial, .line = static_cast<int>(pads.size()) + 1});
  }
  const double pitch_mm = random.uniform(1, 5);
  for (double x_mm = 5; x_mm < kPanel_mm - 5; x_mm += pitch_mm) {
    for (double y_mm = 5; y_mm < kPanel_mm - 5; y_mm += pitch_mm) {
      const bool is_pad = random.uniform() < 1.0 / 3;
      const Vector place_mm(x_mm + pitch_mm * random.uniform(), y_mm + pitch_mm * random.uniform());
      if (!is_pad) continue;
      pads.push_back({place_mm, static_cast<int>(pads.size()) + 1, 1});
    }
  }
  return pads;
}

struct Panel {
  std::vector<Vector> fiducials;  ///< of the real panel, mm
  std::vector<KnownPad> pads;
  Vector center_mm = Vector::Zero();
  Map lie;
  double program_scale = 1;  ///< programmed over real
};

/// The pad that the camera takes where it looks, if one is near enough.
std::optional<Vector> taken(const Panel& panel, const Map& whole, const Vector& looked_at_mm) {
  std::optional<Vector> nearest;
  double nearest_mm = kView_mm;
  for (const KnownPad& pad : panel.pads) {
    const Vector place_mm = whole(pad.place_mm);
    const double distance_mm = (place_mm - looked_at_mm).norm();
    if (distance_mm < nearest_mm) {
      nearest_mm = distance_mm;
      nearest = place_mm;
    }
  }
  return nearest;
}

Map about(const Matrix& turn, const Vector& center_mm) {
  return {turn, center_mm - turn * center_mm};
}

/// Map of the panel before it was laid down as `lie` says.
Map draw_turn(Random& random, SimulatedFault fault, const Vector& middle_mm) {
  const Vector center_mm = middle_mm + Vector(random.normal(), random.normal());
  Matrix mirror = Matrix::Identity();
  switch (fault) {
    case SimulatedFault::QuarterSeen:
    case SimulatedFault::QuarterTaken:
      return about(rotation_by((random.uniform() < 0.5 ? 0.5 : -0.5) * std::numbers::pi),
                   center_mm);
    case SimulatedFault::HalfSeen:
    case SimulatedFault::HalfTaken:
      return about(-Matrix::Identity(), center_mm);
    case SimulatedFault::MirroredSeen:
    case SimulatedFault::MirroredTaken:
      mirror = Vector(1, -1).asDiagonal();
      if (random.uniform() < 0.5) mirror = -mirror;
      return about(mirror, center_mm);
    default:
      return {};
  }
}

bool is_taken(SimulatedFault fault) {
  return fault == SimulatedFault::QuarterTaken || fault == SimulatedFault::HalfTaken ||
         fault == SimulatedFault::MirroredTaken || fault == SimulatedFault::ScaleTaken;
}

/// Of a panel that is turned, mirrored or of another scale, in the finder's words.
std::string telling_of(const Matrix& turn, double scale) {
  if (turn(1, 0) > 0.5) return "by 90 degrees counter-clockwise";
  if (turn(1, 0) < -0.5) return "by 90 degrees clockwise";
  if (turn(0, 0) < 0 && turn(1, 1) < 0) return "by 180 degrees";
  if (turn(0, 0) < 0) return "left and right exchanged";
  if (turn(1, 1) < 0) return "top and bottom exchanged";
  if (std::abs(scale - 1) < 1e-9) return "";
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << "is " << std::setprecision(4) << scale << " times";
  return text.str();
}

double draw_scale(Random& random, SimulatedFault fault) {
  constexpr std::array kSeen = {25.4, 10.0, 100.0, 1 / 25.4, 0.1, 0.01};
  if (fault == SimulatedFault::ScaleSeen) return kSeen[pick(random, kSeen.size())];
  if (fault == SimulatedFault::ScaleTaken) return random.uniform() < 0.5 ? 25.4 : 10;
  return 1;
}

/// True places of the targets, or of what the camera takes for them; empty if there is nothing.
std::optional<std::vector<Vector>> places_of(const Panel& panel, const Map& turn, bool is_taken) {
  const Map whole{panel.lie.linear * turn.linear, panel.lie(turn.shift_mm)};
  std::vector<Vector> places;
  for (const Vector& fiducial : panel.fiducials) {
    if (!is_taken) {
      places.push_back(whole(fiducial));
      continue;
    }
    const std::optional<Vector> pad = taken(panel, whole, panel.program_scale * fiducial);
    if (!pad || std::ranges::find(places, *pad) != places.end()) return std::nullopt;
    places.push_back(*pad);
  }
  return places;
}

void move_several(Random& random, std::vector<Vector>& places) {
  const std::size_t n_moved = 2 + pick(random, places.size() - 1);
  const std::size_t first = pick(random, places.size());
  for (std::size_t k = 0; k < n_moved; ++k) {
    places[(first + k) % places.size()] += in_any_direction(random, log_uniform(random, 0.5, 5));
  }
}

/// Another pad 0.5 to 6 mm away; nothing if there is none.
std::optional<Vector> other_pad(Random& random, const Panel& panel, const Vector& own_mm) {
  std::vector<Vector> near;
  for (const KnownPad& pad : panel.pads) {
    const double distance_mm = (pad.place_mm - own_mm).norm();
    if (distance_mm > 0.5 && distance_mm < 6) near.push_back(pad.place_mm);
  }
  if (near.empty()) return std::nullopt;
  return panel.lie(near[pick(random, near.size())]);
}

std::vector<ExaminedTarget> measured(Random& random,
                                     const Panel& panel,
                                     std::span<const Vector> places) {
  const double sigma_mm = log_uniform(random, 2e-3, 10e-3);
  std::vector<ExaminedTarget> out;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double own_mm = sigma_mm * random.uniform(0.7, 1.4);
    const Vector error_mm = own_mm * Vector(random.normal(), random.normal());
    out.push_back({panel.program_scale * panel.fiducials[i],
                   places[i] + error_mm,
                   own_mm * own_mm * Matrix::Identity(),
                   ObservedAxes::Both,
                   random.uniform(0.9, 1.0),
                   "target " + std::to_string(i + 1)});
  }
  return out;
}

}  // namespace

std::string_view name(SimulatedFault fault) {
  constexpr std::array<std::string_view, 13> kNames = {"healthy",
                                                       "wrong pad",
                                                       "damaged mark",
                                                       "out of focus",
                                                       "turned by 90, seen",
                                                       "turned by 180, seen",
                                                       "mirrored, seen",
                                                       "scale, seen",
                                                       "turned by 90, taken",
                                                       "turned by 180, taken",
                                                       "mirrored, taken",
                                                       "scale, taken",
                                                       "wrong revision"};
  return kNames[static_cast<std::size_t>(fault)];
}

FaultCause cause_of(SimulatedFault fault) {
  using enum FaultCause;
  constexpr std::array kCauses = {Unexplained,
                                  WrongPad,
                                  DamagedMark,
                                  OutOfFocus,
                                  TurnedQuarter,
                                  TurnedHalf,
                                  Mirrored,
                                  WrongScale,
                                  TurnedQuarter,
                                  TurnedHalf,
                                  Mirrored,
                                  WrongScale,
                                  WrongRevision};
  return kCauses[static_cast<std::size_t>(fault)];
}

FaultSettings usual_settings() {
  FaultSettings settings;
  settings.limits.offset = mm(2);
  settings.limits.rotation = rad(0.01);
  settings.limits.stretch_ppm = 500;
  settings.limits.false_alarm = 1e-3;
  return settings;
}

bool SimulatedJob::is_refused() const {
  std::vector<TargetPair<frame::Actual, frame::Nominal>> pairs;
  for (const ExaminedTarget& target : targets) {
    pairs.push_back({.nominal = position_mm<frame::Nominal>(target.from_mm),
                     .measured = {position_mm<frame::Actual>(target.to_mm), target.cov_mm2}});
  }
  const auto result = fit_panel<frame::Actual, frame::Nominal>(pairs, model);
  if (!result.fit) return true;
  return result.fit->map.map.linear().determinant() <= 0 ||
         !all_accepted(check_gates(*result.fit, limits));
}

std::optional<SeriesFault> SimulatedJob::examine() const {
  const KnownPads known(pads);
  return internal::find_fault_raw(targets, model, {limits, is_refused(), &known});
}

std::optional<SimulatedJob> draw_job(Random& random,
                                     SimulatedFault fault,
                                     const FaultSettings& settings) {
  Panel panel;
  panel.fiducials = draw_fiducials(random, settings.n_targets);
  if (settings.has_pads) panel.pads = draw_pads(random, panel.fiducials);
  const Vector work_zero_mm(random.uniform(0, kPanel_mm), random.uniform(0, kPanel_mm));
  for (Vector& fiducial : panel.fiducials) fiducial -= work_zero_mm;
  for (KnownPad& pad : panel.pads) pad.place_mm -= work_zero_mm;
  panel.center_mm = Vector::Constant(kPanel_mm / 2) - work_zero_mm;
  panel.lie = draw_lie(random, settings, panel.center_mm);
  panel.program_scale = 1 / draw_scale(random, fault);
  const Map turn = draw_turn(random, fault, panel.center_mm);
  auto places = places_of(panel, turn, is_taken(fault));
  if (!places) return std::nullopt;
  SimulatedJob job;
  job.telling = telling_of(turn.linear, 1 / panel.program_scale);
  job.model = settings.model;
  job.limits = settings.limits;
  job.cause = cause_of(fault);
  const std::size_t i = pick(random, places->size());
  const double size_mm = log_uniform(random, settings.least_size_mm, settings.greatest_size_mm);
  const bool is_shifted = fault == SimulatedFault::Damaged || fault == SimulatedFault::OutOfFocus;
  if (is_shifted) (*places)[i] += in_any_direction(random, size_mm);
  if (fault == SimulatedFault::WrongPad) {
    const std::optional<Vector> other = other_pad(random, panel, panel.fiducials[i]);
    if (!other) return std::nullopt;
    (*places)[i] = *other;
  }
  if (is_shifted || fault == SimulatedFault::WrongPad) job.i_outlier = i;
  if (fault == SimulatedFault::Revision) move_several(random, *places);
  job.targets = measured(random, panel, *places);
  if (fault == SimulatedFault::OutOfFocus) {
    ExaminedTarget& blurred = job.targets[i];
    const double factor = random.uniform(2.5, 6);
    blurred.cov_mm2 *= factor * factor;
    blurred.score = random.uniform(0.3, 0.6);
  }
  for (const KnownPad& pad : panel.pads) {
    job.pads.push_back({panel.program_scale * pad.place_mm, pad.line, pad.tool});
  }
  return job;
}

Finding finding_of(const SimulatedJob& job, const std::optional<SeriesFault>& fault) {
  if (!fault || fault->suspicions.empty()) return Finding::Missed;
  const auto is_right = [&](const SeriesFault::Suspicion& suspicion) {
    if (job.i_outlier) return suspicion.i_point == job.i_outlier;
    return suspicion.cause == job.cause && suspicion.text.find(job.telling) != std::string::npos;
  };
  if (job.i_outlier && fault->i_outlier == job.i_outlier) return Finding::Named;
  // Shares of several suspicions are not added up: the text says then that it cannot tell.
  if (fault->is_named()) return is_right(fault->suspicions[0]) ? Finding::Named : Finding::Wrong;
  if (fault->i_outlier) return Finding::Wrong;
  return std::ranges::any_of(fault->suspicions, is_right) ? Finding::Listed : Finding::Wrong;
}

}  // namespace panelcal::test
