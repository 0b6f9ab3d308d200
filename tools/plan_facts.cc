// SPDX-License-Identifier: Apache-2.0
#include "panelcal/tools/plan_facts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "panelcal/calib/added_targets.h"
#include "panelcal/calib/convex_hull.h"

namespace panelcal::plan {
namespace {

using Place = Position<frame::Nominal>;

constexpr std::array kModels = {PanelModel::Offset,
                                PanelModel::Rigid,
                                PanelModel::Similarity,
                                PanelModel::Stretch,
                                PanelModel::Affine};
/// Two boards are alike if their worst leverages differ by less than this part.
constexpr double kAlike = 1e-6;
/// Outside of the hull begins a nanometre beyond it: copies are rounded.
constexpr double kOnHull_mm = 1e-6;
/// Places that a picture shows of one series.
constexpr std::size_t kSample = 6000;
/// Where the model is not determined, so many further targets are tried to make it so.
constexpr std::size_t kMostMissing = 4;

/// A target that is passed on like a hole.
PassingPlace passing(const PlannedPlace& target) {
  return {.nominal = target.nominal,
          .line = target.line,
          .file = target.file,
          .tool = target.tool,
          .path = target.path,
          .is_target = true};
}

/// Every k-th place, k a power of two.
class Sample {
 public:
  void add(const Place& place) {
    if (n_++ % stride_ != 0) return;
    if (places_.size() == kSample) {
      for (std::size_t i = 0; 2 * i < kSample; ++i) places_[i] = places_[2 * i];
      places_.resize(kSample / 2);
      stride_ *= 2;
      if ((n_ - 1) % stride_ != 0) return;
    }
    places_.push_back(place);
  }
  std::vector<Place> places() const { return places_; }

 private:
  std::vector<Place> places_;
  std::size_t n_ = 0;
  std::size_t stride_ = 1;
};

/// What the first walk has to know of a series, to choose which are shown.
struct Glance {
  std::optional<LeverageMap> leverage;  ///< under the programmed model
  double worst = 0;
  std::int64_t n_places = 0;
  Eigen::Vector2d low_mm = Eigen::Vector2d::Constant(1e300);
  Eigen::Vector2d high_mm = Eigen::Vector2d::Constant(-1e300);

  void grow(const Place& place) {
    low_mm = low_mm.cwiseMin(place.in_mm());
    high_mm = high_mm.cwiseMax(place.in_mm());
  }
};

/// One series while its plan is made.
struct Work {
  SeriesPlan plan;
  MapCovariance base_cov = MapCovariance::Zero();  ///< in units of this series' noise squared
  std::vector<LeverageMap> leverages;              ///< of the models that are determined
  std::vector<std::size_t> i_models;               ///< which those are
  HullBuilder corners;
  std::optional<CandidatePool> pool;
  Sample sample;
  std::vector<PlannedPlace> candidates;

  void see(const PassingPlace& place) {
    ++plan.n_places;
    for (std::size_t k = 0; k < leverages.size(); ++k) {
      plan.models[i_models[k]].stats.add(leverages[k](place.nominal), place);
    }
    corners.add(place.nominal);
    sample.add(place.nominal);
    const Length outside = distance_outside(plan.hull, place.nominal);
    if (outside.in_mm() <= kOnHull_mm) return;
    ++plan.n_outside;
    if (outside <= plan.farthest) return;
    plan.farthest = outside;
    plan.farthest_place = place.kept();
  }
};

class Planner {
 public:
  Planner(const Program& program,
          const WalkOptions& options,
          const Survey& survey,
          std::span<const PanelModel> programmed,
          const PlanRequest& request)
      : program_(program),
        options_(options),
        survey_(survey),
        programmed_(programmed),
        request_(request) {}

  Plan make() {
    summarize();
    glance();
    choose();
    look();
    for (Work& work : works_) advise(work);
    look_at_additions();
    for (Work& work : works_) plan_.series.push_back(std::move(work.plan));
    plan_.visits = plan_visits(survey_);
    return std::move(plan_);
  }

 private:
  void summarize() {
    plan_.n_targets = survey_.measurements.size();
    plan_.n_series = survey_.series.size();
    plan_.chooses_model = request_.chooses_model;
    plan_.machine = options_.uncertainty;
    plan_.sigma_source = request_.sigma_source;
    plan_.picture_sigma = request_.fiducial_sigma;
    if (!request_.recorded_mm.empty()) {
      plan_.picture_sigma = mm(*std::ranges::max_element(request_.recorded_mm));
    }
    for (const SeriesResult& series : survey_.series) {
      ++(series.level == CorrectionLevel::Base ? plan_.n_base : plan_.n_nested);
    }
  }

  template <class Visit>
  void walk(Visit visit) {
    PlaceSink sink(survey_, visit);
    DiagnosticLog said_already;
    execute(program_, options_, survey_, sink, said_already);
  }

  std::vector<DesignTarget> design_of(const SeriesResult& series) const {
    std::vector<DesignTarget> design;
    for (const std::size_t i : series.points) {
      const MeasurementRequest& request = survey_.measurements[i].request;
      design.push_back({request.nominal, request.axes});
    }
    return design;
  }

