// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <memory>
#include <string>

#include "calib/panel/panel_fit.h"
#include "python/bindings/convert.h"
#include <fmt/format.h>
#include <pybind11/stl.h>

namespace panelcal::python {
namespace {

using Map = PanelFit<frame::Actual, frame::Nominal>;
using Pair = TargetPair<frame::Actual, frame::Nominal>;

/// A fitted panel: the map with its summary.
struct FittedPanel {
  std::shared_ptr<const Map> map;
  PanelFitSummary summary;
};

struct FailureCode {
  FitFailure failure;
  Code code;
  const char* expected;
};
constexpr std::array<FailureCode, 5> kFailureCodes = {{
    {FitFailure::TooFewTargets, Code::TargetsTooFew, "more targets, or a stiffer model"},
    {FitFailure::Degenerate, Code::SeriesDegenerate, "targets apart, or a stiffer model"},
    {FitFailure::BadCovariance,
     Code::MeasurementInvalid,
     "finite numbers, and covariances that are positive definite"},
    {FitFailure::Mirrored, Code::PanelMirrored, "measured places of the same side of the panel"},
    {FitFailure::Folded, Code::PanelFolded, "another model, or larger sigmas"},
}};

PanelFitOptions options_of(const std::string& model) {
  PanelFitOptions options;
  options.limits = default_gate_limits();
  if (model == "auto") {
    options.chooses_model = true;
    options.smooth = SmoothModels::Eligible;
  } else if (model == "smooth") {
    options.bends = true;
  } else if (const auto known = panel_model_from_name(model)) {
    options.model = *known;
  } else {
    raise_usage("fit_panel",
                "model = " + quoted(model),
                "auto, offset, rigid, similarity, stretch, affine or smooth");
  }
  return options;
}

FittedPanel fit(const Doubles& nominal_mm,
                const Doubles& measured_mm,
                const Doubles& covariance,
                const std::string& model) {
  const std::vector<Eigen::Vector2d> nominal = points_of(nominal_mm, "nominal_mm");
  const std::vector<Eigen::Vector2d> measured = points_of(measured_mm, "measured_mm");
  if (nominal.size() != measured.size()) {
    raise_usage("fit_panel",
                fmt::format("{} nominal places, {} measured ones", nominal.size(), measured.size()),
                "as many of the one as of the other");
  }
  const std::vector<Eigen::Matrix2d> cov = covariances_of(covariance, nominal.size(), "cov_mm2");
  PanelFitOptions options = options_of(model);
  const py::gil_scoped_release release;
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < nominal.size(); ++i) {
    pairs.push_back({position_mm<frame::Nominal>(nominal[i]),
                     {position_mm<frame::Actual>(measured[i]), cov[i]}});
  }
  // Where the targets do not speak for another model, the manual's for their number.
  if (options.chooses_model) options.model = default_model(static_cast<int>(pairs.size()));
  FittedPanel out;
  out.map = fit_panel(options, std::span<const Pair>(pairs), out.summary);
  if (out.map) return out;
  const auto why = std::ranges::find(kFailureCodes, *out.summary.failure, &FailureCode::failure);
  raise({why->code, {"panelcal.fit_panel", 0, 0}, "", why->expected});
}

py::tuple apply(const FittedPanel& self, const Doubles& nominal_mm) {
  const std::vector<Eigen::Vector2d> nominal = points_of(nominal_mm, "nominal_mm");
  std::vector<double> places, covariances;
  {
    const py::gil_scoped_release release;
    for (const Eigen::Vector2d& point : nominal) {
      const auto from = position_mm<frame::Nominal>(point);
      const auto& smooth = self.map->smooth;
      const PositionEstimate<frame::Actual> to =
          smooth ? PositionEstimate<frame::Actual>{smooth->map(from), smooth->covariance(from)}
                 : self.map->map(from);
      places.insert(places.end(), {to.position.in_mm().x(), to.position.in_mm().y()});
      covariances.insert(covariances.end(),
                         {to.cov(0, 0), to.cov(0, 1), to.cov(1, 0), to.cov(1, 1)});
    }
  }
  return py::make_tuple(array_of(std::move(places), {2}), array_of(std::move(covariances), {2, 2}));
}

py::list gates_of(const FittedPanel& self) {
  py::list out;
  for (const GateVerdict& gate : self.summary.gates) {
    py::dict row;
    row["gate"] = gate.gate;
    row["value"] = gate.value;
    row["limit"] = gate.limit;
    row["unit"] = gate.unit;
    row["accepted"] = gate.accepted;
    row["text"] = text(gate.text());
    out.append(row);
  }
  return out;
}

template <auto member>
py::tuple uncertain(const FittedPanel& self) {
  const Uncertain& of = self.summary.*member;
  return py::make_tuple(of.value, of.sigma);
}

}  // namespace

