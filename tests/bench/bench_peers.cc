// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/bench_peers.h"

#include <array>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include "calib/base/files/atomic_file.h"
#include <dlfcn.h>
#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

extern char** environ;

namespace panelcal::bench {
namespace {

/// Waits for a child; its processor time if it ended well.
std::optional<double> cpu_of_ended_s(pid_t child) {
  int status = 0;
  rusage usage{};
  if (wait4(child, &status, 0, &usage) != child || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    return std::nullopt;
  }
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * 1e-6;
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::size_t count_of(std::string_view word, std::string_view text) {
  std::size_t n = 0;
  for (auto at = text.find(word); at != text.npos; at = text.find(word, at + word.size())) ++n;
  return n;
}

}  // namespace

double cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

std::optional<double> in_child(const std::function<std::optional<double>()>& work) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) return std::nullopt;
  const pid_t child = fork();
  if (child < 0) return std::nullopt;
  if (child == 0) {
    const int null = open("/dev/null", O_WRONLY | O_CLOEXEC);
    dup2(null, STDOUT_FILENO);
    dup2(null, STDERR_FILENO);
    // Neither an exception nor exit(): what the parent has open is the parent's.
    try {
      const std::optional<double> result = work();
      const auto n_bytes = static_cast<ssize_t>(sizeof(double));
      _exit(result && write(ends[1], &*result, sizeof(double)) == n_bytes ? 0 : 1);
    } catch (...) {
      _exit(1);
    }
  }
  close(ends[1]);
  double result = 0;
  const bool is_read = read(ends[0], &result, sizeof result) == static_cast<ssize_t>(sizeof result);
  close(ends[0]);
  if (!cpu_of_ended_s(child) || !is_read) return std::nullopt;
  return result;
}

std::optional<double> peak_mib() {
  constexpr std::string_view kKey = "VmHWM:";  // proc(5), in kB
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(kKey)) return std::stod(line.substr(kKey.size())) / 1024;
  }
  return std::nullopt;
}

double from_chars_floor_s(std::string_view text) {
  const auto begins_number = [](char c) { return (c >= '0' && c <= '9') || c == '-' || c == '.'; };
  double sum = 0;
  const double start_s = cpu_s();
  const char* at = text.data();
  const char* const end = at + text.size();
  while (at != end) {
    double number = 0;
    if (!begins_number(*at)) {
      ++at;
    } else if (const auto [rest, error] = std::from_chars(at, end, number); error == std::errc()) {
      sum += number;
      at = rest;
    } else {
      ++at;
    }
  }
  const double floor_s = cpu_s() - start_s;
  if (!(sum > 0)) throw std::runtime_error("the floor has read nothing");
  return floor_s;
}

/// The three functions of gerbv.h, declared here so that its headers are not needed.
std::optional<double> libgerbv_load_s(const std::filesystem::path& file) {
  return in_child([&file]() -> std::optional<double> {
    void* const library = dlopen("libgerbv.so.1", RTLD_NOW);
    if (library == nullptr) return std::nullopt;
    const auto create_project =
        reinterpret_cast<void* (*)()>(dlsym(library, "gerbv_create_project"));
    const auto open_layer = reinterpret_cast<void (*)(void*, const char*)>(
        dlsym(library, "gerbv_open_layer_from_filename"));
    const auto destroy_project =
        reinterpret_cast<void (*)(void*)>(dlsym(library, "gerbv_destroy_project"));
    if (!create_project || !open_layer || !destroy_project) return std::nullopt;
    void* const project = create_project();
    const double start_s = cpu_s();
    open_layer(project, file.c_str());
    const double load_s = cpu_s() - start_s;
    destroy_project(project);
    return load_s;
  });
}

std::optional<double> gerbv_rewrite_s(const std::filesystem::path& file,
                                      const std::filesystem::path& output,
                                      std::size_t n_holes) {
  std::array<std::string, 6> words = {"gerbv", "-x", "rs274x", "-o", output, file};
  std::array<char*, words.size() + 1> arguments{};
  for (std::size_t i = 0; i < words.size(); ++i) arguments[i] = words[i].data();

  posix_spawn_file_actions_t silent;
  posix_spawn_file_actions_init(&silent);
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&silent, stream, "/dev/null", O_WRONLY, 0);
  }
  pid_t child = 0;
  const bool is_there =
      posix_spawnp(&child, "gerbv", &silent, nullptr, arguments.data(), environ) == 0;
  posix_spawn_file_actions_destroy(&silent);
  const auto rewrite_s = is_there ? cpu_of_ended_s(child) : std::nullopt;
  if (!rewrite_s) return std::nullopt;
  const auto written = read_file(output);
  if (!written || count_of("D03*", *written) != n_holes) return std::nullopt;
  return rewrite_s;
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "panelcal-bench-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace panelcal::bench
