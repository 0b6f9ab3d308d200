// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "calib/base/expected.h"

namespace panelcal::serve {

/// The token that a screen has to know, as a salt and a hash: who reads the file cannot log in.
class Token {
 public:
  Token(std::string salt, std::string hash) : salt_(std::move(salt)), hash_(std::move(hash)) {}
  bool is(std::string_view token) const;

 private:
  std::string salt_;
  std::string hash_;
};

struct OpenedToken {
  Token token;
  std::string made;  ///< the token itself, to be printed once; empty: the file was there
};

/// Reads the file of a token, or makes it with a new token if there is none: mode 0600, one line
/// `panelcal-token-1 SALT HASH`.
///
/// Fails  file-unreadable (no file of a token; others may read or write it); device-write
/// See    tests/tools/serve/access/token_file_test.cc
Expected<OpenedToken> open_token_file(const std::filesystem::path& path);

}  // namespace panelcal::serve
