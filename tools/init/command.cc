// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <filesystem>
#include <iostream>
#include <string>
#include <utility>

#include "calib/base/clock.h"
#include "calib/base/files/atomic_file.h"
#include "machine/config/machine_config.h"
#include "machine/init/machine_text.h"
#include "tools/cli/commands.h"
#include "tools/cli/output_paths.h"
#include <fmt/format.h>
#include <unistd.h>

namespace panelcal {
namespace {

constexpr const char* kInitCommand = "panelcal init";
constexpr auto kKinds = std::to_array({MachineKind::UsbCameraLinuxCnc,
                                       MachineKind::UsbCameraGrbl,
                                       MachineKind::GigeCnc7,
                                       MachineKind::Folder});

Diagnostic init_usage(std::string what, std::string expected) {
  return {Code::Usage, {kInitCommand, 0, 0}, std::move(what), std::move(expected)};
}

/// Asks a person; an empty answer is the default.
Expected<std::string> ask_line(const std::string& question, std::string_view usual) {
  std::cerr << fmt::format("{} [{}]: ", question, usual) << std::flush;
  std::string answer;
  if (!std::getline(std::cin, answer)) {
    return failure(init_usage("no answer to \"" + question + "\"", "a line, or the option"));
  }
  return answer.empty() ? std::string(usual) : answer;
}

/// What the command line does not say.
Expected<void> ask_for_rest(InitOptions& options) {
  if (::isatty(STDIN_FILENO) != 1) {
    std::string kinds;
    for (const MachineKind kind : kKinds) {
      kinds += fmt::format("{}{}", kinds.empty() ? "" : ", ", name(kind));
    }
    return failure(init_usage("the kind of machine is missing, and no person is at a terminal",
                              "--template with one of " + kinds));
  }
  for (const MachineKind kind : kKinds) {
    std::cerr << fmt::format("  {:20} {}\n", name(kind), summary(kind));
  }
  PANELCAL_TRY(options.kind, ask_line("Kind of machine", name(MachineKind::UsbCameraGrbl)));
  if (!machine_kind_from_name(options.kind)) {
    return failure(init_usage("no kind of machine is called " + quoted(options.kind),
                              "one of the names above"));
  }
  if (options.name.empty()) {
    PANELCAL_TRY(options.name, ask_line("Name of the machine", "my machine"));
  }
  return {};
}

MachineAnswers answers_of(const InitOptions& options) {
  MachineAnswers answers;
  answers.kind = *machine_kind_from_name(options.kind);
  if (!options.name.empty()) answers.name = options.name;
  if (!options.camera.empty()) answers.camera = options.camera;
  answers.device = options.device;
  answers.host = options.host;
  if (options.safe_z_mm) answers.safe_z = mm(*options.safe_z_mm);
  if (options.travel_mm.size() == 4) {
    answers.travel_low = {mm(options.travel_mm[0]), mm(options.travel_mm[1])};
    answers.travel_high = {mm(options.travel_mm[2]), mm(options.travel_mm[3])};
  }
  if (options.camera_offset_mm.size() == 2) {
    answers.camera_offset = {mm(options.camera_offset_mm[0]), mm(options.camera_offset_mm[1])};
  }
  if (options.camera_offset_sigma_um) {
    answers.camera_offset_sigma = um(*options.camera_offset_sigma_um);
  }
  for (const double size_mm : options.fiducials_mm) answers.fiducials.push_back(mm(size_mm));
  answers.calibration = options.calibration;
  if (options.um_per_px) answers.pixel = um(*options.um_per_px);
  if (options.picture_px.size() == 2) {
    answers.picture_px = {options.picture_px[0], options.picture_px[1]};
  }
  return answers;
}

/// A new file replaces none.
Expected<void> check_is_new(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::exists(std::filesystem::symlink_status(file, ignored))) return {};
  return failure({Code::OutputInUse,
                  {kInitCommand, 0, 0},
                  "a file is there already: " + quoted(file.string()),
                  "-o with another name, or move that file away"});
}

/// Reading the file, as every command will, finds a wrong answer.
Expected<void> write_machine(const MachineAnswers& answers, const std::filesystem::path& file) {
  const std::string text = machine_text(answers, file.filename().string());
  PANELCAL_TRY(const MachineConfig config, parse_machine_config(text, file.string()));
  return write_file(file, text);
}

}  // namespace

Expected<Answer> run_command(const InitOptions& given, CommandContext&) {
  InitOptions options = given;
  if (options.kind.empty()) PANELCAL_CHECK(ask_for_rest(options));
  PANELCAL_CHECK(check_extension(kInitCommand, options.output, ".toml"));
  const std::filesystem::path file = options.output;
  const std::filesystem::path camera = file.parent_path() / kAssumedCameraFile;
  MachineAnswers answers = answers_of(options);
  PANELCAL_CHECK(check_is_new(file));
  const bool is_assumed = answers.calibration.empty();
  if (is_assumed) {
    PANELCAL_CHECK(check_is_new(camera));
    PANELCAL_CHECK(write_camera_calibration(camera, assumed_camera(answers, system_clock()())));
  } else {
    // As machine.toml has it: from the folder that it stands in.
    const std::filesystem::path folder = std::filesystem::absolute(file).parent_path();
    answers.calibration =
        std::filesystem::absolute(answers.calibration).lexically_proximate(folder).string();
  }
  if (Expected<void> written = write_machine(answers, file); !written) {
    std::error_code ignored;
    if (is_assumed) std::filesystem::remove(camera, ignored);
    return failure(std::move(written).error());
  }
  std::string text = options.output + " written";
  if (is_assumed) {
    text += fmt::format(", and {} with a scale that is assumed", camera.string());
  }
  return Answer{text + "; lines with \"assumed\" are to be measured, its head says how\n",
                ExitCode::Done};
}

}  // namespace panelcal
