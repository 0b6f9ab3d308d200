// SPDX-License-Identifier: Apache-2.0
#include "machine/init/machine_text.h"

#include <algorithm>
#include <array>
#include <regex>
#include <tuple>

#include "calib/base/append_format.h"
#include "machine/config/machine_file.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::append_format;

/// What a kind has where its owner says nothing.
struct Usual {
  MachineKind kind;
  std::string_view name;
  std::string_view summary;
  std::string_view camera;
  double pixel_um;
  std::pair<int, int> picture_px;
  std::string_view fiducial_mm;
  std::string_view position_um;
};

constexpr auto kUsual = std::to_array<Usual>({
    {MachineKind::UsbCameraLinuxCnc,
     "usb-camera-linuxcnc",
     "a mill or router with LinuxCNC, and a USB camera",
     "v4l2:/dev/video0?width=640&height=480",
     20,
     {640, 480},
     "1",
     "125"},
    {MachineKind::UsbCameraGrbl,
     "usb-camera-grbl",
     "a mill or router with GRBL, grblHAL or FluidNC, and a USB camera",
     "v4l2:/dev/video0?width=640&height=480",
     20,
     {640, 480},
     "1",
     "125"},
    {MachineKind::GigeCnc7,
     "gige-cnc7",
     "a drilling machine that reads Excellon CNC-7, and a GigE Vision camera",
     "gige://192.168.1.20?exposure_us=2000&format=mono8",
     10,
     {1280, 1024},
     "2",
     "25"},
    {MachineKind::Folder,
     "folder",
     "pictures in folders, without a machine",
     "",
     10,
     {1280, 1024},
     "2",
     "25"},
});

const Usual& usual(MachineKind kind) {
  return *std::ranges::find(kUsual, kind, &Usual::kind);
}

/// Help without Markdown: `[text](../howto/grbl.md#key)` is "text, docs/howto/grbl.md".
std::string plain(std::string_view help) {
  static const std::regex to_other_folder(R"(\[([^\]]*)\]\(\.\./([^)#]*)[^)]*\))");
  static const std::regex to_neighbour(R"(\[([^\]]*)\]\(([^)#]*)[^)]*\))");
  std::string out = std::regex_replace(std::string(help), to_other_folder, "$1, docs/$2");
  return std::regex_replace(out, to_neighbour, "$1, docs/formats/$2");
}

/// As comments of at most 100 characters a line.
void append_comment(std::string& out, std::string_view text) {
  constexpr std::size_t kMax = 98;
  while (!text.empty()) {
    std::size_t end = text.size();
    if (end > kMax) {
      const std::size_t space = text.substr(0, kMax + 1).rfind(' ');
      end = space == std::string_view::npos ? kMax : space;
    }
    append_format(out, "# {}\n", text.substr(0, end));
    text.remove_prefix(end);
    if (text.starts_with(' ')) text.remove_prefix(1);
  }
}

/// In quotes, as TOML's basic strings are.
std::string quoted_toml(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < ' ' || c == 0x7f) {
      out += fmt::format("\\u{:04X}", static_cast<unsigned char>(c));
    } else {
      out += c;
    }
  }
  return out + '"';
}

/// Writes tables and keys with their help out of the description of machine.toml.
class MachineText {
 public:
  explicit MachineText(std::string& out) : out_(out) {}

  void begin(std::string_view table) {
    const auto found = std::ranges::find(
        file_.tables, table, [](const auto* described) { return described->name; });
    table_ = *found;
    name_ = table;
    append_format(out_, "\n{}\n", table_->heading());
  }

  void say(std::string_view key, const std::string& value) { say(key, value, ""); }

  /// A number that was not measured; `how` it is measured.
  void assume(std::string_view key, const std::string& value, std::string_view how) {
    say(key, value, fmt::format("  # assumed; {}", how));
  }

 private:
  /// A table may be described in several parts.
  void say(std::string_view key, const std::string& value, std::string_view remark) {
    for (const internal::TableDescription* const table : file_.tables) {
      if (table->name != name_) continue;
      const auto field = std::ranges::find(table->fields, key, &internal::Field::key);
      if (field != table->fields.end()) append_comment(out_, plain(field->meaning));
    }
    append_format(out_, "{} = {}{}\n", key, value, remark);
  }

