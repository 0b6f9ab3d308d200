// SPDX-License-Identifier: Apache-2.0
#include "panelcal/vision/image_io.h"

#include <exception>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "panelcal/calib/base/atomic_file.h"
#include "panelcal/vision/cv_bridge.h"
#include "panelcal/vision/image_header.h"
#include "panelcal/vision/stderr_capture.h"

namespace panelcal {
namespace {

using internal::PictureKind;

constexpr std::size_t kMaxFileBytes = std::size_t{1} << 30;
constexpr std::string_view kKinds = "PNG, TIFF, BMP or JPEG of 8 or 16 bit";

tl::unexpected<Diagnostic> problem(Code code,
                                   std::string_view name,
                                   std::string what,
                                   std::string expected) {
  return failure({code, {std::string(name), 0, 0}, std::move(what), std::move(expected)});
}

/// A decoder's picture, or empty, and what it had to say.
struct Decoded {
  cv::Mat mat;
  std::string messages;
};

Decoded run_decoder(std::string_view bytes) {
  Decoded decoded;
  internal::StderrCapture capture;
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

/// Luma as float; empty if the number of channels is none that pictures have.
std::optional<cv::Mat> grey_of(const cv::Mat& mat) {
  cv::Mat grey;
  mat.convertTo(grey, CV_32F);
  // In float, so that luma is not rounded to whole levels.
  if (mat.channels() == 1) return grey;
  if (mat.channels() == 3) {
    cv::cvtColor(grey, grey, cv::COLOR_BGR2GRAY);
    return grey;
  }
  if (mat.channels() == 4) {
    cv::cvtColor(grey, grey, cv::COLOR_BGRA2GRAY);
    return grey;
  }
  return std::nullopt;
}

Expected<Image> image_of(const cv::Mat& mat, std::string_view name) {
  const bool is_16_bit = mat.depth() == CV_16U;
  if (mat.depth() != CV_8U && !is_16_bit) {
    return problem(
        Code::PictureFormat, name, "pixels are floating-point or signed numbers", "8 or 16 bit");
  }
  const std::optional<cv::Mat> grey = grey_of(mat);
  if (!grey) {
    return problem(
        Code::PictureFormat, name, fmt::format("{} channels", mat.channels()), "grey, RGB or RGBA");
  }
  Image image(mat.cols, mat.rows, is_16_bit ? Image::kFullScale16 : Image::kFullScale8);
  for (int y = 0; y < mat.rows; ++y) {
    const float* from = grey->ptr<float>(y);
    std::copy(from, from + mat.cols, image.row(y).begin());
  }
  return image;
}

Expected<void> check_header(std::string_view bytes, std::string_view name, PictureKind kind) {
  const auto header = internal::picture_header(bytes, kind);
  if (!header) {
    return problem(Code::PictureDamaged,
                   name,
                   fmt::format("the {} header is cut off or makes no sense", internal::name(kind)),
                   "a whole picture");
  }
  // Divided, since the product of two claims may overflow.
  if (header->width > kMaxPicturePixels / header->height) {
    return problem(Code::PictureTooLarge,
                   name,
                   fmt::format("{} x {} pixels", header->width, header->height),
                   fmt::format("at most {} pixels", kMaxPicturePixels));
  }
  if (!internal::has_end_mark(bytes, kind)) {
    return problem(Code::PictureDamaged,
                   name,
                   fmt::format("the {} file is cut off", internal::name(kind)),
                   "a whole picture");
  }
  return {};
}

/// The decoder's words in one printable line.
std::string reason_of(const Decoded& decoded) {
  if (decoded.messages.empty()) return "";
  const std::size_t end = decoded.messages.find('\n');
  return ": " + panelcal::quoted(decoded.messages.substr(0, end), 160);
}

}  // namespace

namespace internal {

cv::Mat mat_of(const Image& image) {
  // The Mat only looks at the pixels; convertTo rounds, clips and copies.
  const cv::Mat view(
      image.height(), image.width(), CV_32FC1, const_cast<float*>(image.pixels().data()));
  cv::Mat mat;
  view.convertTo(mat, image.full_scale() > Image::kFullScale8 ? CV_16U : CV_8U);
  return mat;
}

Expected<std::string> png_of(const cv::Mat& mat) {
  std::vector<unsigned char> bytes;
  std::string why = "no pixels";
  try {
    if (!mat.empty() && cv::imencode(".png", mat, bytes)) {
      return std::string(bytes.begin(), bytes.end());
    }
  } catch (const std::exception& e) {
    why = e.what();
  }
  return problem(
      Code::PictureFormat, "", "cannot encode a picture: " + panelcal::quoted(why), "a picture");
}

}  // namespace internal

Expected<Image> decode_image(std::string_view bytes, std::string_view name) {
  const std::optional<PictureKind> kind = internal::picture_kind(bytes);
  if (!kind) {
    return problem(Code::PictureFormat,
                   name,
                   bytes.empty() ? "the file is empty" : "not a picture of a known kind",
                   std::string(kKinds));
  }
  PANELCAL_CHECK(check_header(bytes, name, *kind));
  const Decoded decoded = run_decoder(bytes);
  // JPEG decoders go on after damage with made-up pixels, and only say so.
  const bool patched = *kind == PictureKind::Jpeg && !decoded.messages.empty();
  if (decoded.mat.empty() || patched) {
    return problem(
        Code::PictureDamaged,
        name,
        fmt::format("the {} does not decode{}", internal::name(*kind), reason_of(decoded)),
        "a whole picture");
  }
  return image_of(decoded.mat, name);
}

Expected<Image> read_image(const std::filesystem::path& path) {
  PANELCAL_TRY(const std::string bytes, read_file(path, kMaxFileBytes));
  return decode_image(bytes, path.string());
}

Expected<std::string> encode_png(const Image& image) {
  return internal::png_of(internal::mat_of(image));
}

Expected<void> write_png(const std::filesystem::path& path, const Image& image) {
  PANELCAL_TRY(const std::string bytes, encode_png(image));
  return write_file(path, bytes);
}

}  // namespace panelcal
