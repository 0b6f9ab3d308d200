// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace panelcal::internal {

/// Takes the whole blocks that `bytes` begin with into a SHA-256 state, by the processor's own
/// instructions for it.
///
/// Out    how many bytes were taken: a multiple of 64; 0 on a processor without the instructions
/// Source FIPS 180-4; Intel SHA Extensions, 2013
/// See    tests/calib/base/files/digest_test.cc
std::size_t take_sha256_blocks(std::string_view bytes, std::span<std::uint32_t, 8> state);

}  // namespace panelcal::internal
