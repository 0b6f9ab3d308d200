// SPDX-License-Identifier: Apache-2.0
#include "python/bindings/pictures.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>

#include "vision/picture/files/image_io.h"
#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

namespace panelcal::python {
namespace {

/// Larger pictures the library does not read from files either.
constexpr py::ssize_t kMaxPixels = kMaxPicturePixels;

/// Pixels of another type, wherever their rows lie; false if one is no number from 0 to full scale.
template <class T>
bool copy_pixels(const py::buffer_info& from, Image& image) {
  const char* const first = static_cast<const char*>(from.ptr);
  for (int y = 0; y < image.height(); ++y) {
    const char* at = first + y * from.strides[0];
    for (float& level : image.row(y)) {
      T value;  // numpy's need not lie as C++ has them
      std::memcpy(&value, at, sizeof value);
      if constexpr (std::is_floating_point_v<T>) {
        if (!(value >= 0 && static_cast<double>(value) <= image.full_scale())) return false;
      }
      level = static_cast<float>(value);
      at += from.strides[1];
    }
  }
  return true;
}

using Copy = bool (*)(const py::buffer_info& from, Image& image);

/// How pixels of a type are copied, and what is white in it.
struct PixelType {
  Copy copy = nullptr;                    ///< null: no such type
  std::optional<double> full_scale = {};  ///< absent: floating point says nothing of it
};

/// By value: a type that came through pickle is another object.
PixelType pixel_type(const py::dtype& type) {
  if (type.equal(py::dtype::of<std::uint8_t>()))
    return {copy_pixels<std::uint8_t>, Image::kFullScale8};
  if (type.equal(py::dtype::of<std::uint16_t>())) {
    return {copy_pixels<std::uint16_t>, Image::kFullScale16};
  }
  if (type.equal(py::dtype::of<float>())) return {copy_pixels<float>};
  if (type.equal(py::dtype::of<double>())) return {copy_pixels<double>};
  return {};
}

[[noreturn]] void raise_image(std::string what, std::string expected) {
  raise_usage("Image", std::move(what), std::move(expected));
}

}  // namespace

Image image_of(const py::array& pixels, std::optional<double> full_scale) {
  if (pixels.ndim() != 2) {
    raise_image(fmt::format("an array of {} dimensions", pixels.ndim()),
                "two: rows and columns of grey levels");
  }
  const PixelType type = pixel_type(pixels.dtype());
  if (type.copy == nullptr) {
    raise_image("pixels of type " + std::string(py::str(pixels.dtype())),
                "uint8, uint16, float32 or float64, in this machine's byte order");
  }
  if (pixels.size() > kMaxPixels) {
    raise_image(fmt::format("{} pixels", pixels.size()), fmt::format("at most {}", kMaxPixels));
  }
  if (!full_scale) full_scale = type.full_scale;
  if (full_scale != Image::kFullScale8 && full_scale != Image::kFullScale16) {
    raise_image(full_scale ? fmt::format("full_scale = {}", *full_scale)
                           : "floating-point pixels without full_scale",
                "full_scale = 255 or 65535: the level of white");
  }
  if (type.full_scale && *type.full_scale > *full_scale) {
    raise_image("16-bit pixels with full_scale = 255", "full_scale = 65535, or 8-bit pixels");
  }
  const py::buffer_info from = pixels.request();
  const py::gil_scoped_release release;
  Image image(static_cast<int>(from.shape[1]), static_cast<int>(from.shape[0]), *full_scale);
  if (!type.copy(from, image)) {
    raise_image("a pixel is no number from 0 to full_scale", "grey levels of that range");
  }
  return image;
}

void bind_pictures(py::module_& module) {
  py::class_<Image, std::shared_ptr<Image>>(module, "Image", py::buffer_protocol(), R"(
A grey picture as panelcal looks at it.

``Image(pixels, full_scale=None)`` copies a 2-D array once, into 32-bit
floating point; any strides will do, so that a channel of a colour picture needs
no other copy. `numpy.asarray(image)` is a view of the pixels that copies
nothing and may be written to.

Parameters
----------
pixels : array_like, shape (height, width)
    Grey levels, top row first: uint8, uint16, float32 or float64. Pixel (0, 0)
    is the centre of the top-left pixel; x goes right, y down.
full_scale : float, optional
    The level of white, 255 or 65535: by default that of the type; floating-point
    pixels need it.

Notes
-----
Thread-safety: any number of threads may read one image, also locate in it; a
thread that writes to its pixels has to be alone.)")
      .def(py::init([](const py::array& pixels, std::optional<double> full_scale) {
             return std::make_shared<Image>(image_of(pixels, full_scale));
           }),
           py::arg("pixels"),
           py::arg("full_scale") = py::none())
      .def_buffer([](Image& image) {
        return py::buffer_info(
            image.pixels().data(),
            sizeof(float),
            py::format_descriptor<float>::format(),
            2,
            {image.height(), image.width()},
            {sizeof(float) * static_cast<std::size_t>(image.width()), sizeof(float)});
      })
      .def_property_readonly("width", &Image::width, "Columns, px.")
      .def_property_readonly("height", &Image::height, "Rows, px.")
      .def_property_readonly(
          "shape",
          [](const Image& image) { return py::make_tuple(image.height(), image.width()); },
          "(height, width), px.")
      .def_property_readonly("full_scale", &Image::full_scale, "Level of white: 255 or 65535.")
      .def("__repr__", [](const Image& image) {
        return fmt::format("<panelcal.Image of {} x {} px, white is {:g}>",
                           image.width(),
                           image.height(),
                           image.full_scale());
      });
  module.def(
      "read_image",
      [](const std::filesystem::path& file) {
        return std::make_shared<Image>(value_of(read_image(file)));
      },
      py::arg("file"),
      py::call_guard<py::gil_scoped_release>());
  module.def(
      "write_png",
      [](const std::filesystem::path& file, const Image& image) {
        value_of(write_png(file, image));
      },
      py::arg("file"),
      py::arg("image"),
      py::call_guard<py::gil_scoped_release>());

  py::class_<CameraMapping>(module, "CameraMapping", R"(
The map from a picture to millimetres about the optical axis.

::

    d = u - axis,   K(u) = scale R(rotation) diag(1, -1) d (1 + k1 |d|^2)

Parameters
----------
scale_mm_per_px : float
axis_px : (float, float)
    Point at which the optical axis meets the picture.
rotation_rad : float
    Of the picture against the machine, counter-clockwise.
k1_per_px2 : float
    Radial distortion.

Notes
-----
Immutable: threads may share it.)")
      .def(py::init([](double scale_mm_per_px,
                       const std::pair<double, double>& axis_px,
                       double rotation_rad,
                       double k1_per_px2) {
             const CameraMapping::Parameters parameters{
                 scale_mm_per_px, rotation_rad, {axis_px.first, axis_px.second}, k1_per_px2};
             if (!(scale_mm_per_px > 0) || !std::isfinite(scale_mm_per_px) ||
                 !std::isfinite(rotation_rad) || !parameters.axis_px.allFinite() ||
                 !std::isfinite(k1_per_px2)) {
               raise_usage("CameraMapping",
                           "a scale that is not above 0, or a number that is not finite",
                           "finite numbers, and a scale above 0");
             }
             return CameraMapping(parameters);
           }),
           py::arg("scale_mm_per_px"),
           py::arg("axis_px"),
           py::arg("rotation_rad") = 0,
           py::arg("k1_per_px2") = 0)
      .def_property_readonly(
          "scale_mm_per_px",
          [](const CameraMapping& self) { return self.parameters().scale_mm_per_px; })
      .def_property_readonly(
          "rotation_rad", [](const CameraMapping& self) { return self.parameters().rotation_rad; })
      .def_property_readonly(
          "axis_px", [](const CameraMapping& self) { return matrix_of(self.parameters().axis_px); })
      .def_property_readonly("k1_per_px2",
                             [](const CameraMapping& self) { return self.parameters().k1_per_px2; })
      .def(
          "__call__",
          [](const CameraMapping& self, const Doubles& points_px) {
            std::vector<double> out;
            for (const Eigen::Vector2d& point : points_of(points_px, "points_px")) {
              const Eigen::Vector2d at_mm = self(position_px<frame::Image>(point)).in_mm();
              out.insert(out.end(), {at_mm.x(), at_mm.y()});
            }
            return array_of(std::move(out), {2});
          },
          py::arg("points_px"),
          "Places on the board in mm from the optical axis, shape (n, 2), of pixels (n, 2).");
}

}  // namespace panelcal::python
