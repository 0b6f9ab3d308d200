// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <type_traits>

#include <Eigen/Core>

namespace panelcal {

/// Frame tags. docs/conventions.md says where each origin is and which way its axes point.
namespace frame {
struct Programmed {};  ///< as written in the program, mm
struct Nominal {};     ///< after step-and-repeat placement, relative to work zero, mm
struct Base {};        ///< after the base correction, relative to work zero, mm
struct Actual {};      ///< true place of the mark or hole, relative to work zero, mm
struct Machine {};     ///< coordinates that the machine receives, mm
struct Optical {};     ///< relative to the optical axis, machine directions, mm
struct Image {};       ///< picture, (0,0) = centre of the top-left pixel, x right, y down, px
}  // namespace frame

template <class F>
inline constexpr bool kIsPixelFrame = std::is_same_v<F, frame::Image>;

/// A difference of two positions in frame F.
template <class F>
class Displacement {
 public:
  Displacement() : v_(Eigen::Vector2d::Zero()) {}
  const Eigen::Vector2d& in_mm() const requires(!kIsPixelFrame<F>) { return v_; }
  const Eigen::Vector2d& in_px() const requires(kIsPixelFrame<F>) { return v_; }

  friend Displacement operator+(const Displacement& a, const Displacement& b) {
    return Displacement(a.v_ + b.v_);
  }
  friend Displacement operator-(const Displacement& a, const Displacement& b) {
    return Displacement(a.v_ - b.v_);
  }
  friend Displacement operator-(const Displacement& a) { return Displacement(-a.v_); }
  friend Displacement operator*(double k, const Displacement& a) { return Displacement(k * a.v_); }
  friend bool operator==(const Displacement& a, const Displacement& b) { return a.v_ == b.v_; }

 private:
  explicit Displacement(const Eigen::Vector2d& v) : v_(v) {}
  Eigen::Vector2d v_;
  template <class G>
  friend Displacement<G> displacement_mm(double, double);
  template <class G>
  friend Displacement<G> displacement_mm(const Eigen::Vector2d&);
  template <class G>
  friend Displacement<G> displacement_px(const Eigen::Vector2d&);
};

/// A point in frame F. Positions subtract to a displacement; adding two does not compile.
template <class F>
class Position {
 public:
  Position() : v_(Eigen::Vector2d::Zero()) {}
  const Eigen::Vector2d& in_mm() const requires(!kIsPixelFrame<F>) { return v_; }
  const Eigen::Vector2d& in_px() const requires(kIsPixelFrame<F>) { return v_; }

  friend bool operator==(const Position& a, const Position& b) { return a.v_ == b.v_; }

