// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>

#include "calib/base/statistics/random.h"
#include "python/bindings/convert.h"
#include "python/bindings/pictures.h"
#include "vision/fit/target.h"
#include "vision/render/render.h"
#include "vision/render/scene_marks.h"
#include <fmt/format.h>
#include <pybind11/stl.h>

namespace panelcal::python {
namespace {

using OptionalDouble = std::optional<double>;

[[noreturn]] void raise_target(std::string what, std::string expected) {
  raise_usage("Target", std::move(what), std::move(expected));
}

template <class Value>
Value word_of(py::handle word,
              std::optional<Value> (*from_name)(std::string_view),
              std::string_view key,
              std::string expected) {
  const auto text = word.cast<std::string>();
  if (const auto value = from_name(text)) return *value;
  raise_target(fmt::format("{} = {}", key, quoted(text)), std::move(expected));
}

/// A keyword argument: a key of [[vision.tool]] in machine.toml.
struct TargetKey {
  std::string_view name;
  void (*set)(Target& target, py::handle value);
};

template <auto member>
void set_mm(Target& target, py::handle value) {
  target.*member = mm(value.cast<double>());
}
template <auto member>
void set_px(Target& target, py::handle value) {
  target.*member = px(value.cast<double>());
}
template <auto member>
void set_deg(Target& target, py::handle value) {
  target.*member = deg(value.cast<double>());
}
template <auto member, class Value>
void set_value(Target& target, py::handle value) {
  target.*member = value.cast<Value>();
}

void set_polarity(Target& target, py::handle value) {
  target.polarity = word_of(value, &polarity_from_name, "polarity", "bright or dark");
}
void set_dots(Target& target, py::handle value) {
  target.dots = points_of(value.cast<Doubles>(), "dots");
}
void set_picture(Target& target, py::handle value) {
  const auto& image = value.cast<const Image&>();
  const Eigen::Vector2d middle(0.5 * (image.width() - 1), 0.5 * (image.height() - 1));
  target.picture =
      std::make_shared<const TemplatePicture>(TemplatePicture{"picture", image, middle});
}
/// Precondition: behind set_picture()
void set_reference(Target& target, py::handle value) {
  if (!target.picture) raise_target("reference_px without picture", "a template's picture");
  const auto [x_px, y_px] = value.cast<std::pair<double, double>>();
  auto picture = *target.picture;
  picture.reference_px = {x_px, y_px};
  target.picture = std::make_shared<const TemplatePicture>(std::move(picture));
}

constexpr std::array<TargetKey, 16> kTargetKeys = {{
    {"number", set_value<&Target::number, int>},
    {"size_mm", set_mm<&Target::size>},
    {"size_px", set_px<&Target::size_px>},
    {"inner_mm", set_mm<&Target::inner_size>},
    {"inner_px", set_px<&Target::inner_size_px>},
    {"width_mm", set_mm<&Target::width>},
    {"width_px", set_px<&Target::width_px>},
    {"polarity", set_polarity},
    {"size_tolerance", set_value<&Target::size_tolerance, double>},
    {"angle_deg", set_deg<&Target::angle>},
    {"angle_tolerance_deg", set_deg<&Target::angle_tolerance>},
    {"dots", set_dots},
    {"picture", set_picture},
    {"reference_px", set_reference},
    {"family", set_value<&Target::tag_family, std::string>},
    {"id", set_value<&Target::tag_id, int>},
}};

/// An unknown keyword names the nearest known one.
void check_keys(const py::kwargs& keys) {
  std::vector<std::string_view> names;
  for (const TargetKey& key : kTargetKeys) names.push_back(key.name);
  for (const auto& [key, value] : keys) {
    const auto given = key.cast<std::string>();
    if (std::ranges::find(names, given) != names.end()) continue;
    const std::string_view nearest = nearest_word(given, names);
    raise_target("unknown keyword " + quoted(given),
                 nearest.empty() ? "a key of [[vision.tool]]" : std::string(nearest));
  }
}

Target make_target(const py::str& shape, const py::kwargs& keys) {
  check_keys(keys);
  Target target;
  target.shape =
      word_of(shape,
              &shape_from_name,
              "shape",
              "disc, hole, ring, square, diamond, cross, slot, dots, template or apriltag");
  if (target.shape == Shape::Hole) target.polarity = Polarity::Dark;
  target.number = 1;
  for (const TargetKey& key : kTargetKeys) {
    const py::str name(key.name.data(), key.name.size());
    if (keys.contains(name) && !keys[name].is_none()) key.set(target, keys[name]);
  }
  if (target.size.has_value() == target.size_px.has_value()) {
    raise_target("size_mm and size_px", "one of the two: mm where a camera mapping is given");
  }
  value_of(target.validate());
  return target;
}

std::string represent(const Target& target) {
  return fmt::format("<panelcal.Target {}: {} {}, {}>",
                     target.number,
                     name(target.polarity),
                     name(target.shape),
                     target.size ? fmt::format("{:g} mm", target.size->in_mm())
                                 : fmt::format("{:g} px", target.size_px->in_px()));
}

/// Picture of one target on a plain board.
struct Render {
  std::pair<int, int> size_px;
  std::pair<double, double> center_px;
  double turn_rad;
  double level;
  double ground;
  double blur_px;
  double noise;
  std::uint64_t seed;
  double full_scale;

  [[noreturn]] static void refuse(std::string what, std::string expected) {
    raise_usage("render", std::move(what), std::move(expected));
  }

