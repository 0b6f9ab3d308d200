// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/access/secret.h"

#include <array>
#include <cerrno>
#include <cstdint>
#include <system_error>

#include "calib/base/files/digest.h"
#include <sys/random.h>

namespace panelcal::serve {

std::string random_secret() {
  // Without i, l, o and u, which are misread; 32 signs, so that five bits are one.
  constexpr std::string_view kSigns = "0123456789abcdefghjkmnpqrstvwxyz";
  static_assert(kSigns.size() == 32);
  std::array<std::uint8_t, 25> random{};
  if (::getrandom(random.data(), random.size(), 0) != static_cast<ssize_t>(random.size())) {
    throw std::system_error(errno, std::generic_category(), "getrandom");
  }
  std::string secret;
  for (const std::uint8_t byte : random) secret += kSigns[byte % kSigns.size()];
  return secret;
}

bool is_equal_in_constant_time(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  // volatile: no compiler may leave the loop at the first difference.
  volatile unsigned char difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference = static_cast<unsigned char>(difference | (a[i] ^ b[i]));
  }
  return difference == 0;
}

std::string salted_hash(std::string_view salt, std::string_view secret) {
  return sha256(std::string(salt) + ":" + std::string(secret));
}

}  // namespace panelcal::serve
