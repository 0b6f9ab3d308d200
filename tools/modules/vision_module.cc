// SPDX-License-Identifier: Apache-2.0
#include "tools/modules/module.h"
#include "tools/modules/vision_functions.h"
#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/logger.hpp>

namespace {

constexpr panelcal::modules::VisionFunctions kVisionFunctions = {
    .read_image = &panelcal::read_image,
    .decode_image = &panelcal::decode_image,
    .encode_jpeg = &panelcal::encode_jpeg,
    .encode_png = &panelcal::encode_png,
    .write_png = &panelcal::write_png,
    .locate = &panelcal::locate,
    .target_problem = &panelcal::internal::target_problem,
    .read_tags = &panelcal::read_tags,
    .encode_overlay = &panelcal::encode_overlay,
    .target_picture = &panelcal::target_picture,
    .find_marks = &panelcal::find_marks,
};

/// OpenCV logs to standard output too, as far as OPENCV_LOG_LEVEL tells it. Threads are the
/// program's own (calib/base/thread_pool.h).
void prepare_opencv() {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  cv::setNumThreads(1);  // sets up threads first, and logs that
}

}  // namespace

extern "C" [[gnu::visibility("default")]] const PanelcalModule panelcal_module = {
    PANELCAL_VERSION, &kVisionFunctions, &prepare_opencv};