  std::string& out_;
  internal::FileDescription file_ = internal::machine_file();
  const internal::TableDescription* table_ = nullptr;
  std::string_view name_;
};

std::string in_mm(Length length) {
  return fmt::format("{}", length.in_mm());
}

std::string in_mm(const std::pair<Length, Length>& place) {
  return fmt::format("[{}, {}]", place.first.in_mm(), place.second.in_mm());
}

bool has_driver(MachineKind kind) {
  return kind == MachineKind::UsbCameraLinuxCnc || kind == MachineKind::UsbCameraGrbl;
}

void say_machine(const MachineAnswers& answers, MachineText& text) {
  text.begin("machine");
  text.say("name", quoted_toml(answers.name));
  if (answers.travel_low) text.say("travel_low_mm", in_mm(*answers.travel_low));
  if (answers.travel_high) text.say("travel_high_mm", in_mm(*answers.travel_high));
  if (answers.kind == MachineKind::Folder) return;
  if (answers.kind == MachineKind::GigeCnc7) {
    text.say("stage_command", "[\"./drive\", \"{x}\", \"{y}\"]");
    return text.assume("settle_s", "0.1", "panelcal calibrate settle");
  }
  const bool is_grbl = answers.kind == MachineKind::UsbCameraGrbl;
  text.say("driver", is_grbl ? "\"grbl\"" : "\"linuxcnc\"");
  if (!answers.host.empty()) text.say("host", quoted_toml(answers.host));
  if (is_grbl && answers.host.empty()) {
    text.say("device", quoted_toml(answers.device.empty() ? "/dev/ttyUSB0" : answers.device));
  }
  if (answers.safe_z) {
    text.say("safe_z_mm", in_mm(*answers.safe_z));
  } else {
    text.assume("safe_z_mm", "-1", "just below the Z axis's home: look where Z is clear of all");
  }
  text.assume("settle_s", "0.3", "panelcal calibrate settle");
}

void say_vision(const MachineAnswers& answers, MachineText& text) {
  text.begin("vision");
  text.say("search_radius_mm", "1.5");
  std::vector<std::string> sizes_mm;
  for (const Length size : answers.fiducials) sizes_mm.push_back(in_mm(size));
  if (sizes_mm.empty()) sizes_mm.emplace_back(usual(answers.kind).fiducial_mm);
  for (std::size_t i = 0; i < sizes_mm.size(); ++i) {
    text.begin("vision.tool");
    text.say("number", std::to_string(i + 1));
    text.say("shape", "\"disc\"");
    text.say("size_mm", sizes_mm[i]);
    text.say("polarity", "\"bright\"");
  }
}

void say_spindle(const MachineAnswers& answers, MachineText& text) {
  text.begin("camera");
  const std::string file =
      answers.calibration.empty() ? std::string(kAssumedCameraFile) : answers.calibration;
  text.say("calibration", quoted_toml(file));
  if (answers.kind == MachineKind::Folder) return;
  text.begin("spindle");
  if (answers.camera_offset) {
    text.say("camera_offset_mm", in_mm(*answers.camera_offset));
  } else {
    text.assume("camera_offset_mm", "[50, 0]", "measure it roughly, then calibrate spindle-camera");
  }
  if (answers.camera_offset_sigma) {
    text.say("camera_offset_sigma_um", fmt::format("{}", answers.camera_offset_sigma->in_um()));
  } else {
    text.assume("camera_offset_sigma_um", "1000", "panelcal calibrate spindle-camera");
  }
}

void say_limits(const MachineAnswers& answers, MachineText& text) {
  const bool is_precise = !has_driver(answers.kind);
  text.begin("gates");
  text.say("residual_um", is_precise ? "20" : "50");
  text.say("offset_mm", "1.5");
  text.begin("tolerance");
  text.say("position_um", std::string(usual(answers.kind).position_um));
  text.begin("uncertainty");
  const std::string_view how = "from the machine's data sheet, or panelcal calibrate table";
  text.assume("stage_repeatability_um", is_precise ? "2" : "10", how);
  text.assume("table_residual_um", is_precise ? "2" : "15", how);
  text.assume("drill_wander_um", is_precise ? "4" : "10", "measure drilled holes");
}

