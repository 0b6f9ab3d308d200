// SPDX-License-Identifier: Apache-2.0
#include "tools/serve/access/token_file.h"

#include <array>
#include <cerrno>
#include <optional>
#include <sstream>
#include <system_error>

#include "tools/serve/access/secret.h"
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

namespace panelcal::serve {
namespace {

constexpr std::string_view kForm = "panelcal-token-1";

std::string system_words(int error) {
  return std::generic_category().message(error);
}

/// Created by open() with its mode, so that at no moment others can read it; never replaced.
Expected<void> write_new(const std::filesystem::path& path, const std::string& text) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
  const bool is_whole =
      file >= 0 && ::write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size()) &&
      ::fsync(file) == 0;
  const int error = errno;
  if (file >= 0) ::close(file);
  if (is_whole) return {};
  if (file >= 0) ::unlink(path.c_str());
  return failure({Code::DeviceWrite, {path.string(), 0, 0}, system_words(error), ""});
}

std::optional<Token> parse(const std::string& text) {
  std::istringstream words(text);
  std::string form;
  std::string salt;
  std::string hash;
  words >> form >> salt >> hash;
  if (form != kForm || salt.size() < 16 || hash.size() != 64) return std::nullopt;
  return Token(salt, hash);
}

/// The text of the file; nothing: there is none. Opened once, so that what is checked is what is
/// read.
Expected<std::optional<std::string>> read_own(const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (file < 0 && errno == ENOENT) return std::optional<std::string>();
  struct stat status {};
  std::array<char, 4096> text{};
  const bool is_seen = file >= 0 && ::fstat(file, &status) == 0;
  const bool is_file = is_seen && S_ISREG(status.st_mode);
  const ssize_t n = is_file ? ::read(file, text.data(), text.size()) : -1;
  const int error = is_seen && !is_file ? EINVAL : errno;
  if (file >= 0) ::close(file);
  if (n < 0) return failure({Code::FileUnreadable, {path.string(), 0, 0}, system_words(error), ""});
  if ((status.st_mode & (S_IRWXG | S_IRWXO)) != 0 || status.st_uid != ::geteuid()) {
    return failure({Code::FileUnreadable,
                    {path.string(), 0, 0},
                    fmt::format("other users have access to the token's hash, mode {:o}",
                                status.st_mode & 0777U),
                    "a file of this user with mode 600 (chmod 600)"});
  }
  return std::string(text.data(), static_cast<std::size_t>(n));
}

}  // namespace

bool Token::is(std::string_view token) const {
  return is_equal_in_constant_time(salted_hash(salt_, token), hash_);
}

Expected<OpenedToken> open_token_file(const std::filesystem::path& path) {
  PANELCAL_TRY(const std::optional<std::string> text, read_own(path));
  if (!text) {
    const std::string token = random_secret();
    const std::string salt = random_secret();
    const std::string hash = salted_hash(salt, token);
    PANELCAL_CHECK(write_new(path, fmt::format("{} {} {}\n", kForm, salt, hash)));
    return OpenedToken{Token(salt, hash), token};
  }
  std::optional<Token> token = parse(*text);
  if (!token) {
    return failure({Code::FileUnreadable,
                    {path.string(), 0, 0},
                    fmt::format("not the file of a token: {}", quoted(*text, 20)),
                    "a file that serve made, or a new name"});
  }
  return OpenedToken{*std::move(token), ""};
}

}  // namespace panelcal::serve
