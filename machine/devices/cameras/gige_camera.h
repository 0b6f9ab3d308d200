// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "machine/devices/camera.h"

namespace panelcal {

/// gige://ADDRESS?...
struct GigeAddress {
  std::string address;                ///< IPv4, four numbers
  int packet_bytes = 1500;            ///< larger ones lose frames unless every switch carries them
  std::optional<Time> exposure;       ///< absent: as the camera has it
  std::optional<double> gain;         ///< in the camera's own unit; absent: as it has it
  std::optional<std::string> format;  ///< such as "mono8"; absent: as it has it
  Time timeout = seconds(1);          ///< longest time of a frame beyond its exposure
  int retries = 20;                   ///< number of times that a lost frame is taken again
  /// True if lost packets are asked for again. Absent: only with a raw socket (CAP_NET_RAW), since
  /// without one the answers come too late and cost more packets.
  std::optional<bool> resend;
};

/// True if this panelcal can talk GigE Vision: it needs Aravis when it is built.
bool has_gige_vision();

/// Opens a GigE Vision camera and takes control of it.
///
/// Frames are triggered by software, so that each was exposed after it was asked for. A frame with
/// missing packets is never used but taken again. After a frame that did not come the stream is
/// begun anew, since that frame could come late and be taken for the next one.
///
/// Fails  device-camera (no answer at the address, another program controls the camera, no
///        software trigger, a setting outside of its bounds; built without Aravis)
/// Cost   up to 3 s where there is no answer
/// See    tests/machine/devices/cameras/gige_camera_test.cc
Expected<std::unique_ptr<CameraDevice>> open_gige_camera(const GigeAddress& address);

}  // namespace panelcal
