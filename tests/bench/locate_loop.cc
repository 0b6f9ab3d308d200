// SPDX-License-Identifier: Apache-2.0

// Locates the same picture again and again, as a C++ program does: the peer of python_locate.py.
//
//   locate_loop MACHINE TOOL PICTURE
//
// A line `N image` or `N array` on standard input: N times, looking at the picture as it is or at
// one made of its 8-bit pixels each time; answers with the CPU seconds, on a line.

#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <string>
#include <vector>

#include "machine/config/machine_config.h"
#include "tools/cli/process/kept_memory.h"
#include "tools/locate/search.h"
#include "vision/locate/locate.h"
#include "vision/picture/files/image_io.h"

namespace {

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

panelcal::Image image_of(const std::vector<std::uint8_t>& pixels, int width, int height) {
  panelcal::Image image(width, height, panelcal::Image::kFullScale8);
  std::size_t i = 0;
  for (float& level : image.pixels()) level = static_cast<float>(pixels[i++]);
  return image;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return EXIT_FAILURE;
  panelcal::keep_freed_memory();  // as the program and the Python module do
  const auto machine = panelcal::read_machine_config(argv[1]);
  const auto image = panelcal::read_image(argv[3]);
  if (!machine || !image) return EXIT_FAILURE;
  const auto search = panelcal::target_search(*machine, std::atoi(argv[2]));
  if (!search) return EXIT_FAILURE;
  const std::vector<std::uint8_t> pixels(image->pixels().begin(), image->pixels().end());
  const panelcal::CameraMapping* const mapping = search->mapping ? &*search->mapping : nullptr;
  int n_times = 0;
  std::string what;
  while (std::cin >> n_times >> what) {
    int n_found = 0;
    const double start_s = cpu_seconds();
    for (int i = 0; i < n_times; ++i) {
      const auto look = [&](const panelcal::Image& at) {
        return panelcal::locate(at, search->target, mapping, search->options);
      };
      const panelcal::Detection found =
          what == "image" ? look(*image) : look(image_of(pixels, image->width(), image->height()));
      n_found += found.status == panelcal::DetectionStatus::Found ? 1 : 0;
    }
    const double seconds = cpu_seconds() - start_s;
    if (n_found != n_times) return EXIT_FAILURE;
    std::cout << seconds << std::endl;
  }
  return EXIT_SUCCESS;
}
