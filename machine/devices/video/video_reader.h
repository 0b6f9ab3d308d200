// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

// The face of libpanelcal_video.so: plain C, so that the module needs nothing of panelcal and may
// be replaced without it. Loaded by machine/devices/cameras/opencv_camera.cc.
#pragma GCC visibility push(default)
extern "C" {

struct PanelcalVideo;

enum PanelcalVideoKind { kPanelcalVideoFile = 0, kPanelcalVideoV4l2 = 1, kPanelcalVideoRtsp = 2 };

/// The frame that was grabbed last; valid until the next call.
struct PanelcalVideoFrame {
  int width;
  int height;
  int channels;          ///< 1 grey, 3 blue green red
  int bytes_per_sample;  ///< 1 or 2
  std::size_t row_bytes;
  const unsigned char* pixels;
};

/// Opens a video; null if that fails. A side of 0 px is left as it is.
PanelcalVideo* panelcal_video_open(int kind, const char* what, int width, int height);

/// Frames per second; 0 if unknown.
double panelcal_video_rate(PanelcalVideo* video);

/// Waits for the next frame; 0 if there is none.
int panelcal_video_grab(PanelcalVideo* video);

/// Time of the frame that was grabbed last, ms on the driver's clock (of a V4L2 device; most count
/// as CLOCK_MONOTONIC); 0 if unknown.
double panelcal_video_stamp_ms(PanelcalVideo* video);

/// Decodes the frame that was grabbed; 0 if it is damaged or of another kind than above.
int panelcal_video_decode(PanelcalVideo* video, PanelcalVideoFrame* frame);

void panelcal_video_close(PanelcalVideo* video);

}  // extern "C"
#pragma GCC visibility pop
