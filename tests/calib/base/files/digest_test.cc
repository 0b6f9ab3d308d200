// SPDX-License-Identifier: Apache-2.0
#include "calib/base/files/digest.h"

#include <array>
#include <cstdint>
#include <string>

#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>
#include <sha256.h>
#include <sys/types.h>

namespace panelcal {
namespace {

/// FIPS 180-4, the examples of NIST for SHA-256.
TEST(Digest, IsSha256) {
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

/// The processor's own instructions take whole blocks, the library the rest.
TEST(Digest, IsThatOfTheLibraryAtEveryLength) {
  Random random(20261123);
  std::string bytes;
  for (int n_bytes = 0; n_bytes <= 1000; ++n_bytes) {
    std::array<char, SHA256_DIGEST_STRING_LENGTH> hex{};
    SHA256Data(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), hex.data());
    ASSERT_EQ(sha256(bytes), hex.data()) << n_bytes << " bytes";
    bytes += static_cast<char>(static_cast<int>(random.uniform(0, 256)));
  }
}

}  // namespace
}  // namespace panelcal
