// SPDX-License-Identifier: Apache-2.0
#include "vision/picture/decoder.h"

#include <algorithm>
#include <array>
#include <exception>

#include "calib/base/diagnostic.h"
#include "vision/picture/stderr_capture.h"
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>

namespace panelcal::internal {
namespace {

/// Makes OpenCV pass on what its TIFF library says, which it does at this level only.
class TalkativeTiff {
 public:
  explicit TalkativeTiff(bool is_wanted) : before_(cv::utils::logging::getLogLevel()) {
    if (is_wanted) cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_DEBUG);
  }
  ~TalkativeTiff() { cv::utils::logging::setLogLevel(before_); }
  TalkativeTiff(const TalkativeTiff&) = delete;
  TalkativeTiff& operator=(const TalkativeTiff&) = delete;

 private:
  cv::utils::logging::LogLevel before_;
};

/// True if the decoder's words say no more than that a directory has entries it does not know.
bool is_harmless(std::string_view messages) {
  constexpr std::array<std::string_view, 3> kHarmless = {
      "Unknown field with tag", "does not end in null byte", "tags are not sorted"};
  // Words beyond what is captured might be of damage.
  if (messages.size() >= internal::StderrCapture::kMaxText - 1) return false;
  while (!messages.empty()) {
    const std::size_t end = std::min(messages.find('\n'), messages.size());
    const std::string_view line = messages.substr(0, end);
    const bool is_known = std::any_of(kHarmless.begin(), kHarmless.end(), [&](const auto& words) {
      return line.find(words) != std::string_view::npos;
    });
    if (!line.empty() && !is_known) return false;
    messages.remove_prefix(std::min(end + 1, messages.size()));
  }
  return true;
}

}  // namespace

Decoded run_decoder(std::string_view bytes, PictureKind kind) {
  Decoded decoded;
  StderrCapture capture;
  const TalkativeTiff talkative(kind == PictureKind::Tiff);
  std::string thrown;
  try {
    const cv::Mat input(1,
                        static_cast<int>(bytes.size()),
                        CV_8UC1,
                        const_cast<char*>(bytes.data()));  // imdecode only reads
    decoded.mat = cv::imdecode(input, cv::IMREAD_UNCHANGED | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const std::exception& e) {
    thrown = e.what();
  }
  decoded.messages = capture.finish();
  if (decoded.messages.empty()) decoded.messages = thrown;
  return decoded;
}

bool is_patched(const Decoded& decoded, PictureKind kind) {
  if (kind == PictureKind::Jpeg) return !decoded.messages.empty();
  return kind == PictureKind::Tiff && !is_harmless(decoded.messages);
}

std::string reason_of(const Decoded& decoded) {
  if (decoded.messages.empty()) return "";
  const std::size_t end = decoded.messages.find('\n');
  return ": " + panelcal::quoted(decoded.messages.substr(0, end), 160);
}

}  // namespace panelcal::internal
