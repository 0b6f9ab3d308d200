// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/video/video_reader.h"

#include <cmath>
#include <exception>
#include <memory>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/videoio.hpp>

struct PanelcalVideo {
  cv::VideoCapture capture;
  cv::Mat frame;
};

namespace {

/// OpenCV would wait half a minute for a network camera that is not there.
constexpr int kTimeout_ms = 5000;

bool open(cv::VideoCapture& capture, int kind, const char* what, int width, int height) {
  if (kind == kPanelcalVideoV4l2) {
    if (!capture.open(what, cv::CAP_V4L2)) return false;
    if (width > 0) capture.set(cv::CAP_PROP_FRAME_WIDTH, width);
    if (height > 0) capture.set(cv::CAP_PROP_FRAME_HEIGHT, height);
    return true;
  }
  std::vector<int> options;
  if (kind == kPanelcalVideoRtsp) {
    options = {
        cv::CAP_PROP_OPEN_TIMEOUT_MSEC, kTimeout_ms, cv::CAP_PROP_READ_TIMEOUT_MSEC, kTimeout_ms};
  }
  // By name: OpenCV would also take a file's name with % in it for a series of pictures.
  return capture.open(what, cv::CAP_FFMPEG, options);
}

}  // namespace

PanelcalVideo* panelcal_video_open(int kind, const char* what, int width, int height) {
  try {
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    auto video = std::make_unique<PanelcalVideo>();
    return open(video->capture, kind, what, width, height) ? video.release() : nullptr;
  } catch (const std::exception&) {
    return nullptr;
  }
}

double panelcal_video_rate(PanelcalVideo* video) {
  try {
    const double rate = video->capture.get(cv::CAP_PROP_FPS);
    return std::isfinite(rate) && rate > 0 ? rate : 0;
  } catch (const std::exception&) {
    return 0;
  }
}

int panelcal_video_grab(PanelcalVideo* video) {
  try {
    return video->capture.grab() ? 1 : 0;
  } catch (const std::exception&) {
    return 0;
  }
}

double panelcal_video_stamp_ms(PanelcalVideo* video) {
  try {
    const double stamp_ms = video->capture.get(cv::CAP_PROP_POS_MSEC);
    return std::isfinite(stamp_ms) && stamp_ms > 0 ? stamp_ms : 0;
  } catch (const std::exception&) {
    return 0;
  }
}

int panelcal_video_decode(PanelcalVideo* video, PanelcalVideoFrame* frame) {
  try {
    cv::Mat& mat = video->frame;
    if (!video->capture.retrieve(mat) || mat.empty()) return 0;
    const bool has_known_depth = mat.depth() == CV_8U || mat.depth() == CV_16U;
    if (!has_known_depth || (mat.channels() != 1 && mat.channels() != 3)) return 0;
    frame->width = mat.cols;
    frame->height = mat.rows;
    frame->channels = mat.channels();
    frame->bytes_per_sample = static_cast<int>(mat.elemSize1());
    frame->row_bytes = mat.step[0];
    frame->pixels = mat.data;
    return 1;
  } catch (const std::exception&) {
    return 0;
  }
}

void panelcal_video_close(PanelcalVideo* video) {
  delete video;
}
