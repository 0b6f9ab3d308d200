// SPDX-License-Identifier: Apache-2.0
#include "vision/locate/locate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <type_traits>

#include "machine/sim/pictures/sample_pictures.h"
#include "python/bindings/convert.h"
#include "python/bindings/machine.h"
#include "python/bindings/pictures.h"
#include "tools/locate/located_json.h"
#include "tools/locate/search.h"
#include <fmt/format.h>
#include <pybind11/stl.h>

namespace panelcal::python {
namespace {

constexpr const char* kLocate = "locate";

/// A limit of LocateOptions by its name in Python.
struct LocateLimit {
  std::string_view name;
  double LocateOptions::*value;
};
constexpr std::array<LocateLimit, 9> kLimits = {{
    {"ambiguity_margin", &LocateOptions::ambiguity_margin},
    {"min_contrast", &LocateOptions::min_contrast},
    {"min_score", &LocateOptions::min_score},
    {"min_visible", &LocateOptions::min_visible},
    {"max_blur_px", &LocateOptions::max_blur_px},
    {"max_clipped", &LocateOptions::max_clipped},
    {"max_oval", &LocateOptions::max_oval},
    {"max_roughness", &LocateOptions::max_roughness},
    {"max_lobes", &LocateOptions::max_lobes},
}};

void take_limits(const py::dict& limits, LocateOptions& options) {
  std::vector<std::string_view> names;
  for (const LocateLimit& limit : kLimits) names.push_back(limit.name);
  for (const auto& [key, value] : limits) {
    const auto name = key.cast<std::string>();
    const auto limit = std::ranges::find(kLimits, name, &LocateLimit::name);
    if (limit == kLimits.end()) {
      const std::string_view nearest = nearest_word(name, names);
      raise_usage(kLocate,
                  "unknown keyword " + quoted(name),
                  nearest.empty() ? "a limit of panelcal.locate" : std::string(nearest));
    }
    options.*limit->value = value.cast<double>();
  }
  value_of(options.validate());
}

/// The search that the arguments name: of a machine's vision tool, or of a target alone.
TargetSearch search_of(py::handle target,
                       const Machine* machine,
                       const CameraMapping* mapping,
                       const std::optional<std::pair<double, double>>& center_px,
                       std::optional<double> radius_px,
                       const py::dict& limits) {
  TargetSearch search;
  if (py::isinstance<Target>(target)) {
    search.target = target.cast<const Target&>();
    if (machine != nullptr) {
      search.options = machine->config->locate;
      search.form = machine->config->picture_form;
      if (machine->config->camera && search.target.size) {
        search.mapping = machine->config->camera->mapping();
        search.width_px = machine->config->camera->picture_width_px;
        search.height_px = machine->config->camera->picture_height_px;
      }
    }
  } else if (machine != nullptr) {
    search = value_of(target_search(*machine->config, target.cast<int>()));
  } else {
    raise_usage(kLocate, "a target that is no panelcal.Target", "a Target, or machine as well");
  }
  if (mapping != nullptr) {
    if (search.mapping) {
      raise_usage(kLocate, "mapping, and a machine with a [camera]", "one of the two");
    }
    // Without a size in mm the target is looked for in the picture itself.
    if (search.target.size) search.mapping = *mapping;
  }
  if (center_px.has_value() != radius_px.has_value()) {
    raise_usage(kLocate, "one of search_center_px and search_radius_px", "both, or none");
  }
  if (center_px) {
    if (!std::isfinite(center_px->first) || !std::isfinite(center_px->second) ||
        !(*radius_px >= 1) || !std::isfinite(*radius_px)) {
      raise_usage(kLocate, "no place to search", "finite numbers, and a radius of at least 1 px");
    }
    search.options.search_center = position_px(center_px->first, center_px->second);
    search.options.search_radius = px(*radius_px);
  }
  if (!limits.empty()) take_limits(limits, search.options);
  return search;
}

std::shared_ptr<Detection> locate_in(const Image& image, const TargetSearch& search) {
  const py::gil_scoped_release release;
  const CameraMapping* const mapping = search.mapping ? &*search.mapping : nullptr;
  if (mapping != nullptr && search.width_px > 0) {
    value_of(check_picture_size("panelcal.locate", image, search));
  }
  const auto look = [&](const Image& understood_image) {
    return std::make_shared<Detection>(
        locate(understood_image, search.target, mapping, search.options));
  };
  // Only a mosaic, or levels of fewer bits, have to be made another picture first.
  const bool is_plain = !search.form.bayer && !search.form.bits;
  return is_plain ? look(image) : look(understood(image, search.form));
}

template <class Value>
py::object number_or_none(const std::optional<Value>& value, double (Value::*in_unit)() const) {
  return value ? py::object(py::float_(((*value).*in_unit)())) : py::object(py::none());
}

/// A property of the fit: None where nothing was fitted.
template <class Get>
auto of_fit(Get get) {
  return [get](const Detection& self) -> py::object {
    if (!self.best) return py::none();
    auto value = get(*self.best);
    if constexpr (std::is_base_of_v<py::object, decltype(value)>) {
      return value;
    } else {
      return py::cast(value);
    }
  };
}

py::array corners_px(const TargetFit& fit) {
  std::vector<double> out;
  for (const auto& corner : fit.corners) {
    out.insert(out.end(), {corner.position.in_px().x(), corner.position.in_px().y()});
  }
  return array_of(std::move(out), {2});
}

std::string represent(const Detection& self) {
  if (self.status != DetectionStatus::Found) {
    return fmt::format("<panelcal.Detection {}: {}>", name(self.status), self.reason);
  }
  const Eigen::Vector2d& at = self.best->center.position.in_px();
  return fmt::format("<panelcal.Detection found at ({:.3f}, {:.3f}) px>", at.x(), at.y());
}

py::dict truth_of(const SampleTruth& truth) {
  py::dict out;
  out["center_px"] = matrix_of(truth.center_px);
  out["center_mm"] = truth.center_mm ? py::object(matrix_of(*truth.center_mm)) : py::none();
  out["angle_rad"] = truth.angle.in_rad();
  out["visible"] = truth.visible;
  out["n_neighbors"] = truth.n_neighbors;
  return out;
}

void bind_detection(py::module_& module) {
  py::class_<Detection, std::shared_ptr<Detection>>(module, "Detection", R"(
The answer to "where is the target in this picture?".

Without a fitted candidate each property of the target is None. Test `found`
before you use one: a candidate that is rejected or ambiguous has them, too.

Attributes
----------
found : bool
status : str
    found, not_found, ambiguous or rejected.
reason : str
    Empty if found.
center_px, cov_px2 : ndarray, shape (2,), (2, 2)
    The target's place in the picture, and the covariance of its error.
center_mm, cov_mm2 : ndarray, shape (2,), (2, 2)
    The same from the optical axis, in machine directions; None without a mapping.
size_px, size_mm, inner_size_px : float
    As `Target` means them.
angle_rad, angle_sigma_rad : float
score : float
    0 to 1: correlation of picture and model.
blur_px, noise, contrast, background : float
    Sigma of the edge, px; sigma of the residuals, and levels, grey levels.
visible, excluded : float
    Parts of the rim that is seen, and of the window that is left out.
axis_ratio : float
    Least over largest diameter of a round target.
hole_offset_px : ndarray, shape (2,)
    Of a ring: middle of its hole minus its own.
tag_id : int
corners_px : ndarray, shape (n, 2)
    Of a tag.
n_candidates : int
size_ratio : float
    The size that was seen over the one that was asked for.

Notes
-----
Immutable: threads may share it.)")
      .def_property_readonly(
          "found", [](const Detection& self) { return self.status == DetectionStatus::Found; })
      .def_property_readonly("status", [](const Detection& self) { return name(self.status); })
      .def_property_readonly("reason", [](const Detection& self) { return text(self.reason); })
      .def_property_readonly("n_candidates",
                             [](const Detection& self) { return self.n_candidates; })
      .def_property_readonly("size_ratio", [](const Detection& self) { return self.size_ratio; })
      .def_property_readonly("center_px", of_fit([](const TargetFit& fit) {
                               return matrix_of(fit.center.position.in_px());
                             }))
      .def_property_readonly("cov_px2",
                             of_fit([](const TargetFit& fit) { return matrix_of(fit.center.cov); }))
      .def_property_readonly(
          "center_mm", of_fit([](const TargetFit& fit) {
            return fit.center_optical ? py::object(matrix_of(fit.center_optical->position.in_mm()))
                                      : py::object(py::none());
          }))
      .def_property_readonly("cov_mm2", of_fit([](const TargetFit& fit) {
                               return fit.center_optical
                                          ? py::object(matrix_of(fit.center_optical->cov))
                                          : py::object(py::none());
                             }))
      .def_property_readonly("size_px",
                             of_fit([](const TargetFit& fit) { return fit.size.in_px(); }))
      .def_property_readonly("size_mm", of_fit([](const TargetFit& fit) {
                               return number_or_none(fit.size_mm, &Length::in_mm);
                             }))
      .def_property_readonly("inner_size_px", of_fit([](const TargetFit& fit) {
                               return number_or_none(fit.inner_size, &PixelLength::in_px);
                             }))
      .def_property_readonly("angle_rad",
                             of_fit([](const TargetFit& fit) { return fit.angle.in_rad(); }))
      .def_property_readonly("angle_sigma_rad",
                             of_fit([](const TargetFit& fit) { return fit.angle_sigma.in_rad(); }))
      .def_property_readonly("score", of_fit([](const TargetFit& fit) { return fit.score; }))
      .def_property_readonly("blur_px", of_fit([](const TargetFit& fit) { return fit.blur_px; }))
      .def_property_readonly("noise", of_fit([](const TargetFit& fit) { return fit.noise; }))
      .def_property_readonly("contrast", of_fit([](const TargetFit& fit) { return fit.contrast; }))
      .def_property_readonly("background",
                             of_fit([](const TargetFit& fit) { return fit.background; }))
      .def_property_readonly("visible", of_fit([](const TargetFit& fit) { return fit.visible; }))
      .def_property_readonly("excluded", of_fit([](const TargetFit& fit) { return fit.excluded; }))
      .def_property_readonly("axis_ratio",
                             of_fit([](const TargetFit& fit) { return fit.axis_ratio; }))
      .def_property_readonly("hole_offset_px", of_fit([](const TargetFit& fit) {
                               return matrix_of(fit.hole_offset_px);
                             }))
      .def_property_readonly("tag_id", of_fit([](const TargetFit& fit) { return fit.tag_id; }))
      .def_property_readonly("corners_px", of_fit(corners_px))
      .def(
          "_row",
          [](const Detection& self, const std::string& image, int tool, bool lists_candidates) {
            return text(located_row({image, tool, lists_candidates}, self).dump());
          },
          py::arg("image"),
          py::arg("tool"),
          py::arg("candidates"))
      .def("__repr__", &represent);
}

}  // namespace

void bind_locate(py::module_& module) {
  bind_detection(module);
  module.def(
      "locate",
      [](const py::object& image,
         const py::object& target,
         const Machine* machine,
         const CameraMapping* mapping,
         const std::optional<std::pair<double, double>>& center_px,
         std::optional<double> radius_px,
         std::optional<double> full_scale,
         const py::dict& limits) {
        const TargetSearch search =
            search_of(target, machine, mapping, center_px, radius_px, limits);
        if (py::isinstance<Image>(image)) return locate_in(image.cast<const Image&>(), search);
        return locate_in(image_of(image.cast<py::array>(), full_scale), search);
      },
      py::arg("image"),
      py::arg("target"),
      py::arg("machine").none(true),
      py::arg("mapping").none(true),
      py::arg("search_center_px"),
      py::arg("search_radius_px"),
      py::arg("full_scale"),
      py::arg("limits"));

  py::class_<SampleRenderer>(module, "Samples", R"(
Pictures of one vision tool's target whose truth is known: `panelcal synth --tool`.

``Samples(machine, tool, seed=None)`` renders as ``[sim]`` of machine.toml
describes camera, light, board, neighbours and debris. Calling it with a number
gives that picture: the same one for ever.

Parameters
----------
machine : Machine
tool : int
seed : int, optional
    In place of that of ``[sim]``.

Notes
-----
Immutable: threads may share it.)")
      .def(py::init([](const Machine& machine, int tool, std::optional<std::uint64_t> seed) {
             MachineConfig config = *machine.config;
             if (seed && config.sim) config.sim->seed = *seed;
             return value_of(SampleRenderer::create(config, tool));
           }),
           py::arg("machine"),
           py::arg("tool"),
           py::arg("seed") = py::none())
      .def(
          "__call__",
          [](const SampleRenderer& self, int i) {
            if (i < 0) raise_usage("Samples", fmt::format("picture {}", i), "0 or more");
            Sample sample = [&] {
              const py::gil_scoped_release release;
              return self.draw(i);
            }();
            return py::make_tuple(std::make_shared<Image>(std::move(sample.image)),
                                  truth_of(sample.truth));
          },
          py::arg("i"),
          R"(Renders picture number i.

Returns
-------
image : Image
truth : dict
    center_px (2,), center_mm (2,) or None, angle_rad, visible, n_neighbors.)");
}

}  // namespace panelcal::python
