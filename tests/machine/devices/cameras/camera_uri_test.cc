// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/cameras/camera_uri.h"

#include <string>
#include <variant>

#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

template <class Address>
Address address_of(const std::string& uri) {
  const auto parsed = parse_camera_uri(uri);
  EXPECT_TRUE(parsed) << parsed.error().text();
  const Address* address = parsed ? std::get_if<Address>(&*parsed) : nullptr;
  EXPECT_NE(address, nullptr) << uri;
  return address ? *address : Address();
}

TEST(CameraUri, NamesFoldersFilesAndDevices) {
  EXPECT_EQ(address_of<FolderAddress>("folder:a b/c").folder, "a b/c");
  const auto file = address_of<VideoAddress>("video:run 1.avi");
  EXPECT_EQ(file.kind, VideoAddress::Kind::File);
  EXPECT_EQ(file.what, "run 1.avi");
  const auto device = address_of<VideoAddress>("v4l2:/dev/video0");
  EXPECT_EQ(device.kind, VideoAddress::Kind::V4l2);
  EXPECT_EQ(device.what, "/dev/video0");
  EXPECT_EQ(device.width, 0);
  const auto held = address_of<VideoAddress>(
      "v4l2:/dev/video0?exposure_us=8000&gain=0&focus=30&white_balance_k=4600&power_line_hz=50");
  EXPECT_NEAR(held.settings.exposure.value().in_s(), 8e-3, 1e-12);
  EXPECT_EQ(held.settings.gain, 0);
  EXPECT_EQ(held.settings.focus, 30);
  EXPECT_EQ(held.settings.white_balance_K, 4600);
  EXPECT_EQ(held.settings.power_line_Hz, 50);
  EXPECT_FALSE(device.settings.exposure || device.settings.focus);
  const auto large = address_of<VideoAddress>("v4l2:/dev/video1?width=1280&height=960");
  EXPECT_EQ(large.what, "/dev/video1");
  EXPECT_EQ(large.width, 1280);
  EXPECT_EQ(large.height, 960);
  const auto stream = address_of<VideoAddress>("rtsp://me:secret@cam.local:554/live?channel=1");
  EXPECT_EQ(stream.kind, VideoAddress::Kind::Rtsp);
  EXPECT_EQ(stream.what, "rtsp://me:secret@cam.local:554/live?channel=1") << "passed on whole";
}

TEST(CameraUri, SetsUpAGigeCamera) {
  const auto plain = address_of<GigeAddress>("gige://192.168.1.20");
  EXPECT_EQ(plain.address, "192.168.1.20");
  EXPECT_EQ(plain.packet_bytes, 1500);
  EXPECT_FALSE(plain.exposure);
  EXPECT_FALSE(plain.gain);
  EXPECT_FALSE(plain.format);
  EXPECT_FALSE(plain.resend);
  const auto full = address_of<GigeAddress>(
      "gige://10.0.0.7/?packet=8192&exposure_us=1500.5&gain=-2&format=bayerRG8&timeout_ms=250&"
      "retries=3&resend=on");
  EXPECT_EQ(full.address, "10.0.0.7");
  EXPECT_EQ(full.packet_bytes, 8192);
  EXPECT_DOUBLE_EQ(full.exposure->in_s(), 1500.5e-6);
  EXPECT_EQ(full.gain, -2);
  EXPECT_EQ(full.format, "bayerRG8");
  EXPECT_DOUBLE_EQ(full.timeout.in_s(), 0.25);
  EXPECT_EQ(full.retries, 3);
  EXPECT_EQ(full.resend, true);
}

struct Malformed {
  const char* uri;
  const char* says;
};

TEST(CameraUri, SaysWhatIsWrong) {
  constexpr Malformed kCases[] = {
      {"", ""},
      {"/dev/video0", "folder:DIR"},
      {"giga://1.2.3.4", "gige"},
      {"usb:0", "\"usb\""},
      {"folder:", ""},
      {"video:", ""},
      {"v4l2:0", "\"0\""},
      {"v4l2:/dev/video0?fps=3", "\"fps\""},
      {"v4l2:/dev/video0?width=640", ""},
      {"v4l2:/dev/video0?power_line_hz=55", "\"55\""},
      {"v4l2:/dev/video0?focus=near", "\"near\""},
      {"v4l2:/dev/video0?exposure_us=0", "\"0\""},
      {"v4l2:/dev/video0?width=640&width=640", "\"width\""},
      {"v4l2:/dev/video0?width=-1&height=3", "100000"},
      {"rtsp:cam", ""},
      {"rtsp:///live", ""},
      {"gige:192.168.1.20", "//"},
      {"gige://", ""},
      {"gige://camera1", "\"camera1\""},
      {"gige://192.168.1.256", "IPv4"},
      {"gige://fe80::1", "IPv4"},
      {"gige://1.2.3.4?paket=9000", "packet"},
      {"gige://1.2.3.4?packet", "\"packet\""},
      {"gige://1.2.3.4?packet=", "\"packet\""},
      {"gige://1.2.3.4?packet=100", "576 to 65000"},
      {"gige://1.2.3.4?packet=1500.5", "576 to 65000"},
      {"gige://1.2.3.4?exposure_us=0", "exposure_us"},
      {"gige://1.2.3.4?exposure_us=nan", "exposure_us"},
      {"gige://1.2.3.4?gain=high", "gain=\"high\""},
      {"gige://1.2.3.4?retries=-1", "retries"},
      {"gige://1.2.3.4?timeout_ms=1e3", "timeout_ms"},
      {"gige://1.2.3.4?resend=yes", "resend=\"yes\""},
      {"gige://1.2.3.4?gain=1&&gain=2", "\"\""},
      {"folder:a\nb", ""},
  };
  for (const Malformed& bad : kCases) {
    EXPECT_THAT(parse_camera_uri(bad.uri), FailsWith(Code::CameraUri, bad.says)) << bad.uri;
  }
  EXPECT_THAT(parse_camera_uri(std::string_view("video:a\0b", 9)), FailsWith(Code::CameraUri));
}

TEST(CameraUri, IsShownWithoutItsPassword) {
  EXPECT_EQ(without_password("rtsp://me:secret@cam/live?a=b@c"), "rtsp://cam/live?a=b@c");
  EXPECT_EQ(without_password("rtsp://me:s@cret@cam"), "rtsp://cam");
  EXPECT_EQ(without_password("rtsp://cam/a@b"), "rtsp://cam/a@b");
  EXPECT_EQ(without_password("gige://1.2.3.4"), "gige://1.2.3.4");
  EXPECT_EQ(without_password(""), "");
  const auto bad = parse_camera_uri("rtsp://me:secret@/live\n");
  ASSERT_FALSE(bad);
  EXPECT_EQ(bad.error().text().find("secret"), std::string::npos);
}

TEST(OpenCamera, SaysWhatIsNotThere) {
  EXPECT_THAT(open_camera("folder:/nowhere"), FailsWith(Code::FileUnreadable, "folder"));
  EXPECT_THAT(open_camera("video:/nowhere.avi"), FailsWith(Code::FileUnreadable, "video"));
  EXPECT_THAT(open_camera("v4l2:/dev/nowhere"), FailsWith(Code::DeviceCamera, "/dev/video0"));
}

}  // namespace
}  // namespace panelcal
