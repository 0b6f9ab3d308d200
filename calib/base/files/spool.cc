// SPDX-License-Identifier: Apache-2.0
#include "calib/base/files/spool.h"

#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

namespace panelcal {
namespace {

tl::unexpected<Diagnostic> spool_failure(const std::string& what) {
  const int error = errno;
  return failure({Code::DeviceWrite,
                  {"temporary file", 0, 0},
                  what + ": " + std::generic_category().message(error),
                  ""});
}

}  // namespace

void Spool::clear() {
  memory_.clear();
  file_.reset();
}

Expected<void> Spool::write(std::string_view bytes) {
  if (file_ == nullptr) {
    memory_ += bytes;
    if (memory_.size() <= kInMemory) return {};
    file_.reset(std::tmpfile());
    if (file_ == nullptr) return spool_failure("cannot create");
    const std::string kept = std::exchange(memory_, {});
    return write(kept);
  }
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) == bytes.size()) return {};
  return spool_failure("cannot write");
}

Expected<void> Spool::pass_to(ByteSink& target) {
  if (file_ == nullptr) return target.write(memory_);
  if (std::fflush(file_.get()) != 0 || std::fseek(file_.get(), 0, SEEK_SET) != 0) {
    return spool_failure("cannot write");
  }
  std::array<char, std::size_t{1} << 16> piece{};
  std::size_t n = piece.size();
  while (n == piece.size()) {
    n = std::fread(piece.data(), 1, piece.size(), file_.get());
    if (n > 0) PANELCAL_CHECK(target.write(std::string_view(piece.data(), n)));
  }
  return std::ferror(file_.get()) == 0 ? Expected<void>() : spool_failure("cannot read");
}

}  // namespace panelcal
