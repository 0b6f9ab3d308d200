// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include <arv.h>

// Not installed: public headers know nothing of Aravis.
namespace panelcal::internal {

struct Unref {
  void operator()(void* object) const { g_object_unref(object); }
};

/// Owns one reference to a GObject.
template <class T>
using Object = std::unique_ptr<T, Unref>;

/// The error of an Aravis call.
class DeviceError {
 public:
  DeviceError() = default;
  DeviceError(const DeviceError&) = delete;
  DeviceError& operator=(const DeviceError&) = delete;
  ~DeviceError() { g_clear_error(&error_); }

  /// For the next call; forgets the last one's.
  GError** out() {
    g_clear_error(&error_);
    return &error_;
  }
  explicit operator bool() const { return error_ != nullptr; }
  std::string text() const { return error_ != nullptr ? error_->message : "no reason given"; }

 private:
  GError* error_ = nullptr;
};

}  // namespace panelcal::internal
