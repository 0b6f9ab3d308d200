// SPDX-License-Identifier: Apache-2.0
#include "calib/base/files/digest.h"

#include <array>
#include <cstdint>

#include "calib/base/files/sha256_x86.h"
#include <sha256.h>
#include <sys/types.h>

namespace panelcal {

std::string sha256(std::string_view bytes) {
  SHA2_CTX context;
  SHA256Init(&context);
  const std::size_t n_taken = internal::take_sha256_blocks(bytes, context.state.st32);
  context.bitcount[0] = std::uint64_t{8} * n_taken;
  bytes.remove_prefix(n_taken);
  SHA256Update(&context, reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  std::array<char, SHA256_DIGEST_STRING_LENGTH> hex{};
  SHA256End(&context, hex.data());
  return hex.data();
}

}  // namespace panelcal