  double noise_mm(const SeriesResult& series) const {
    double picture2 = std::pow(request_.fiducial_sigma.in_mm(), 2);
    if (!request_.recorded_mm.empty()) {
      double sum = 0;
      for (const std::size_t i : series.points) sum += std::pow(request_.recorded_mm[i], 2);
      picture2 = sum / static_cast<double>(std::max<std::size_t>(1, series.points.size()));
    }
    return std::sqrt(picture2 + options_.uncertainty.of_target_mm2()(0, 0));
  }

  /// Of the base map, in units of the noise of a nested series squared.
  MapCovariance base_cov_of(const SeriesResult& series) const {
    if (series.level == CorrectionLevel::Base || !series.base_series) return MapCovariance::Zero();
    const SeriesResult& base = survey_.series[*series.base_series];
    const auto found = predict_fit(design_of(base), programmed_[*series.base_series]);
    if (!found.fit) return MapCovariance::Zero();
    return std::pow(noise_mm(base) / noise_mm(series), 2) * found.fit->cov;
  }

  /// First walk: how bad each series is, and where its places lie.
  void glance() {
    glances_.resize(survey_.series.size());
    for (std::size_t s = 0; s < glances_.size(); ++s) {
      const SeriesResult& series = survey_.series[s];
      const auto result = predict_fit(design_of(series), programmed_[s], base_cov_of(series));
      if (result.fit) glances_[s].leverage.emplace(result.fit->cov);
    }
    walk([this](const PassingPlace& place) {
      ++plan_.n_places;
      if (place.has_own_target) {
        ++plan_.n_own_target;
      } else if (const auto s = series_of(place)) {
        Glance& glance = glances_[*s];
        ++glance.n_places;
        if (glance.leverage) {
          glance.worst = std::max(glance.worst, (*glance.leverage)(place.nominal));
        }
      } else {
        ++plan_.n_uncorrected;
      }
      for (const auto& s : {place.base_series, place.nested_series}) {
        if (s) glances_[*s].grow(place.nominal);
      }
    });
  }

  static std::optional<std::size_t> series_of(const PassingPlace& place) {
    return place.nested_series ? place.nested_series : place.base_series;
  }

  /// Base series, a nested one that stands for the others, and the worst nested one.
  void choose() {
    std::optional<std::size_t> first;
    std::optional<std::size_t> worst;
    const auto badness = [this](std::size_t s) {
      return glances_[s].leverage ? glances_[s].worst : 1e300;
    };
    for (std::size_t s = 0; s < survey_.series.size(); ++s) {
      if (survey_.series[s].level == CorrectionLevel::Base) {
        if (works_.size() < kMostBase) add_work(s);
        continue;
      }
      if (!first) first = s;
      if (!worst || badness(s) > badness(*worst) * (1 + kAlike)) worst = s;
    }
    if (!first) return;
    for (std::size_t s = 0; s < survey_.series.size(); ++s) {
      if (survey_.series[s].level == CorrectionLevel::Nested &&
          badness(s) >= badness(*worst) * (1 - kAlike)) {
        ++plan_.n_like_worst;
      }
    }
    if (badness(*worst) > badness(*first) * (1 + kAlike)) add_work(*first);
    add_work(*worst);
  }

  void add_work(std::size_t s) {
    const SeriesResult& series = survey_.series[s];
    Work work;
    SeriesPlan& plan = work.plan;
    plan.i_series = s;
    plan.level = series.level;
    plan.programmed = programmed_[s];
    plan.design = design_of(series);
    plan.noise = mm(noise_mm(series));
    for (const std::size_t i : series.points) {
      plan.targets.push_back(target_place(survey_.measurements[i]));
    }
    std::vector<Place> places;
    for (const PlannedPlace& target : plan.targets) places.push_back(target.nominal);
    plan.hull = convex_hull(places);
    work.base_cov = base_cov_of(series);
    for (const PanelModel model : kModels) {
      const auto result = predict_fit(plan.design, model, work.base_cov);
      ModelPlan one;
      one.model = model;
      one.is_programmed = model == plan.programmed;
      one.fit = result.fit;
      one.failure = result.failure;
      if (result.fit) {
        one.lies = weakest(detect_lies(plan.design, *result.fit));
        work.leverages.emplace_back(result.fit->cov);
        work.i_models.push_back(plan.models.size());
      }
      plan.models.push_back(std::move(one));
    }
    Glance& glance = glances_[s];
    for (const PlannedPlace& target : plan.targets) glance.grow(target.nominal);
    if (series.level == CorrectionLevel::Base) {
      for (const PlannedPlace& target : nested_targets(s)) glance.grow(target.nominal);
    }
    work.pool.emplace(position_mm<frame::Nominal>(glance.low_mm),
                      position_mm<frame::Nominal>(glance.high_mm));
    works_.push_back(std::move(work));
  }

  std::vector<PlannedPlace> nested_targets(std::size_t base) const {
    std::vector<PlannedPlace> out;
    for (const SeriesResult& series : survey_.series) {
      if (series.level != CorrectionLevel::Nested || series.base_series != base) continue;
      for (const std::size_t i : series.points)
        out.push_back(target_place(survey_.measurements[i]));
    }
    return out;
  }

