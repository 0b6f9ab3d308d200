// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace panelcal::serve {

/// 125 random bits of the system as 25 letters and digits that a person can read out and type.
/// Throws std::system_error where the system has none.
std::string random_secret();

/// Compares in a time that depends on the lengths alone.
bool is_equal_in_constant_time(std::string_view a, std::string_view b);

/// SHA-256 of a salt and a secret, as 64 hexadecimal digits. The secrets are random_secret()s: no
/// dictionary has them, so that no slow function is needed.
std::string salted_hash(std::string_view salt, std::string_view secret);

}  // namespace panelcal::serve
