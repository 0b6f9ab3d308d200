// SPDX-License-Identifier: Apache-2.0
#include "machine/config/machine_config.h"

#include <array>
#include <string>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "machine/config/machine_file.h"
#include "machine/config/sections/sections.h"
#include "machine/config/toml/missing_keys.h"

namespace panelcal {
namespace internal {
namespace {

/// All sections, in the order in which they need each other.
std::array<Section, 16> machine_sections() {
  return {machine_section(),
          camera_section(),
          spindle_section(),
          table_section(),
          uncertainty_section(),
          coupon_section(),
          nightly_section(),
          night_surface_section(),
          vision_section(),
          target_section(),
          gate_section(),
          tolerance_section(),
          gcode_section(),
          program_section(),
          sim_section(),
          sim_surface_section()};
}

Expected<MachineConfig> read_sections(const TomlTable& top, const std::filesystem::path& file) {
  MachineConfig config;
  config.file = file;
  for (const Section& section : machine_sections()) {
    if (section.read != nullptr) PANELCAL_CHECK(section.read(top, config));
  }
  return config;
}

}  // namespace

FileDescription machine_file() {
  FileDescription file{"machine.toml", {}};
  for (const Section& section : machine_sections()) {
    file.tables.insert(file.tables.end(), section.tables.begin(), section.tables.end());
  }
  return file;
}

}  // namespace internal

Expected<MachineConfig> parse_machine_config(std::string_view text,
                                             const std::filesystem::path& file) {
  const internal::TomlSource source{file.string(), text};
  const internal::FileDescription description = internal::machine_file();
  PANELCAL_TRY(const toml::table document, internal::parse_toml(source));
  PANELCAL_TRY(const auto top, internal::TomlTable::of_file(document, description, source));
  Expected<MachineConfig> config = internal::read_sections(top, file);
  if (config) return config;
  return failure(
      internal::with_all_missing_keys(std::move(config).error(), document, description, source));
}

Expected<MachineConfig> read_machine_config(const std::filesystem::path& file) {
  PANELCAL_TRY(const std::string text, read_file(file, kMaxConfigBytes));
  return parse_machine_config(text, file);
}

}  // namespace panelcal