void say_gcode(MachineText& text) {
  text.begin("gcode");
  text.say("safe_z_mm", "5");
  text.assume("board_z_mm", "0", "work Z is zero on the board");
  text.assume("table_z_mm", "-1.6", "the board's thickness");
  text.assume("drill_z_mm", "-1.8", "through the board");
  text.assume("rout_z_mm", "-1.8", "through the board");
  text.assume("infeed_mm_s", "5", "the drill's data sheet");
  text.assume("feed_mm_s", "5", "the router's data sheet");
  text.assume("speed_rpm", "20000", "the spindle's");
}

std::string head(const MachineAnswers& answers, std::string_view file) {
  const std::string_view camera =
      answers.camera ? std::string_view(*answers.camera) : usual(answers.kind).camera;
  const bool is_live = answers.kind != MachineKind::Folder;
  const std::string source = is_live ? fmt::format("--camera '{}'", camera) : "--images PICTURES";
  std::string out = fmt::format("# {}\n#\n", usual(answers.kind).summary);
  append_comment(out,
                 "A line with \"assumed\" holds a number that was not measured on this machine. "
                 "Jobs are held while such a number makes holes too unsure for [tolerance].");
  append_format(out, "#\n#   panelcal check -m {}\n", file);
  if (answers.calibration.empty() && is_live) {
    append_format(out,
                  "#   panelcal calibrate camera -m {} {} --at X,Y -o measured.cal.json\n"
                  "#     (X,Y: any pad of tool 1; then name measured.cal.json under [camera])\n",
                  file,
                  source);
  }
  if (is_live) {
    append_format(out,
                  "#   panelcal calibrate spindle-camera -m {} {}\n"
                  "#     (with [coupon] and drill_command, as docs/howto/nightly.md says)\n",
                  file,
                  source);
  }
  append_format(out,
                "#   panelcal run job.exc -m {} {} -o corrected.{}\n",
                file,
                source,
                has_driver(answers.kind) ? "ngc" : "drl");
  return out;
}

}  // namespace

std::string_view name(MachineKind kind) {
  return usual(kind).name;
}

std::optional<MachineKind> machine_kind_from_name(std::string_view name) {
  const auto found = std::ranges::find(kUsual, name, &Usual::name);
  return found == kUsual.end() ? std::nullopt : std::optional(found->kind);
}

std::string_view summary(MachineKind kind) {
  return usual(kind).summary;
}

std::string machine_text(const MachineAnswers& answers, std::string_view file) {
  std::string out = head(answers, file);
  MachineText text(out);
  say_machine(answers, text);
  say_vision(answers, text);
  say_spindle(answers, text);
  say_limits(answers, text);
  if (has_driver(answers.kind)) say_gcode(text);
  return out;
}

CameraCalibration assumed_camera(const MachineAnswers& answers, std::chrono::sys_seconds date) {
  constexpr double kScaleSigma = 0.02, kRotationSigma_rad = 0.05, kAxisSigma_px = 20;
  const Usual& of_kind = usual(answers.kind);
  CameraCalibration calibration;
  std::tie(calibration.picture_width_px, calibration.picture_height_px) =
      answers.picture_px.value_or(of_kind.picture_px);
  const double scale_mm_per_px = answers.pixel ? answers.pixel->in_mm() : of_kind.pixel_um * 1e-3;
  calibration.parameters.scale_mm_per_px = scale_mm_per_px;
  calibration.parameters.axis_px = {(calibration.picture_width_px - 1) / 2.0,
                                    (calibration.picture_height_px - 1) / 2.0};
  const Eigen::Vector<double, 5> sigmas(
      kScaleSigma * scale_mm_per_px, kRotationSigma_rad, kAxisSigma_px, kAxisSigma_px, 0);
  calibration.covariance = sigmas.cwiseAbs2().asDiagonal();
  calibration.date = date;
  calibration.provenance = "assumed by panelcal init, not measured";
  return calibration;
}

}  // namespace panelcal
