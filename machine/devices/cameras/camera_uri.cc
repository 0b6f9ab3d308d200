// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/cameras/camera_uri.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "machine/devices/cameras/folder_camera.h"
#include <arpa/inet.h>
#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr std::array<std::string_view, 5> kSchemes = {"folder", "gige", "rtsp", "v4l2", "video"};
constexpr std::array<std::string_view, 7> kGigeKeys = {
    "exposure_us", "format", "gain", "packet", "resend", "retries", "timeout_ms"};
constexpr std::array<std::string_view, 7> kV4l2Keys = {
    "exposure_us", "focus", "gain", "height", "power_line_hz", "white_balance_k", "width"};

tl::unexpected<Diagnostic> refuse(std::string_view uri, std::string what, std::string expected) {
  return failure({Code::CameraUri,
                  {"camera " + quoted(without_password(uri)), 0, 0},
                  std::move(what),
                  std::move(expected)});
}

struct Parameter {
  std::string key;
  std::string value;
};

/// Parameters behind "?": key=value&key=value, each key once.
Expected<std::vector<Parameter>> parameters_of(std::string_view uri,
                                               std::string_view query,
                                               std::span<const std::string_view> known) {
  std::vector<Parameter> parameters;
  std::set<std::string_view> seen;
  while (!query.empty()) {
    const std::string_view one = query.substr(0, query.find('&'));
    query.remove_prefix(std::min(one.size() + 1, query.size()));
    const auto equals = one.find('=');
    const std::string_view key = one.substr(0, equals);
    if (std::ranges::find(known, key) == known.end()) {
      const std::string_view near = nearest_word(key, known);
      return refuse(uri,
                    "there is no parameter " + quoted(key),
                    near.empty() ? fmt::format("{}", fmt::join(known, ", "))
                                 : "did you mean " + quoted(near) + "?");
    }
    if (equals == one.npos || equals + 1 == one.size()) {
      return refuse(uri, quoted(key) + " has no value", std::string(key) + "=VALUE");
    }
    if (!seen.insert(key).second) return refuse(uri, quoted(key) + " is given twice", "once");
    parameters.push_back({std::string(key), std::string(one.substr(equals + 1))});
  }
  return parameters;
}

Expected<double> number_of(std::string_view uri, const Parameter& p, double low, double high) {
  double value = 0;
  const char* const end = p.value.data() + p.value.size();
  const auto [stop, error] = std::from_chars(p.value.data(), end, value);
  if (error == std::errc() && stop == end && value >= low && value <= high) return value;
  return refuse(
      uri, p.key + "=" + quoted(p.value), fmt::format("a number from {} to {}", low, high));
}

Expected<int> integer_of(std::string_view uri, const Parameter& p, int low, int high) {
  int value = 0;
  const char* const end = p.value.data() + p.value.size();
  const auto [stop, error] = std::from_chars(p.value.data(), end, value);
  if (error == std::errc() && stop == end && value >= low && value <= high) return value;
  return refuse(
      uri, p.key + "=" + quoted(p.value), fmt::format("a whole number from {} to {}", low, high));
}

Expected<void> set_gige(std::string_view uri, const Parameter& p, GigeAddress& gige) {
  // From the least packet that GigE Vision knows to the largest that UDP carries.
  constexpr int kLeastPacket = 576;
  constexpr int kLargestPacket = 65'000;
  constexpr double kLongest_us = 1e8;
  constexpr int kLongest_ms = 60'000;
  constexpr int kMostRetries = 1000;
  constexpr double kMostGain = 1e6;
  if (p.key == "packet") {
    PANELCAL_TRY(gige.packet_bytes, integer_of(uri, p, kLeastPacket, kLargestPacket));
  } else if (p.key == "exposure_us") {
    PANELCAL_TRY(const double exposure_us, number_of(uri, p, 1, kLongest_us));
    gige.exposure = seconds(exposure_us * 1e-6);
  } else if (p.key == "gain") {
    PANELCAL_TRY(gige.gain, number_of(uri, p, -kMostGain, kMostGain));
  } else if (p.key == "timeout_ms") {
    PANELCAL_TRY(const int timeout_ms, integer_of(uri, p, 10, kLongest_ms));
    gige.timeout = seconds(timeout_ms * 1e-3);
  } else if (p.key == "retries") {
    PANELCAL_TRY(gige.retries, integer_of(uri, p, 0, kMostRetries));
  } else if (p.key == "resend") {
    if (p.value != "on" && p.value != "off") {
      return refuse(uri, "resend=" + quoted(p.value), "on or off");
    }
    gige.resend = p.value == "on";
  } else {
    gige.format = p.value;
  }
  return {};
}

