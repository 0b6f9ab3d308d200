// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace panelcal::gather {

/// True for "postgresql://..." and "postgres://...".
inline bool is_postgresql(std::string_view address) {
  return address.starts_with("postgresql://") || address.starts_with("postgres://");
}

/// A word of a command line without the password of the PostgreSQL address that it has, for
/// messages and files. Other text stays as it is.
inline std::string without_database_password(std::string_view word) {
  std::string text(word);
  const std::size_t scheme = text.find("postgres");
  if (scheme == std::string::npos || !is_postgresql(std::string_view(text).substr(scheme))) {
    return text;
  }
  // postgresql://USER:PASSWORD@HOST/..., and ...?password=PASSWORD.
  const std::size_t user = text.find("//", scheme) + 2;
  const std::size_t path = std::min(text.find_first_of("/?", user), text.size());
  const std::size_t at = text.rfind('@', path);
  const std::size_t colon = text.find(':', user);
  if (at != std::string::npos && at >= user && colon < at) text.erase(colon, at - colon);
  constexpr std::string_view kKey = "password=";
  for (std::size_t key = text.find(kKey); key != std::string::npos; key = text.find(kKey, key)) {
    const std::size_t end = std::min(text.find('&', key), text.size());
    text.erase(key, std::min(end + 1, text.size()) - key);
  }
  while (text.ends_with('?') || text.ends_with('&')) text.pop_back();
  return text;
}

}  // namespace panelcal::gather
