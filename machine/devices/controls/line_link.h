// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "calib/base/expected.h"
#include "calib/base/files/file_descriptor.h"
#include "calib/base/units.h"

namespace panelcal {

/// A two-way stream of bytes to a control: TCP or a serial device. Not thread-safe.
///
/// See    tests/machine/devices/controls/line_link_test.cc
class LineLink {
 public:
  /// In     heeds_signals: false while a machine is being stopped after one
  /// Fails  device-stage (no such host, refused, no answer within the limit); interrupted
  static Expected<std::unique_ptr<LineLink>> tcp(const std::string& host,
                                                 int port,
                                                 Time limit,
                                                 bool heeds_signals = true);
  /// Raw, 8 data bits, no parity, one stop bit; locked against other programs.
  ///
  /// Fails  device-stage (cannot be opened, is in use, is no serial device, has no such speed)
  static Expected<std::unique_ptr<LineLink>> serial(const std::string& device, int baud);

  /// Fails  device-stage (the connection is lost, or takes nothing for 5 s)
  Expected<void> send(std::string_view bytes);

  /// The next line without its end; absent: there was none within the time.
  ///
  /// In     heeds_signals: false while a machine is being stopped after one
  /// Fails  device-stage (the connection is lost; a line above 64 KiB); interrupted
  Expected<std::optional<std::string>> line(Time within, bool heeds_signals = true);

  /// "/dev/ttyUSB0", "mill:23".
  const std::string& name() const { return name_; }

 private:
  LineLink(internal::FileDescriptor fd, std::string name)
      : fd_(std::move(fd)), name_(std::move(name)) {}
  /// Takes what has arrived.
  Expected<void> take();
  std::optional<std::string> next_line();
  Diagnostic problem(std::string what) const;

  internal::FileDescriptor fd_;
  std::string name_;
  std::string received_;
};

}  // namespace panelcal
