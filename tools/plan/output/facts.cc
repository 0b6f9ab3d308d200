// SPDX-License-Identifier: Apache-2.0
#include "tools/plan/output/facts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "calib/advice/convex_hull.h"
#include "tools/plan/design/design.h"
#include "tools/plan/design/series.h"

namespace panelcal::plan {
namespace {

using Place = Position<frame::Nominal>;

/// Two boards are alike if their worst leverages differ by less than this part.
constexpr double kAlike = 1e-6;

/// A target that is passed on like a hole.
PassingPlace passing(const PlannedPlace& target) {
  return {.nominal = target.nominal,
          .line = target.line,
          .file = target.file,
          .tool = target.tool,
          .path = target.path,
          .is_target = true};
}

/// Facts of a series for the first walk, to choose which are shown.
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
        request_(request),
        designs_(survey, programmed, request, options.uncertainty),
        rule_{program.dialect, request.fixed_model, options.sieb_meyer.fits_scale} {}

  Plan make() {
    summarize();
    glance();
    choose();
    look();
    for (SeriesWork& work : works_) find_additions(work, rule_, request_.n_added);
    look_at_additions();
    for (SeriesWork& work : works_) plan_.series.push_back(std::move(work.plan));
    plan_.visits = plan_visits(survey_);
    return std::move(plan_);
  }

 private:
  void summarize() {
    plan_.n_targets = survey_.measurements.size();
    plan_.chooses_model = request_.chooses_model;
    plan_.bends_panel = request_.bends_panel;
    plan_.fixes_model = request_.fixed_model.has_value();
    plan_.is_recorded = !request_.recorded_mm2.empty();
    plan_.machine = options_.uncertainty;
    plan_.sigma_source = request_.sigma_source;
    plan_.is_assumed = request_.is_assumed;
    plan_.picture_sigma = request_.fiducial_sigma;
    for (const Eigen::Matrix2d& noise_mm2 : request_.recorded_mm2) {
      const Length sigma = mm(std::sqrt(noise_mm2.trace() / 2));
      const bool is_first = &noise_mm2 == &request_.recorded_mm2.front();
      plan_.picture_sigma = is_first ? sigma : std::max(plan_.picture_sigma, sigma);
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

  /// First walk: how bad each series is, and where its places lie.
  void glance() {
    glances_.resize(survey_.series.size());
    for (std::size_t s = 0; s < glances_.size(); ++s) {
      const auto result = predict_fit(designs_.targets(s), programmed_[s], designs_.base_cov(s));
      if (result.fit) glances_[s].leverage.emplace(result.fit->cov);
    }
    walk([this](const PassingPlace& place) {
      ++plan_.n_places;
      plan_.has_routs |= place.is_rout;
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
    SeriesWork work;
    SeriesPlan& plan = work.plan;
    plan.i_series = s;
    plan.level = series.level;
    plan.programmed = programmed_[s];
    plan.design = designs_.targets(s);
    plan.noise = mm(designs_.noise_mm(s));
    plan.limits = share_false_alarm(
        series.level == CorrectionLevel::Base ? options_.base_limits : options_.nested_limits,
        survey_.series.size());
    // A panel that is meant to lie turned is as good as one that is not.
    plan.limits.turned_deg = 0;
    plan.predicts_errors = !request_.bends_panel || series.level != CorrectionLevel::Base;
    for (const std::size_t i : series.points) {
      plan.targets.push_back(target_place(survey_.measurements[i]));
    }
    std::vector<Place> places;
    for (const PlannedPlace& target : plan.targets) places.push_back(target.nominal);
    plan.hull = convex_hull(places);
    plan.base_cov = designs_.base_cov(s);
    work.predict_models();
    work.predict_errors();
    Glance& glance = glances_[s];
    for (const PlannedPlace& target : plan.targets) glance.grow(target.nominal);
    if (series.level == CorrectionLevel::Base) {
      for (const PlannedPlace& target : designs_.nested_targets(s)) glance.grow(target.nominal);
    }
    work.pool.emplace(position_mm<frame::Nominal>(glance.low_mm),
                      position_mm<frame::Nominal>(glance.high_mm));
    works_.push_back(std::move(work));
  }

  /// Second walk: everything about the chosen series.
  void look() {
    std::map<std::size_t, SeriesWork*> by_series;
    for (SeriesWork& work : works_) by_series[work.plan.i_series] = &work;
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
    for (SeriesWork& work : works_) {
      if (work.plan.level == CorrectionLevel::Base) {
        const auto targets = designs_.nested_targets(work.plan.i_series);
        work.plan.serves_targets = work.plan.n_places == 0 && !targets.empty();
        for (const PlannedPlace& target : targets) {
          if (work.plan.serves_targets) work.see(passing(target));
          work.pool->add(target);
        }
      }
      work.plan.candidates = work.pool->candidates();
      work.plan.is_thinned = work.pool->is_thinned();
      work.plan.places_hull = work.corners.corners();
      predict_choice(work);
    }
  }

  /// One target is an offset whatever the machine's file says.
  void predict_choice(SeriesWork& work) const {
    SeriesPlan& plan = work.plan;
    if (!request_.chooses_model || plan.design.size() < 2 || plan.n_places == 0) return;
    plan.chosen = chosen_range({.targets = plan.design,
                                .usual = plan.programmed,
                                .base_cov = plan.base_cov,
                                .corners = plan.places_hull});
  }

  /// Third walk: every place as it would be with further targets.
  void look_at_additions() {
    struct Watched {
      AdditionPlan* addition;
      LeverageMap leverage;
    };
    std::map<std::size_t, std::vector<Watched>> by_series;
    for (SeriesWork& work : works_) {
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
    for (const SeriesWork& work : works_) {
      if (!work.plan.serves_targets) continue;
      for (const PlannedPlace& target : designs_.nested_targets(work.plan.i_series)) {
        see(work.plan.i_series, passing(target));
      }
    }
  }

  const Program& program_;
  const WalkOptions& options_;
  const Survey& survey_;
  std::span<const PanelModel> programmed_;
  const PlanRequest& request_;
  SeriesDesigns designs_;
  ModelRule rule_;
  Plan plan_;
  std::vector<Glance> glances_;
  std::vector<SeriesWork> works_;
};

}  // namespace

Plan make_plan(const Program& program,
               const WalkOptions& options,
               const Survey& survey,
               std::span<const PanelModel> programmed,
               const PlanRequest& request) {
  return Planner(program, options, survey, programmed, request).make();
}

}  // namespace panelcal::plan
