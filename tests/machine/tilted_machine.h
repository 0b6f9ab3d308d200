// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "calib/base/statistics/random.h"
#include "calib/camera/model.h"
#include "calib/correction/spindle_camera.h"
#include "machine/devices/camera.h"
#include "machine/devices/spindle.h"
#include "machine/devices/stage.h"

namespace panelcal::test {

/// A stage and a camera of CameraModel's full form over one dark hole. The simulated machine draws
/// no perspective, so this one draws its own: the level of a pixel follows from how far its place
/// on the panel, by the model, is from the hole's rim.
class TiltedMachine final : public Stage, public CameraDevice, public Spindle {
 public:
  TiltedMachine(const CameraModel& camera,
                SpindleCameraOffset offset,
                const Position<frame::Machine>& hole,
                Length diameter,
                std::uint64_t seed)
      : camera_(camera), offset_(offset), hole_(hole), diameter_(diameter), noise_(seed) {}

  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& spindle) override {
    return spindle_ = spindle;
  }
  Expected<void> drill(int /*tool*/) override { return {}; }
  std::string name() const override { return "tilted"; }
  bool can_set(CameraSetting setting) const override { return Stage::can_set(setting); }
  Expected<void> set(CameraSetting setting, double value) override {
    return Stage::set(setting, value);
  }

  Expected<Image> take() override {
    constexpr double kGround = 150;
    constexpr double kHole = 40;
    constexpr double kNoise = 2;
    constexpr double kNear_px = 80;
    Image image(640, 480, 255);
    const Eigen::Vector2d center_mm = (hole_ - offset_.optical_axis(spindle_)).in_mm();
    const auto middle = camera_.image_of(position_mm<frame::Optical>(center_mm));
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) {
        // Elsewhere there is nothing of it.
        const Eigen::Vector2d u_px(x, y);
        const bool is_near = middle && (u_px - middle->in_px()).cwiseAbs().maxCoeff() < kNear_px;
        const double share = is_near ? share_of(u_px, center_mm) : 0;
        const double level = kGround + (kHole - kGround) * share + kNoise * noise_.normal();
        image.at(x, y) = static_cast<float>(std::clamp(std::round(level), 0.0, 255.0));
      }
    }
    return image;
  }

 private:
  /// Share of a pixel that the hole covers.
  double share_of(const Eigen::Vector2d& u_px, const Eigen::Vector2d& center_mm) const {
    constexpr double kBlur_px = 1.2;
    const double blur_mm = kBlur_px * camera_.parameters().scale_mm_per_px;
    const Eigen::Vector2d at_mm = camera_(position_px<frame::Image>(u_px)).in_mm();
    const double inside_mm = 0.5 * diameter_.in_mm() - (at_mm - center_mm).norm();
    return 0.5 * std::erfc(-inside_mm / blur_mm / std::sqrt(2.0));
  }

  CameraModel camera_;
  SpindleCameraOffset offset_;
  Position<frame::Machine> hole_;
  Length diameter_;
  Random noise_;
  Position<frame::Machine> spindle_;
};

}  // namespace panelcal::test
