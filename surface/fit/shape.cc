// SPDX-License-Identifier: Apache-2.0
#include "surface/fit/shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace panelcal {
namespace {

/// In the order of the enumerators.
constexpr std::array<std::string_view, 5> kModels = {
    "plane", "thin-plate", "gaussian-process", "bilinear", "monotone-bicubic"};
constexpr std::array<std::string_view, 6> kKernels = {
    "none", "thin-plate", "matern-3/2", "matern-5/2", "gaussian", "matern-1/2"};

/// The most that lengths and heights of a panel can be; beyond it lies a wrong unit.
constexpr double kMostLength_mm = 1e6;
constexpr double kMostStrength_mm2 = 1e18;

template <class Enum, std::size_t kN>
std::optional<Enum> of_word(const std::array<std::string_view, kN>& words, std::string_view word) {
  const auto found = std::ranges::find(words, word);
  if (found == words.end()) return std::nullopt;
  return static_cast<Enum>(found - words.begin());
}

}  // namespace

Expected<void> SurfaceShape::validate(SurfaceModel model) const {
  const auto bad = [](std::string what, const char* expected) {
    return failure({Code::ConfigValue, {}, std::move(what), expected});
  };
  const bool is_plate = kernel == BendingKernel::ThinPlate;
  const bool is_flat = kernel == BendingKernel::None;
  const bool is_grid = is_of_grid(model);
  if (is_plate != (model == SurfaceModel::ThinPlate) ||
      is_flat != (model == SurfaceModel::Plane || is_grid)) {
    return bad(fmt::format("the kernel {} is not one of a {}", word(kernel), word(model)),
               "the model's own");
  }
  const double length_mm = length.in_mm();
  if (is_flat ? length_mm != 0 : !(length_mm > 0 && length_mm <= kMostLength_mm)) {
    return bad(fmt::format("the bending's length is {} mm", length_mm),
               is_flat ? "0 if nothing bends" : "above 0, at most a kilometre");
  }
  if (!(strength_mm2 >= 0 && strength_mm2 <= kMostStrength_mm2) || (is_flat && strength_mm2 != 0)) {
    return bad(fmt::format("the bending's strength is {} mm^2", strength_mm2),
               is_flat ? "0 if nothing bends" : "0 or more");
  }
  if (!(noise_factor > 0 && std::isfinite(noise_factor))) {
    return bad(fmt::format("the noise factor is {}", noise_factor), "above 0");
  }
  const double unresolved_mm = unresolved.in_mm();
  if (!(unresolved_mm >= 0 && unresolved_mm <= kMostLength_mm) || (is_grid && unresolved_mm != 0)) {
    return bad(fmt::format("the unresolved bending is {} mm", unresolved_mm), "0 or more");
  }
  const bool bows = model == SurfaceModel::GaussianProcess && n_trend == kBowTrend;
  if (n_trend == (is_grid ? 0 : kPlaneTrend) || bows) return {};
  return bad(fmt::format("the trend has {} coefficients", n_trend),
             "3, or 6 of a Gaussian process, or 0 of a grid model");
}

Expected<void> check_shares(std::span<const ShapeShare> shapes, SurfaceModel model) {
  constexpr std::size_t kMostShares = 100;
  constexpr double kSumRounding = 1e-9;
  const auto bad = [](std::string what, const char* expected) {
    return failure({Code::ConfigValue, {}, std::move(what), expected});
  };
  const std::size_t most = model == SurfaceModel::GaussianProcess ? kMostShares : 1;
  if (shapes.empty() || shapes.size() > most) {
    return bad(fmt::format("{} shapes of a {}", shapes.size(), word(model)),
               most == 1 ? "1" : "1 to 100");
  }
  double sum = 0;
  for (const auto& [shape, weight] : shapes) {
    PANELCAL_CHECK(shape.validate(model));
    if (shape.n_trend != shapes.front().shape.n_trend ||
        shape.unresolved != shapes.front().shape.unresolved) {
      return bad("shapes of different trends or unresolved bendings", "the same of all");
    }
    if (!(weight > 0)) return bad(fmt::format("the weight of a shape is {}", weight), "above 0");
    sum += weight;
  }
  if (std::abs(sum - 1) <= kSumRounding) return {};
  return bad(fmt::format("the weights of the shapes add up to {}", sum), "1");
}

std::string_view word(SurfaceModel model) {
  return kModels[static_cast<std::size_t>(model)];
}

std::optional<SurfaceModel> surface_model(std::string_view word) {
  return of_word<SurfaceModel>(kModels, word);
}

std::span<const std::string_view> surface_model_words() {
  return kModels;
}

std::string_view word(BendingKernel kernel) {
  return kKernels[static_cast<std::size_t>(kernel)];
}

std::optional<BendingKernel> bending_kernel(std::string_view word) {
  return of_word<BendingKernel>(kKernels, word);
}

}  // namespace panelcal
