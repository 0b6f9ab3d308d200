// SPDX-License-Identifier: Apache-2.0
#include "calib/panel/model.h"

#include <array>
#include <cmath>
#include <numbers>

namespace panelcal {
namespace {

struct ModelInfo {
  PanelModel model;
  std::string_view name;
  int n_parameters;
};

constexpr std::array kModels = {
    ModelInfo{PanelModel::Offset, "offset", 2},
    ModelInfo{PanelModel::Rigid, "rigid", 3},
    ModelInfo{PanelModel::Similarity, "similarity", 4},
    ModelInfo{PanelModel::Stretch, "stretch", 5},
    ModelInfo{PanelModel::Affine, "affine", 6},
};

const ModelInfo& info(PanelModel model) {
  return kModels[static_cast<std::size_t>(model)];
}

}  // namespace

int parameter_count(PanelModel model) {
  return info(model).n_parameters;
}

std::string_view name(PanelModel model) {
  return info(model).name;
}

std::optional<PanelModel> panel_model_from_name(std::string_view name) {
  for (const ModelInfo& known : kModels) {
    if (known.name == name) return known.model;
  }
  return std::nullopt;
}

PanelModel default_model(int n_points) {
  if (n_points <= 1) return PanelModel::Offset;
  return n_points == 2 ? PanelModel::Rigid : PanelModel::Stretch;
}

PanelModel default_model_of_equations(int n_equations, bool with_scale) {
  if (n_equations < 3) return PanelModel::Offset;
  if (n_equations >= 6) return PanelModel::Stretch;
  const bool can_scale = n_equations >= parameter_count(PanelModel::Similarity);
  return with_scale && can_scale ? PanelModel::Similarity : PanelModel::Rigid;
}

PanelModel model_at_most(PanelModel wanted, int n_equations, bool with_scale) {
  const bool is_short = n_equations < parameter_count(PanelModel::Stretch);
  if (wanted != PanelModel::Stretch || !is_short) return wanted;
  return default_model_of_equations(n_equations, with_scale);
}

PanelDeformation deformation_of(const Eigen::Matrix2d& linear) {
  PanelDeformation d;
  d.scale_x = std::hypot(linear(0, 0), linear(1, 0));
  if (d.scale_x == 0) {
    // A panel squeezed to a line keeps the direction of its y axis.
    d.scale_y = std::hypot(linear(0, 1), linear(1, 1));
    d.rotation_rad = std::atan2(-linear(0, 1), linear(1, 1));
    return d;
  }
  d.rotation_rad = std::atan2(linear(1, 0), linear(0, 0));
  d.scale_y = (linear(0, 0) * linear(1, 1) - linear(0, 1) * linear(1, 0)) / d.scale_x;
  d.shear = (linear(0, 0) * linear(0, 1) + linear(1, 0) * linear(1, 1)) / d.scale_x;
  return d;
}

namespace internal {

Coefficients coefficients(PanelModel model, const ModelParameters& p) {
  Coefficients a;
  switch (model) {
    case PanelModel::Offset:
      a << 1, 0, 0, 1, p[0], p[1];
      break;
    case PanelModel::Rigid: {
      const double c = std::cos(p[0]);
      const double s = std::sin(p[0]);
      a << c, -s, s, c, p[1], p[2];
      break;
    }
    case PanelModel::Similarity:
      a << p[0], -p[1], p[1], p[0], p[2], p[3];
      break;
    case PanelModel::Stretch: {
      const double c = std::cos(p[0]);
      const double s = std::sin(p[0]);
      a << c * p[1], -s * p[2], s * p[1], c * p[2], p[3], p[4];
      break;
    }
    case PanelModel::Affine:
      a = p;
      break;
  }
  return a;
}

ModelJacobian coefficient_jacobian(PanelModel model, const ModelParameters& p) {
  const int n = parameter_count(model);
  ModelJacobian j = ModelJacobian::Zero(6, n);
  j(4, n - 2) = 1;
  j(5, n - 1) = 1;
  switch (model) {
    case PanelModel::Offset:
      break;
    case PanelModel::Rigid: {
      const double c = std::cos(p[0]);
      const double s = std::sin(p[0]);
      j.col(0) << -s, -c, c, -s, 0, 0;
      break;
    }
    case PanelModel::Similarity:
      j.col(0) << 1, 0, 0, 1, 0, 0;
      j.col(1) << 0, -1, 1, 0, 0, 0;
      break;
    case PanelModel::Stretch: {
      const double c = std::cos(p[0]);
      const double s = std::sin(p[0]);
      j.col(0) << -s * p[1], -c * p[2], c * p[1], -s * p[2], 0, 0;
      j.col(1) << c, 0, s, 0, 0, 0;
      j.col(2) << 0, -s, 0, c, 0, 0;
      break;
    }
    case PanelModel::Affine:
      j.setIdentity(6, 6);
      break;
  }
  return j;
}

ModelHessian coefficient_curvature(PanelModel model,
                                   const ModelParameters& p,
                                   const Coefficients& w) {
  const int n = parameter_count(model);
  ModelHessian h = ModelHessian::Zero(n, n);
  if (is_linear(model)) return h;
  const double c = std::cos(p[0]);
  const double s = std::sin(p[0]);
  // Columns of the linear part, weighted: along the first it is (c, s) sx, along the second
  // (-s, c) sy; a derivative by theta turns each by a quarter.
  const double along_x = w[0] * c + w[2] * s;
  const double along_y = -w[1] * s + w[3] * c;
  if (model == PanelModel::Rigid) {
    h(0, 0) = -along_x - along_y;
    return h;
  }
  h(0, 0) = -along_x * p[1] - along_y * p[2];
  h(0, 1) = h(1, 0) = -w[0] * s + w[2] * c;
  h(0, 2) = h(2, 0) = -w[1] * c - w[3] * s;
  return h;
}

bool is_linear(PanelModel model) {
  return model != PanelModel::Rigid && model != PanelModel::Stretch;
}

PanelModel start_model(PanelModel model) {
  if (model == PanelModel::Rigid) return PanelModel::Similarity;
  if (model == PanelModel::Stretch) return PanelModel::Affine;
  return model;
}

ModelParameters start_parameters(PanelModel model, const Coefficients& a) {
  ModelParameters p(parameter_count(model));
  if (model == PanelModel::Rigid) {
    p << std::atan2(a[2], a[0]), a[4], a[5];
    return p;
  }
  // With the columns as complex numbers u and v, |Re(u e^-it)|^2 + |Im(v e^-it)|^2 is largest at
  // 2t = arg(u^2 - v^2); of the two solutions the one with sx > 0.
  const double re = (a[0] * a[0] - a[2] * a[2]) - (a[1] * a[1] - a[3] * a[3]);
  const double im = 2 * (a[0] * a[2] - a[1] * a[3]);
  double theta_rad = 0.5 * std::atan2(im, re);
  if (a[0] * std::cos(theta_rad) + a[2] * std::sin(theta_rad) < 0) {
    theta_rad += theta_rad > 0 ? -std::numbers::pi : std::numbers::pi;
  }
  const double c = std::cos(theta_rad);
  const double s = std::sin(theta_rad);
  p << theta_rad, a[0] * c + a[2] * s, -a[1] * s + a[3] * c, a[4], a[5];
  return p;
}

}  // namespace internal
}  // namespace panelcal
