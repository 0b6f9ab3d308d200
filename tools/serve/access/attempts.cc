// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/access/attempts.h"

#include <algorithm>
#include <array>
#include <optional>

#include <arpa/inet.h>

namespace panelcal::serve {

std::string network_of(const std::string& address) {
  std::array<unsigned char, 16> bytes{};
  const std::string bare = address.substr(0, address.find('%'));
  if (::inet_pton(AF_INET6, bare.c_str(), bytes.data()) != 1) return address;
  constexpr std::array<unsigned char, 12> kMapped = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff};
  if (std::equal(kMapped.begin(), kMapped.end(), bytes.begin())) return address;
  std::fill(bytes.begin() + 8, bytes.end(), static_cast<unsigned char>(0));
  std::array<char, INET6_ADDRSTRLEN> text{};
  ::inet_ntop(AF_INET6, bytes.data(), text.data(), text.size());
  return text.data();
}

void Attempts::forget(Now now) {
  while (!wrong_.empty() && now - wrong_.front().at >= limits_.window) wrong_.pop_front();
}

std::chrono::seconds Attempts::wait_of(const std::string& address, Now now) {
  forget(now);
  const std::string network = network_of(address);
  const auto is_own = [&](const Wrong& wrong) { return wrong.address == network; };
  // The attempt that has to be forgotten before another one is allowed.
  std::optional<Now> oldest;
  if (wrong_.size() >= limits_.n_in_total) oldest = wrong_.front().at;
  const auto n_own = static_cast<std::size_t>(std::ranges::count_if(wrong_, is_own));
  if (n_own >= limits_.n_per_address) oldest = std::ranges::find_if(wrong_, is_own)->at;
  if (!oldest) return std::chrono::seconds(0);
  return std::chrono::ceil<std::chrono::seconds>(*oldest + limits_.window - now);
}

void Attempts::note_wrong(const std::string& address, Now now) {
  forget(now);
  wrong_.push_back({now, network_of(address)});
  if (wrong_.size() > limits_.n_in_total) wrong_.pop_front();
}

}  // namespace panelcal::serve
