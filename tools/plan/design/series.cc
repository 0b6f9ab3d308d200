// SPDX-License-Identifier: Apache-2.0
#include "tools/plan/design/series.h"

#include <algorithm>
#include <array>

namespace panelcal::plan {
namespace {

constexpr std::array kModels = {PanelModel::Offset,
                                PanelModel::Rigid,
                                PanelModel::Similarity,
                                PanelModel::Stretch,
                                PanelModel::Affine};
/// Outside of the hull begins a nanometre beyond it: copies are rounded.
constexpr double kOnHull_mm = 1e-6;
/// Places that a picture shows of one series.
constexpr std::size_t kSample = 6000;

}  // namespace

void Sample::add(const Position<frame::Nominal>& place) {
  if (n_++ % stride_ != 0) return;
  if (places_.size() == kSample) {
    for (std::size_t i = 0; 2 * i < kSample; ++i) places_[i] = places_[2 * i];
    places_.resize(kSample / 2);
    stride_ *= 2;
    if ((n_ - 1) % stride_ != 0) return;
  }
  places_.push_back(place);
}

void SeriesWork::predict_models() {
  for (const PanelModel model : kModels) {
    const auto result = predict_fit(plan.design, model, base_cov);
    ModelPlan one;
    one.model = model;
    one.is_programmed = model == plan.programmed;
    one.fit = result.fit;
    one.failure = result.failure;
    if (result.fit) {
      one.lies = weakest(detect_lies(plan.design, *result.fit));
      leverages.emplace_back(result.fit->cov);
      i_models.push_back(plan.models.size());
    }
    plan.models.push_back(std::move(one));
  }
}

void SeriesWork::see(const PassingPlace& place) {
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

}  // namespace panelcal::plan
