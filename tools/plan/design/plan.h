// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "calib/advice/chosen_range.h"
#include "calib/advice/named_error.h"
#include "calib/advice/noticed_error.h"
#include "calib/advice/target_design.h"
#include "calib/base/machine_uncertainty.h"
#include "calib/base/units.h"
#include "calib/panel/fit.h"
#include "program/walk/survey.h"
#include "tools/plan/design/models.h"
#include "tools/plan/design/places.h"
#include "tools/plan/design/visits.h"

namespace panelcal::plan {

/// The leverage of places under one fit.
struct LeverageStats {
  std::int64_t n = 0;
  double sum = 0;
  double worst = 0;
  PlannedPlace worst_place;

  void add(double leverage, const PassingPlace& place) {
    ++n;
    sum += leverage;
    if (leverage <= worst) return;
    worst = leverage;
    worst_place = place.kept();
  }
  double mean() const { return n > 0 ? sum / static_cast<double>(n) : 0; }
};

/// The answer of a job to an error of one target alone, in the direction where it shows least.
struct TargetError {
  std::size_t i_target = 0;  ///< in the series
  NoticedError noticed;
  /// At the size that is noticed, and at twice it; absent: not tried.
  std::optional<ErrorTrials> at_once;
  std::optional<ErrorTrials> at_twice;
};

/// From stiff to soft.
inline constexpr std::array kPlannedModels = {PanelModel::Offset,
                                              PanelModel::Rigid,
                                              PanelModel::Similarity,
                                              PanelModel::Stretch,
                                              PanelModel::Affine};

/// The figures of a series under one model.
struct ModelPlan {
  PanelModel model = PanelModel::Offset;
  bool is_programmed = false;
  std::optional<PredictedFit> fit;  ///< in units of the series' noise; absent: not determined
  FitFailure failure = FitFailure::TooFewTargets;
  LeverageStats stats;
  std::optional<NoticedError> noticed;  ///< of the target where it comes latest
};

/// Further targets, and what becomes of the worst place with them.
struct AdditionPlan {
  bool is_best = false;  ///< of all choices, else of those that were searched
  std::vector<PlannedPlace> pads;
  PanelModel model = PanelModel::Offset;  ///< that a job fits to that number of targets
  std::optional<PredictedFit> fit;        ///< absent: not even these determine the model
  /// If that is another model than the one in force: the worst place if it stayed the same.
  std::optional<double> worst_if_kept;
  LeverageStats stats;
  std::optional<TargetError> latest;  ///< of the target whose error is noticed latest
};

struct SeriesPlan {
  std::size_t i_series = 0;
  CorrectionLevel level = CorrectionLevel::Base;
  PanelModel programmed = PanelModel::Offset;
  std::vector<PlannedPlace> targets;
  std::vector<DesignTarget> design;
  /// Of the map that a nested series is looked up under, in units of its own noise squared; zero
  /// for a base series.
  MapCovariance base_cov = MapCovariance::Zero();
  Length noise;                     ///< along each axis, the root mean square over the targets
  GateLimits limits;                ///< that a job holds the series against
  bool predicts_errors = true;      ///< of a smooth model nothing is known before the measurement
  std::vector<TargetError> errors;  ///< under the model in force, one per target
  /// The worst place where the job chooses the model; absent: it does not.
  std::optional<ChosenRange> chosen;
  std::vector<ModelPlan> models;  ///< from stiff to soft
  std::int64_t n_places = 0;
  /// No hole is corrected by this series alone; places are the nested targets that it has to find.
  bool serves_targets = false;
  std::vector<Position<frame::Nominal>> hull;         ///< of the targets
  std::vector<Position<frame::Nominal>> places_hull;  ///< the worst place is one of its corners
  std::int64_t n_outside = 0;                         ///< places outside of it
  Length farthest;
  PlannedPlace farthest_place;
  bool has_slots = false;                ///< targets that show one axis only
  std::size_t n_addable = 0;             ///< the number of further targets the series may have
  std::vector<PlannedPlace> candidates;  ///< pads among which further targets are chosen
  bool is_thinned = false;               ///< not every hole is a candidate
  /// That a job fits with 0, 1, .. further targets, up to kMostAdded.
  std::vector<PanelModel> models_with;
  std::optional<AdditionPlan> one;      ///< the best single target, or the fewest that determine
  std::optional<AdditionPlan> several;  ///< the best --add K, K > 1

  const ModelPlan& in_force() const;  ///< under the programmed model
};

struct Plan {
  std::int64_t n_places = 0;  ///< holes, ends of slots and of rout moves
  bool has_routs = false;     ///< not only holes
  std::int64_t n_uncorrected = 0;
  std::int64_t n_own_target = 0;
  std::size_t n_targets = 0;
  std::size_t n_base = 0;
  std::size_t n_nested = 0;
  std::size_t n_like_worst = 0;    ///< nested series as bad as the worst
  std::vector<SeriesPlan> series;  ///< base ones, a nested one for all, and the worst nested one
  bool chooses_model = false;      ///< [vision] model = "auto"
  bool fixes_model = false;        ///< [vision] model names one
  bool bends_panel = false;        ///< it is "smooth": the plan is of its affine part
  MachineUncertainty machine;
  Length picture_sigma;      ///< of a target, by the picture alone; of several kinds the greatest
  bool is_recorded = false;  ///< every series has its own noise, as an earlier job had it
  bool is_assumed = false;   ///< neither recorded nor stated
  std::string sigma_source;  ///< its source, in words
  VisitPlan visits;

  /// Of a hole, with all that the machine adds; of a board's target, how well it is looked for.
  Length total_sigma(const SeriesPlan& one,
                     const PredictedFit& fit,
                     const PlannedPlace& place) const;
};

/// More than these `--add` does not take.
inline constexpr std::size_t kMostAdded = 20;

struct PlanRequest {
  Length fiducial_sigma = um(2);
  /// Covariance by measurement as recorded, mm^2, of a slot in its axis alone; empty:
  /// fiducial_sigma for all.
  std::vector<Eigen::Matrix2d> recorded_mm2;
  std::string sigma_source;
  bool is_assumed = true;
  std::size_t n_added = 1;
  bool chooses_model = false;             ///< the job will; the plan takes what the manual says
  std::optional<PanelModel> fixed_model;  ///< [vision] model, whatever the walk had
  bool bends_panel = false;               ///< the job will be smooth; the plan takes affine
};

}  // namespace panelcal::plan
