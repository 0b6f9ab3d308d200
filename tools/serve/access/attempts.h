// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <map>
#include <string>

namespace panelcal::serve {

/// A clock that only goes on; passed in, so that tests need not wait.
using Now = std::chrono::steady_clock::time_point;

struct AttemptLimits {
  std::chrono::seconds window{60};
  std::size_t n_per_address = 5;
  /// Of all addresses together.
  std::size_t n_in_total = 50;
};

/// Counts wrong tokens: of one address, and in total. Not thread-safe.
class Attempts {
 public:
  explicit Attempts(AttemptLimits limits = {}) : limits_(limits) {}

  /// The time until this address may be wrong again; zero: now.
  std::chrono::seconds wait_of(const std::string& address, Now now);
  void note_wrong(const std::string& address, Now now);

 private:
  struct Wrong {
    Now at;
    std::string address;
  };
  void forget(Now now);

  AttemptLimits limits_;
  std::deque<Wrong> wrong_;  ///< the last ones, oldest first: never more than n_in_total
};

/// The part of an address that one computer cannot change at will: of IPv6 the first 64 bits.
std::string network_of(const std::string& address);

}  // namespace panelcal::serve
