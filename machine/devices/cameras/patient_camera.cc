// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/cameras/patient_camera.h"

#include <algorithm>
#include <chrono>
#include <utility>
#include <variant>

#include "calib/base/interruption.h"
#include "machine/devices/cameras/camera_uri.h"

namespace panelcal {
namespace {

constexpr Time kBetweenTries = seconds(0.25);

bool may_pass(const Diagnostic& problem) {
  return info(problem.code).fault == Fault::Device && problem.code != Code::Interrupted;
}

bool is_live(const CameraAddress& address) {
  const auto* const video = std::get_if<VideoAddress>(&address);
  return std::holds_alternative<GigeAddress>(address) ||
         (video != nullptr && video->kind != VideoAddress::Kind::File);
}

}  // namespace

PatientCamera::PatientCamera(Open open,
                             Time patience,
                             Wait wait,
                             std::unique_ptr<CameraDevice> device)
    : open_(std::move(open)),
      patience_(patience),
      wait_(std::move(wait)),
      device_(std::move(device)),
      name_(device_->name()),
      size_(device_->size()) {
  for (std::size_t i = 0; i < can_set_.size(); ++i) {
    can_set_[i] = device_->can_set(static_cast<CameraSetting>(i));
  }
  add_risks();
}

void PatientCamera::add_risks() {
  for (Diagnostic& risk : device_->risks()) {
    const auto is_said = [&](const Diagnostic& said) { return said.text() == risk.text(); };
    if (std::ranges::none_of(risks_, is_said)) risks_.push_back(std::move(risk));
  }
}

Expected<std::unique_ptr<CameraDevice>> PatientCamera::make(Open open, Time patience, Wait wait) {
  PANELCAL_TRY(std::unique_ptr<CameraDevice> device, open());
  return std::unique_ptr<CameraDevice>(
      new PatientCamera(std::move(open), patience, std::move(wait), std::move(device)));
}

/// Sets what the last one was set to.
Expected<void> PatientCamera::reopen() {
  PANELCAL_TRY(device_, open_());
  add_risks();
  for (const auto& [setting, value] : settings_) PANELCAL_CHECK(device_->set(setting, value));
  return {};
}

template <class Result, class Act>
Expected<Result> PatientCamera::tried(const Act& act) {
  const auto begin = std::chrono::steady_clock::now();
  for (Time waited;; waited = waited + kBetweenTries) {
    PANELCAL_CHECK(check_interruption());
    const Expected<void> is_open = device_ ? Expected<void>() : reopen();
    Expected<Result> result = is_open ? act() : failure(is_open.error());
    if (result || !may_pass(result.error())) return result;
    // A try takes time as well.
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin;
    if (waited >= patience_ || seconds(passed.count()) >= patience_) return result;
    // Its place has to be free before it can be opened anew.
    if (device_) n_retaken_before_ += device_->n_retaken();
    device_.reset();
    wait_(kBetweenTries);
  }
}

Expected<Image> PatientCamera::take() {
  return tried<Image>([this] { return device_->take(); });
}

int PatientCamera::n_retaken() const {
  return n_retaken_before_ + (device_ ? device_->n_retaken() : 0);
}

bool PatientCamera::can_set(CameraSetting setting) const {
  return can_set_[static_cast<std::size_t>(setting)];
}

Expected<void> PatientCamera::set(CameraSetting setting, double value) {
  if (!can_set(setting)) return CameraDevice::set(setting, value);
  PANELCAL_CHECK(tried<void>([&] { return device_->set(setting, value); }));
  settings_[setting] = value;
  return {};
}

Expected<std::unique_ptr<CameraDevice>> open_patient_camera(std::string_view uri, Time patience) {
  PANELCAL_TRY(const CameraAddress address, parse_camera_uri(uri));
  if (!is_live(address)) return open_camera(uri);
  return PatientCamera::make(
      [uri = std::string(uri)] { return open_camera(uri); }, patience, sleep_for);
}

}  // namespace panelcal
