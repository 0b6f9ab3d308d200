// SPDX-License-Identifier: Apache-2.0
#include "tools/modules/module.h"

#include <new>
#include <string_view>

#include "machine/devices/module_path.h"
#include <dlfcn.h>
#include <fmt/format.h>
#include <sys/resource.h>

namespace panelcal::modules {
namespace {

/// The Debian package of a module that the program does without, for its remedy; else empty.
std::string_view package_of(std::string_view file) {
  if (file == "libpanelcal_gige.so") return "panelcal-cameras";
  if (file == "libpanelcal_http.so") return "panelcal-serve";
  if (file == "libpanelcal_postgresql.so") return "panelcal-postgresql";
  return "";
}

[[noreturn]] void fail_loading(const std::string& path, std::string_view why) {
  throw ModuleError(fmt::format("module not usable: \"{}\": {}", path, why));
}

/// The loader has words for it, and no code. Where addresses are limited, a part of a module that
/// cannot be mapped is one for which they do not suffice.
bool is_of_memory(std::string_view why) {
  rlimit limit{};
  const bool is_limited = ::getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
  return why.ends_with("Cannot allocate memory") ||
         (is_limited && why.find("failed to map segment") != why.npos);
}

}  // namespace

const void* load_functions(const char* file) {
  const std::string path = internal::module_path(file);
  // Never unloaded: what it made may live as long as the program.
  void* const library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  const void* const face = library != nullptr ? dlsym(library, "panelcal_module") : nullptr;
  if (face == nullptr) {
    const char* const why = dlerror();
    if (why != nullptr && is_of_memory(why)) throw std::bad_alloc();
    std::string reason = why != nullptr ? why : "not a module";
    if (const auto package = package_of(file); !package.empty()) {
      reason += fmt::format("; the Debian package {} has it", package);
    }
    fail_loading(path, reason);
  }
  const auto& module = *static_cast<const PanelcalModule*>(face);
  if (std::string_view(module.version) != PANELCAL_VERSION) {
    fail_loading(path, fmt::format("version {}, expected {}", module.version, PANELCAL_VERSION));
  }
  if (module.begin != nullptr) module.begin();
  return module.functions;
}

}  // namespace panelcal::modules