 private:
  explicit Position(const Eigen::Vector2d& v) : v_(v) {}
  Eigen::Vector2d v_;
  template <class G>
  friend Position<G> position_mm(double, double);
  template <class G>
  friend Position<G> position_mm(const Eigen::Vector2d&);
  template <class G>
  friend Position<G> position_px(const Eigen::Vector2d&);
};

template <class F>
Displacement<F> displacement_mm(double x_mm, double y_mm) {
  static_assert(!kIsPixelFrame<F>);
  return Displacement<F>(Eigen::Vector2d(x_mm, y_mm));
}
template <class F>
Displacement<F> displacement_mm(const Eigen::Vector2d& v_mm) {
  static_assert(!kIsPixelFrame<F>);
  return Displacement<F>(v_mm);
}
template <class F>
Displacement<F> displacement_px(const Eigen::Vector2d& v_px) {
  static_assert(kIsPixelFrame<F>);
  return Displacement<F>(v_px);
}
template <class F>
Position<F> position_mm(double x_mm, double y_mm) {
  static_assert(!kIsPixelFrame<F>);
  return Position<F>(Eigen::Vector2d(x_mm, y_mm));
}
template <class F>
Position<F> position_mm(const Eigen::Vector2d& v_mm) {
  static_assert(!kIsPixelFrame<F>);
  return Position<F>(v_mm);
}
template <class F>
Position<F> position_px(const Eigen::Vector2d& v_px) {
  static_assert(kIsPixelFrame<F>);
  return Position<F>(v_px);
}
inline Position<frame::Image> position_px(double x_px, double y_px) {
  return position_px<frame::Image>(Eigen::Vector2d(x_px, y_px));
}

namespace internal {
template <class F>
const Eigen::Vector2d& raw(const Position<F>& p) {
  if constexpr (kIsPixelFrame<F>) {
    return p.in_px();
  } else {
    return p.in_mm();
  }
}
template <class F>
const Eigen::Vector2d& raw(const Displacement<F>& d) {
  if constexpr (kIsPixelFrame<F>) {
    return d.in_px();
  } else {
    return d.in_mm();
  }
}
template <class F>
Position<F> make_position(const Eigen::Vector2d& v) {
  if constexpr (kIsPixelFrame<F>) {
    return position_px<F>(v);
  } else {
    return position_mm<F>(v);
  }
}
template <class F>
Displacement<F> make_displacement(const Eigen::Vector2d& v) {
  if constexpr (kIsPixelFrame<F>) {
    return displacement_px<F>(v);
  } else {
    return displacement_mm<F>(v);
  }
}
}  // namespace internal

template <class F>
Displacement<F> operator-(const Position<F>& a, const Position<F>& b) {
  return internal::make_displacement<F>(internal::raw(a) - internal::raw(b));
}
template <class F>
Position<F> operator+(const Position<F>& p, const Displacement<F>& d) {
  return internal::make_position<F>(internal::raw(p) + internal::raw(d));
}
template <class F>
Position<F> operator-(const Position<F>& p, const Displacement<F>& d) {
  return internal::make_position<F>(internal::raw(p) - internal::raw(d));
}

/// An affine map between two frames: to = linear * from + translation.
///
/// Composes only if the middle frame matches: `a_from_c = a_from_b * b_from_c`.
template <class To, class From>
class Transform {
 public:
  Transform() : linear_(Eigen::Matrix2d::Identity()), translation_(Eigen::Vector2d::Zero()) {}
  /// linear in units of To per unit of From; translation in To's unit.
  Transform(const Eigen::Matrix2d& linear, const Eigen::Vector2d& translation)
      : linear_(linear), translation_(translation) {}

  const Eigen::Matrix2d& linear() const { return linear_; }
  const Eigen::Vector2d& translation() const { return translation_; }

  Position<To> operator()(const Position<From>& p) const {
    return internal::make_position<To>(linear_ * internal::raw(p) + translation_);
  }
  Displacement<To> operator()(const Displacement<From>& d) const {
    return internal::make_displacement<To>(linear_ * internal::raw(d));
  }

  /// The map back. Precondition: linear() is not singular.
  Transform<From, To> inverse() const {
    const double det = linear_(0, 0) * linear_(1, 1) - linear_(0, 1) * linear_(1, 0);
    Eigen::Matrix2d inverse;
    inverse << linear_(1, 1), -linear_(0, 1), -linear_(1, 0), linear_(0, 0);
    inverse /= det;
    const Eigen::Vector2d back = -(inverse * translation_);
    return Transform<From, To>(inverse, back);
  }

  friend bool operator==(const Transform& a, const Transform& b) {
    return a.linear_ == b.linear_ && a.translation_ == b.translation_;
  }

 private:
  Eigen::Matrix2d linear_;
  Eigen::Vector2d translation_;
};

template <class A, class B, class C>
Transform<A, C> operator*(const Transform<A, B>& a_from_b, const Transform<B, C>& b_from_c) {
  const Eigen::Matrix2d linear = a_from_b.linear() * b_from_c.linear();
  const Eigen::Vector2d shift = a_from_b.linear() * b_from_c.translation() + a_from_b.translation();
  return Transform<A, C>(linear, shift);
}

}  // namespace panelcal
