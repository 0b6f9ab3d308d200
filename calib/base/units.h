// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <concepts>
#include <numbers>

namespace panelcal {

namespace dimension {
struct Length {};
struct Angle {};
struct PixelLength {};
struct Feed {};
struct SpindleSpeed {};
struct Time {};
}  // namespace dimension

/// A number with a unit: named at every way in (`mm(3.2)`) and out (`.in_mm()`).
///
/// Stored as mm, rad, px, mm/s, rpm or s. There is no constructor from a bare number, so an inch
/// cannot be taken for a millimetre nor a degree for a radian.
template <class Dimension>
class Quantity {
 public:
  constexpr Quantity() = default;

  constexpr double in_mm() const requires std::same_as<Dimension, dimension::Length>;
  constexpr double in_um() const requires std::same_as<Dimension, dimension::Length>;
  constexpr double in_inch() const requires std::same_as<Dimension, dimension::Length>;
  constexpr double in_rad() const requires std::same_as<Dimension, dimension::Angle>;
  constexpr double in_deg() const requires std::same_as<Dimension, dimension::Angle>;
  constexpr double in_px() const requires std::same_as<Dimension, dimension::PixelLength>;
  constexpr double in_mm_s() const requires std::same_as<Dimension, dimension::Feed>;
  constexpr double in_rpm() const requires std::same_as<Dimension, dimension::SpindleSpeed>;
  constexpr double in_s() const requires std::same_as<Dimension, dimension::Time>;

  friend constexpr Quantity operator+(Quantity a, Quantity b) { return Quantity(a.v_ + b.v_); }
  friend constexpr Quantity operator-(Quantity a, Quantity b) { return Quantity(a.v_ - b.v_); }
  friend constexpr Quantity operator-(Quantity a) { return Quantity(-a.v_); }
  friend constexpr Quantity operator*(Quantity a, double k) { return Quantity(a.v_ * k); }
  friend constexpr Quantity operator*(double k, Quantity a) { return Quantity(a.v_ * k); }
  friend constexpr Quantity operator/(Quantity a, double k) { return Quantity(a.v_ / k); }
  friend constexpr double operator/(Quantity a, Quantity b) { return a.v_ / b.v_; }
  friend constexpr auto operator<=>(Quantity, Quantity) = default;

 private:
  constexpr explicit Quantity(double v) : v_(v) {}
  double v_ = 0;

  template <class D>
  friend constexpr Quantity<D> make_quantity(double stored);
};

template <class D>
constexpr Quantity<D> make_quantity(double stored) {
  return Quantity<D>(stored);
}

using Length = Quantity<dimension::Length>;
using Angle = Quantity<dimension::Angle>;
using PixelLength = Quantity<dimension::PixelLength>;
using Feed = Quantity<dimension::Feed>;
using SpindleSpeed = Quantity<dimension::SpindleSpeed>;
using Time = Quantity<dimension::Time>;

/// Millimetres in an inch, exactly (international inch, 1959).
inline constexpr double kMmPerInch = 25.4;

constexpr Length mm(double v) {
  return make_quantity<dimension::Length>(v);
}
constexpr Length um(double v) {
  return mm(v * 1e-3);
}
constexpr Length inch(double v) {
  return mm(v * kMmPerInch);
}
constexpr Angle rad(double v) {
  return make_quantity<dimension::Angle>(v);
}
constexpr Angle deg(double v) {
  return rad(v * std::numbers::pi / 180.0);
}
constexpr PixelLength px(double v) {
  return make_quantity<dimension::PixelLength>(v);
}
constexpr Feed mm_per_s(double v) {
  return make_quantity<dimension::Feed>(v);
}
constexpr Feed inch_per_min(double v) {
  return mm_per_s(v * kMmPerInch / 60.0);
}
constexpr SpindleSpeed rpm(double v) {
  return make_quantity<dimension::SpindleSpeed>(v);
}
constexpr Time seconds(double v) {
  return make_quantity<dimension::Time>(v);
}

template <class D>
constexpr double Quantity<D>::in_mm() const requires std::same_as<D, dimension::Length> {
  return v_;
}
template <class D>
constexpr double Quantity<D>::in_um() const requires std::same_as<D, dimension::Length> {
  return v_ * 1e3;
}
template <class D>
constexpr double Quantity<D>::in_inch() const requires std::same_as<D, dimension::Length> {
  return v_ / kMmPerInch;
}
template <class D>
constexpr double Quantity<D>::in_rad() const requires std::same_as<D, dimension::Angle> {
  return v_;
}
template <class D>
constexpr double Quantity<D>::in_deg() const requires std::same_as<D, dimension::Angle> {
  return v_ * 180.0 / std::numbers::pi;
}
template <class D>
constexpr double Quantity<D>::in_px() const requires std::same_as<D, dimension::PixelLength> {
  return v_;
}
template <class D>
constexpr double Quantity<D>::in_mm_s() const requires std::same_as<D, dimension::Feed> {
  return v_;
}
template <class D>
constexpr double Quantity<D>::in_rpm() const requires std::same_as<D, dimension::SpindleSpeed> {
  return v_;
}
template <class D>
constexpr double Quantity<D>::in_s() const requires std::same_as<D, dimension::Time> {
  return v_;
}

}  // namespace panelcal
