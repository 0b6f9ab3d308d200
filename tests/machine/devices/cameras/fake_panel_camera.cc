// SPDX-License-Identifier: Apache-2.0
// A GigE Vision camera over a panel that exists only as pictures, for the test of a whole job and
// for trying panelcal without a camera:
//
//   fake_panel_camera ADDRESS PICTURES STAGE_FILE OFFSET_X OFFSET_Y [LOST_SHARE [FRAMES]]
//
// It shows the picture of the folder that was taken nearest to where the stage stands. STAGE_FILE
// holds where the spindle stands, "x y" in mm, as a stage_command has written it; the
// spindle-camera offset is in mm. LOST_SHARE of the packets, 0 to 1, do not arrive; after FRAMES
// frames, if above 0, the camera is gone. Writes "ready" when it serves, and ends with its standard
// input.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "vision/picture/files/folder.h"
#include "vision/picture/files/image_io.h"

#include "tests/machine/devices/cameras/fake_gige_camera.h"

namespace panelcal::test {
namespace {

struct Shot {
  Position<frame::Machine> axis;
  Image image;
};

Expected<std::vector<Shot>> read_shots(const std::string& folder) {
  PANELCAL_TRY(const PictureFolder pictures, read_picture_folder(folder));
  std::vector<Shot> shots;
  for (const PictureRow& row : pictures.rows) {
    PANELCAL_TRY(Image image, read_image(pictures.path_of(row)));
    shots.push_back({row.axis, std::move(image)});
  }
  return shots;
}

/// Picture that the camera sees of the panel; null while the place of the stage is not known.
const Shot* seen_shot(const std::vector<Shot>& shots,
                      const std::string& stage_file,
                      const Displacement<frame::Machine>& offset) {
  std::ifstream file(stage_file);
  double x_mm = 0;
  double y_mm = 0;
  if (!(file >> x_mm >> y_mm)) return nullptr;
  const Position<frame::Machine> axis = position_mm<frame::Machine>(x_mm, y_mm) + offset;
  const auto nearest = std::ranges::min_element(
      shots, {}, [&](const Shot& shot) { return (shot.axis - axis).in_mm().norm(); });
  return &*nearest;
}

void draw(const Shot* shot, std::span<std::uint8_t> bytes) {
  std::ranges::fill(bytes, 0);
  if (shot == nullptr) return;
  const auto pixels = shot->image.pixels();
  for (std::size_t i = 0; i < std::min(bytes.size(), pixels.size()); ++i) {
    bytes[i] = static_cast<std::uint8_t>(pixels[i]);
  }
}

int serve(int argc, char** argv) {
  if (argc < 6) return 2;
  const auto shots = read_shots(argv[2]);
  if (!shots || shots->empty()) {
    std::cerr << (shots ? "no pictures" : shots.error().text()) << '\n';
    return 2;
  }
  const std::string stage_file = argv[3];
  const auto offset = displacement_mm<frame::Machine>(std::stod(argv[4]), std::stod(argv[5]));
  const int n_frames = argc > 7 ? std::stoi(argv[7]) : 0;
  int n_drawn = 0;
  const Image& first = shots->front().image;
  FakeGigeCamera camera(argv[1], first.width(), first.height(), [&](const FakeFrame& frame) {
    if (n_frames > 0 && ++n_drawn > n_frames) std::_Exit(0);
    draw(seen_shot(*shots, stage_file, offset), frame.bytes);
  });
  if (argc > 6 && camera.is_running()) camera.lose(std::stod(argv[6]));
  return serve_until_input_ends(camera);
}

}  // namespace
}  // namespace panelcal::test

int main(int argc, char** argv) {
  return panelcal::test::serve(argc, argv);
}
