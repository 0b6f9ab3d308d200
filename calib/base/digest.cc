// SPDX-License-Identifier: Apache-2.0
#include "calib/base/digest.h"

#include <array>
#include <cstdint>

#include <sha256.h>
#include <sys/types.h>

namespace panelcal {

std::string sha256(std::string_view bytes) {
  std::array<char, SHA256_DIGEST_STRING_LENGTH> hex{};
  SHA256Data(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), hex.data());
  return hex.data();
}

}  // namespace panelcal
