// SPDX-License-Identifier: Apache-2.0
#include "calib/base/json/facts.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace panelcal::facts {
namespace {

constexpr std::string_view kBase64Alphabet =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

template <class T>
Json packed_column(std::string_view type, std::span<const T> values) {
  static_assert(std::endian::native == std::endian::little);
  const std::string_view bytes(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  return {{"type", type}, {"base64", base64(bytes)}};
}

}  // namespace

Json envelope(std::string_view kind, int version) {
  return {{"facts", kind}, {"version", version}, {"panelcal", PANELCAL_VERSION}};
}

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

Json number(const std::optional<double>& value) {
  return value ? number(*value) : Json();
}

Json point(const Eigen::Vector2d& value) {
  return Json::array({number(value.x()), number(value.y())});
}

Json covariance(const Eigen::Matrix2d& value) {
  return Json::array({number(value(0, 0)), number(value(0, 1)), number(value(1, 1))});
}

Json packed(std::span<const float> values) {
  return packed_column("float32", values);
}

Json packed(std::span<const std::uint32_t> values) {
  return packed_column("uint32", values);
}

std::string text(const Json& document) {
  return document.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string_view in_page(std::string_view html) {
  const std::size_t mark = html.find(kPageMark);
  if (mark == std::string_view::npos) return {};
  html.remove_prefix(mark + kPageMark.size());
  return html.substr(0, html.find('<'));
}

std::string base64(std::string_view bytes) {
  std::string out((bytes.size() + 2) / 3 * 4, '=');
  std::size_t at = 0;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t n = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8 | (k < n ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k <= n; ++k) {
      out[at + k] = kBase64Alphabet[group >> (18 - 6 * k) & 63U];
    }
    at += 4;
  }
  return out;
}

}  // namespace panelcal::facts
