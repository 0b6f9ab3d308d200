// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/locate/locate.h"
#include "vision/locate/target_check.h"
#include "vision/picture/files/image_io.h"
#include "vision/show/overlay.h"
#include "vision/show/target_picture.h"
#include "vision/suggest/find_marks.h"
#include "vision/tag/read_tags.h"

namespace panelcal::modules {

inline constexpr const char* kVisionModule = "libpanelcal_vision.so";

/// All of panelcal::vision that the program calls. OpenCV, libpng, libjpeg and libtiff.
struct VisionFunctions {
  decltype(&panelcal::read_image) read_image;
  decltype(&panelcal::decode_image) decode_image;
  decltype(&panelcal::encode_jpeg) encode_jpeg;
  decltype(&panelcal::encode_png) encode_png;
  decltype(&panelcal::write_png) write_png;
  decltype(&panelcal::locate) locate;
  decltype(&panelcal::internal::target_problem) target_problem;
  decltype(&panelcal::read_tags) read_tags;
  decltype(&panelcal::encode_overlay) encode_overlay;
  decltype(&panelcal::target_picture) target_picture;
  decltype(&panelcal::find_marks) find_marks;
};

}  // namespace panelcal::modules