  /// Second walk: everything about the chosen series.
  void look() {
    std::map<std::size_t, Work*> by_series;
    for (Work& work : works_) by_series[work.plan.i_series] = &work;
    walk([&](const PassingPlace& place) {
      const auto responsible = series_of(place);
      for (const auto& s : {place.base_series, place.nested_series}) {
        if (!s) continue;
        const auto found = by_series.find(*s);
        if (found == by_series.end()) continue;
        found->second->pool->add(place);
        if (s == responsible && !place.has_own_target) found->second->see(place);
      }
    });
    for (Work& work : works_) {
      if (work.plan.level == CorrectionLevel::Base) {
        const auto targets = nested_targets(work.plan.i_series);
        work.plan.serves_targets = work.plan.n_places == 0 && !targets.empty();
        for (const PlannedPlace& target : targets) {
          if (work.plan.serves_targets) work.see(passing(target));
          work.pool->add(target);
        }
      }
      work.candidates = work.pool->candidates();
      work.plan.n_candidates = work.candidates.size();
      work.plan.is_thinned = work.pool->is_thinned();
      work.plan.sample = work.sample.places();
    }
  }

  void advise(Work& work) {
    if (work.plan.n_places == 0) return;
    std::vector<Place> places;
    for (const PlannedPlace& candidate : work.candidates) places.push_back(candidate.nominal);
    const std::vector<Place> corners = work.corners.corners();
    const AdditionProblem problem{.model = work.plan.programmed,
                                  .targets = work.plan.design,
                                  .candidates = places,
                                  .corners = corners,
                                  .base_cov = work.base_cov};
    std::size_t n = 1;
    Addition addition = best_additions(problem, n);
    while (!addition.worst_after && addition.chosen.size() == n && n < kMostMissing) {
      addition = best_additions(problem, ++n);
    }
    if (!addition.chosen.empty()) work.plan.one = addition_plan(work, addition);
    if (request_.n_added > n) {
      addition = best_additions(problem, request_.n_added);
      if (addition.chosen.size() > n) work.plan.several = addition_plan(work, addition);
    }
  }

  static AdditionPlan addition_plan(const Work& work, const Addition& addition) {
    AdditionPlan out;
    std::vector<DesignTarget> design = work.plan.design;
    for (const std::size_t i : addition.chosen) {
      out.pads.push_back(work.candidates[i]);
      design.push_back({work.candidates[i].nominal});
    }
    out.fit = predict_fit(design, work.plan.programmed, work.base_cov).fit;
    if (out.fit) out.lies = weakest(detect_lies(design, *out.fit));
    return out;
  }

  /// Third walk: every place as it would be with further targets.
  void look_at_additions() {
    struct Watched {
      AdditionPlan* addition;
      LeverageMap leverage;
    };
    std::map<std::size_t, std::vector<Watched>> by_series;
    for (Work& work : works_) {
      for (auto* addition : {&work.plan.one, &work.plan.several}) {
        if (!*addition || !(*addition)->fit) continue;
        by_series[work.plan.i_series].push_back({&**addition, LeverageMap((*addition)->fit->cov)});
      }
    }
    if (by_series.empty()) return;
    const auto see = [&](std::size_t s, const PassingPlace& place) {
      const auto found = by_series.find(s);
      if (found == by_series.end()) return;
      for (Watched& watched : found->second) {
        watched.addition->stats.add(watched.leverage(place.nominal), place);
      }
    };
    walk([&](const PassingPlace& place) {
      const auto s = series_of(place);
      if (s && !place.has_own_target) see(*s, place);
    });
    for (const Work& work : works_) {
      if (!work.plan.serves_targets) continue;
      for (const PlannedPlace& target : nested_targets(work.plan.i_series)) {
        see(work.plan.i_series, passing(target));
      }
    }
  }

  const Program& program_;
  const WalkOptions& options_;
  const Survey& survey_;
  std::span<const PanelModel> programmed_;
  const PlanRequest& request_;
  Plan plan_;
  std::vector<Glance> glances_;
  std::vector<Work> works_;
};

}  // namespace

const ModelPlan& SeriesPlan::in_force() const {
  return *std::ranges::find(models, programmed, &ModelPlan::model);
}

Length Plan::total_sigma(const SeriesPlan& one,
                         const PredictedFit& fit,
                         const PlannedPlace& place) const {
  const double noise2 = std::pow(one.noise.in_mm(), 2);
  Eigen::Matrix2d cov_mm2 = noise2 * LeverageMap(fit.cov).covariance(place.nominal);
  // Nothing is drilled at a target that is only looked for.
  if (!one.serves_targets) cov_mm2 += machine.shared_mm2() + machine.of_hole_mm2();
  return mm(greatest_sigma(cov_mm2));
}

Plan make_plan(const Program& program,
               const WalkOptions& options,
               const Survey& survey,
               std::span<const PanelModel> programmed,
               const PlanRequest& request) {
  return Planner(program, options, survey, programmed, request).make();
}

}  // namespace panelcal::plan