void bind_panel(py::module_& module) {
  py::class_<FittedPanel, std::shared_ptr<FittedPanel>>(module, "PanelFit", R"(
How a panel lies and how it has stretched; `fit_panel` makes one.

Calling it with nominal places, shape (n, 2), gives where they are on the
machine, shape (n, 2), and the covariances of these places, shape (n, 2, 2), in
mm and mm^2.

Attributes
----------
model : str
    offset, rigid, similarity, stretch or affine; of a smooth fit its affine part.
is_smooth : bool
matrix, shift_mm : ndarray, shape (2, 2), (2,)
    ``actual = matrix @ nominal + shift``; of a smooth fit the map nearest to it.
cov : ndarray, shape (6, 6)
    Of [m00, m01, m10, m11, shift x, shift y].
rotation_rad, stretch_x_ppm, stretch_y_ppm, shear_ppm : (float, float)
    Value and standard deviation.
residuals_mm : ndarray, shape (n, 2)
    Measured minus fitted.
chi_square : float
degrees_of_freedom : int
misfit_ratio : float
    By which sigma has grown, since the targets do not agree.
gates : list of dict
    The default limits of a job against this fit: gate, value, limit,
    unit, accepted, text.

Notes
-----
Immutable: threads may share it.)")
      .def("__call__", &apply, py::arg("nominal_mm"))
      .def_property_readonly("model",
                             [](const FittedPanel& self) { return name(self.summary.model); })
      .def_property_readonly("is_smooth",
                             [](const FittedPanel& self) { return self.summary.is_smooth(); })
      .def_property_readonly("matrix",
                             [](const FittedPanel& self) { return matrix_of(self.summary.linear); })
      .def_property_readonly(
          "shift_mm",
          [](const FittedPanel& self) { return matrix_of(self.summary.translation_mm); })
      .def_property_readonly("cov",
                             [](const FittedPanel& self) { return matrix_of(self.summary.cov); })
      .def_property_readonly("rotation_rad", &uncertain<&PanelFitSummary::rotation_rad>)
      .def_property_readonly("stretch_x_ppm", &uncertain<&PanelFitSummary::stretch_x_ppm>)
      .def_property_readonly("stretch_y_ppm", &uncertain<&PanelFitSummary::stretch_y_ppm>)
      .def_property_readonly("shear_ppm", &uncertain<&PanelFitSummary::shear_ppm>)
      .def_property_readonly("residuals_mm",
                             [](const FittedPanel& self) {
                               std::vector<double> out;
                               for (const Eigen::Vector2d& one : self.summary.residuals_mm) {
                                 out.insert(out.end(), {one.x(), one.y()});
                               }
                               return array_of(std::move(out), {2});
                             })
      .def_property_readonly("chi_square",
                             [](const FittedPanel& self) { return self.summary.chi_square; })
      .def_property_readonly(
          "degrees_of_freedom",
          [](const FittedPanel& self) { return self.summary.degrees_of_freedom; })
      .def_property_readonly("misfit_ratio",
                             [](const FittedPanel& self) { return self.summary.misfit_ratio; })
      .def_property_readonly("gates", &gates_of)
      .def("__repr__", [](const FittedPanel& self) {
        return "<panelcal.PanelFit " + self.summary.model_text() + ": " + self.summary.brief() +
               ">";
      });
  module.def(
      "fit_panel",
      [](const Doubles& nominal_mm,
         const Doubles& measured_mm,
         const Doubles& covariance,
         const std::string& model) {
        return std::make_shared<FittedPanel>(fit(nominal_mm, measured_mm, covariance, model));
      },
      py::arg("nominal_mm"),
      py::arg("measured_mm"),
      py::arg("covariance"),
      py::arg("model"));
}

}  // namespace panelcal::python