Expected<CameraAddress> parse_gige(std::string_view uri, std::string_view rest) {
  constexpr std::string_view kForm = "gige://192.168.1.20, the camera's IPv4 address";
  if (!rest.starts_with("//"))
    return refuse(uri, "there is no // behind gige:", std::string(kForm));
  rest.remove_prefix(2);
  const auto query = rest.find('?');
  GigeAddress gige{.address = std::string(rest.substr(0, query))};
  if (gige.address.ends_with('/')) gige.address.pop_back();
  in_addr ignored{};
  if (inet_pton(AF_INET, gige.address.c_str(), &ignored) != 1) {
    return refuse(uri,
                  gige.address.empty() ? "the address is missing"
                                       : panelcal::quoted(gige.address) + " is no IPv4 address",
                  std::string(kForm));
  }
  if (query == rest.npos) return gige;
  PANELCAL_TRY(const auto parameters, parameters_of(uri, rest.substr(query + 1), kGigeKeys));
  for (const Parameter& p : parameters) PANELCAL_CHECK(set_gige(uri, p, gige));
  return gige;
}

Expected<void> set_v4l2(std::string_view uri, const Parameter& p, VideoAddress& video) {
  constexpr int kLargest_px = 100'000;
  constexpr double kLongest_us = 1e8;
  constexpr int kMost = 1'000'000;
  V4l2Settings& settings = video.settings;
  if (p.key == "exposure_us") {
    PANELCAL_TRY(const double exposure_us, number_of(uri, p, 1, kLongest_us));
    settings.exposure = seconds(exposure_us * 1e-6);
  } else if (p.key == "focus") {
    PANELCAL_TRY(settings.focus, integer_of(uri, p, -kMost, kMost));
  } else if (p.key == "gain") {
    PANELCAL_TRY(settings.gain, integer_of(uri, p, -kMost, kMost));
  } else if (p.key == "white_balance_k") {
    PANELCAL_TRY(settings.white_balance_K, integer_of(uri, p, 1, kMost));
  } else if (p.key == "power_line_hz") {
    if (p.value != "0" && p.value != "50" && p.value != "60") {
      return refuse(uri, "power_line_hz=" + quoted(p.value), "0 (off), 50 or 60");
    }
    PANELCAL_TRY(settings.power_line_Hz, integer_of(uri, p, 0, 60));
  } else {
    PANELCAL_TRY((p.key == "width" ? video.width : video.height),
                 integer_of(uri, p, 1, kLargest_px));
  }
  return {};
}

Expected<CameraAddress> parse_v4l2(std::string_view uri, std::string_view rest) {
  const auto query = rest.find('?');
  VideoAddress video{.kind = VideoAddress::Kind::V4l2, .what = std::string(rest.substr(0, query))};
  if (!video.what.starts_with('/')) {
    return refuse(
        uri, panelcal::quoted(video.what) + " is no device", "a path such as /dev/video0");
  }
  if (query == rest.npos) return video;
  PANELCAL_TRY(const auto parameters, parameters_of(uri, rest.substr(query + 1), kV4l2Keys));
  for (const Parameter& p : parameters) PANELCAL_CHECK(set_v4l2(uri, p, video));
  if ((video.width > 0) != (video.height > 0)) {
    return refuse(uri, "only one side of the picture is given", "width and height");
  }
  return video;
}

}  // namespace

Expected<CameraAddress> parse_camera_uri(std::string_view uri) {
  // An address is shown in messages and given to C libraries, which end at a zero byte.
  for (const char c : uri) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f) return refuse(uri, "a control character", "printable text");
  }
  const auto colon = uri.find(':');
  const std::string_view scheme = uri.substr(0, colon);
  if (colon == uri.npos || std::ranges::find(kSchemes, scheme) == kSchemes.end()) {
    const std::string_view near = nearest_word(scheme, kSchemes);
    return refuse(
        uri,
        colon == uri.npos ? "there is no colon" : quoted(scheme) + " is no kind of camera",
        colon == uri.npos || near.empty()
            ? "folder:DIR, video:FILE, v4l2:DEVICE, rtsp://... or gige://ADDRESS"
            : "did you mean " + quoted(near) + "?");
  }
  const std::string_view rest = uri.substr(colon + 1);
  if (rest.empty()) return refuse(uri, "nothing follows " + quoted(uri), "a name or an address");
  if (scheme == "folder") return FolderAddress{std::string(rest)};
  if (scheme == "gige") return parse_gige(uri, rest);
  if (scheme == "v4l2") return parse_v4l2(uri, rest);
  if (scheme == "video") return VideoAddress{.what = std::string(rest)};
  if (!rest.starts_with("//") || rest.size() == 2 || rest[2] == '/') {
    return refuse(uri, "there is no host", "rtsp://HOST/PATH");
  }
  return VideoAddress{.kind = VideoAddress::Kind::Rtsp, .what = std::string(uri)};
}

Expected<std::unique_ptr<CameraDevice>> open_camera(std::string_view uri) {
  PANELCAL_TRY(const CameraAddress address, parse_camera_uri(uri));
  if (const auto* folder = std::get_if<FolderAddress>(&address)) {
    return open_folder_camera(folder->folder);
  }
  if (const auto* video = std::get_if<VideoAddress>(&address)) return open_opencv_camera(*video);
  return open_gige_camera(std::get<GigeAddress>(address));
}

}  // namespace panelcal