  void check() const {
    constexpr int kMaxSide = 20'000;
    const auto is_side = [](int n) { return n >= 1 && n <= kMaxSide; };
    if (!is_side(size_px.first) || !is_side(size_px.second)) {
      refuse(fmt::format("a picture of {} x {} px", size_px.first, size_px.second),
             fmt::format("sides of 1 to {} px", kMaxSide));
    }
    const auto is_share = [](double share) { return share >= 0 && share <= 1; };
    if (!is_share(level) || !is_share(ground)) {
      refuse(fmt::format("level {} on ground {}", level, ground), "0 (black) to 1 (white)");
    }
    if (!(blur_px >= 0.2 && blur_px <= 100)) {
      refuse(fmt::format("blur_px = {}", blur_px), "0.2 to 100 px");
    }
    if (full_scale != Image::kFullScale8 && full_scale != Image::kFullScale16) {
      refuse(fmt::format("full_scale = {}", full_scale), "255 or 65535");
    }
    if (!(noise >= 0 && noise <= full_scale)) {
      refuse(fmt::format("noise = {}", noise), "grey levels, 0 or more");
    }
    if (!std::isfinite(center_px.first) || !std::isfinite(center_px.second) ||
        !std::isfinite(turn_rad)) {
      refuse("a place or a turn that is not finite", "finite numbers");
    }
  }

  Image draw(const Target& target, const CameraMapping* mapping) const {
    check();
    if (target.size && mapping == nullptr) {
      refuse("a target in mm without a camera mapping", "mapping, or size_px");
    }
    const CameraMapping plain({.axis_px = {0.5 * (size_px.first - 1), 0.5 * (size_px.second - 1)}});
    const CameraMapping& used = mapping != nullptr ? *mapping : plain;
    MarkLook look{.center = used(position_px(center_px.first, center_px.second)),
                  .turn = rad(turn_rad),
                  .level = level,
                  .ground = ground};
    Scene scene{.features = mark_features(target, look, used), .background = ground};
    const Camera camera{.mapping = used,
                        .width = size_px.first,
                        .height = size_px.second,
                        .blur_px = blur_px,
                        .noise = noise,
                        .full_scale = full_scale};
    Random random(seed);
    return render(scene, camera, random);
  }
};

}  // namespace

void bind_targets(py::module_& module) {
  py::class_<Target, std::shared_ptr<Target>>(module, "Target", R"(
What to look for in a picture: a vision tool.

The keyword arguments are the keys of ``[[vision.tool]]`` in machine.toml.

Parameters
----------
shape : str
    disc, hole, ring, square, diamond, cross, slot, dots, template or apriltag.
size_mm, size_px : float
    One of the two: outer diameter of a disc, hole, ring or dot; side of a square,
    diamond or tag; length of a cross's bars; width of a slot; width of a
    template's picture. In mm a target is located through a camera mapping.
number : int
    Of the vision tool.
inner_mm, inner_px : float, optional
    Diameter of a ring's hole; without it any hole is accepted.
width_mm, width_px : float, optional
    Of a cross's bars, which need it.
polarity : {'bright', 'dark'}, optional
    Against the surroundings; by default bright, holes dark.
size_tolerance : float, optional
    Largest accepted deviation of the size, relative.
angle_deg, angle_tolerance_deg : float, optional
    How the target lies, and by how much it may be turned.
dots : array_like, shape (n, 2), optional
    Middles of dots from the target's place, in mm or px as the size is.
picture : Image, optional
    Of a template.
reference_px : (float, float), optional
    The place in a template's picture that is the target's; by default its middle.
family : str
    Of a tag.
id : int, optional
    Of a tag; by default any.

Notes
-----
Immutable: threads may share it.)")
      .def(py::init([](const py::str& shape, const py::kwargs& keys) {
             return std::make_shared<Target>(make_target(shape, keys));
           }),
           py::arg("shape"))
      .def_property_readonly("number", [](const Target& self) { return self.number; })
      .def_property_readonly("shape", [](const Target& self) { return name(self.shape); })
      .def_property_readonly("polarity", [](const Target& self) { return name(self.polarity); })
      .def_property_readonly("size_mm",
                             [](const Target& self) {
                               return self.size ? OptionalDouble(self.size->in_mm()) : std::nullopt;
                             })
      .def_property_readonly("size_px",
                             [](const Target& self) {
                               return self.size_px ? OptionalDouble(self.size_px->in_px())
                                                   : std::nullopt;
                             })
      .def("__repr__", &represent);
  module.def(
      "render",
      [](const Target& target,
         std::pair<int, int> size_px,
         std::pair<double, double> center_px,
         const CameraMapping* mapping,
         double turn_rad,
         double level,
         double ground,
         double blur_px,
         double noise,
         std::uint64_t seed,
         double full_scale) {
        const Render how{
            size_px, center_px, turn_rad, level, ground, blur_px, noise, seed, full_scale};
        return std::make_shared<Image>(how.draw(target, mapping));
      },
      py::arg("target"),
      py::arg("size_px"),
      py::arg("center_px"),
      py::arg("mapping").none(true),
      py::arg("turn_rad"),
      py::arg("level"),
      py::arg("ground"),
      py::arg("blur_px"),
      py::arg("noise"),
      py::arg("seed"),
      py::arg("full_scale"),
      py::call_guard<py::gil_scoped_release>());
}

}  // namespace panelcal::python
