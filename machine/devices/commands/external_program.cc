// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/commands/external_program.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <optional>
#include <system_error>
#include <utility>

#include "calib/base/files/file_descriptor.h"
#include "calib/base/interruption.h"
#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

namespace panelcal::internal {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMaxOutput = std::size_t{64} << 10;
constexpr auto kGrace = std::chrono::seconds(1);
constexpr int kLookAgain_ms = 5;
/// The end of standard error that a message quotes.
constexpr std::size_t kLastWords = 200;

Diagnostic problem(const std::vector<std::string>& words, std::string what, std::string expected) {
  return {Code::DeviceStage, {words.front(), 0, 0}, std::move(what), std::move(expected)};
}

std::string system_text(int error) {
  return std::generic_category().message(error);
}

/// glibc 2.36 declares it for C only.
int open_pidfd(pid_t pid) {
  return static_cast<int>(syscall(SYS_pidfd_open, pid, 0));
}

struct Pipe {
  FileDescriptor read;
  FileDescriptor write;
};

std::optional<Pipe> make_pipe() {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return std::nullopt;
  // Only our end: a program does not expect its output to be non-blocking.
  fcntl(ends[0], F_SETFL, O_NONBLOCK);
  return Pipe{FileDescriptor(ends[0]), FileDescriptor(ends[1])};
}

/// A running program that is not left behind, nor what it runs in turn: a shell that wraps the
/// program which moves the machine does not pass signals on.
class Child {
 public:
  Child(pid_t pid, FileDescriptor pidfd) : pid_(pid), pidfd_(std::move(pidfd)) {
    if (interruption_fd() >= 0) group_.emplace(pid);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    if (!is_reaped_ && !was_halted_) halt();
  }

  int pidfd() const { return pidfd_.get(); }

  /// Its wait status. Precondition: it has ended, or is about to.
  int reap() {
    int status = 0;
    while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    is_reaped_ = true;
    return status;
  }

  /// Ends all of it: asked to, then made to. What this user may not signal, as a program under
  /// sudo, is left behind, and so is what does not end all the same.
  void halt() {
    was_halted_ = true;
    const auto until = Clock::now() + kGrace;
    const pid_t all = group_ ? -pid_ : pid_;
    kill(all, SIGTERM);
    if (!is_reaped_ && has_ended_by(until)) reap();
    // The first one is gone; what it has run may still be halting the machine.
    wait_for_the_rest(until);
    if (group_ || !is_reaped_) kill(all, SIGKILL);
    // What is killed needs a moment, too, until it is gone.
    const auto last = Clock::now() + kGrace;
    if (!is_reaped_ && has_ended_by(last)) reap();
    wait_for_the_rest(last);
    if (is_out_of_reach(is_reaped_ ? -pid_ : pid_)) {
      left_running_ = system_text(EPERM);
    } else if (!is_reaped_) {
      left_running_ = "it does not end";
    }
  }

  /// Why it runs on although it was halted; empty if it does not.
  const std::string& left_running() const { return left_running_; }

 private:
  bool has_ended_by(Clock::time_point until) const {
    for (auto left = until - Clock::now(); left > Clock::duration::zero();
         left = until - Clock::now()) {
      pollfd ended{.fd = pidfd_.get(), .events = POLLIN, .revents = 0};
      const auto ms = std::chrono::ceil<std::chrono::milliseconds>(left).count();
      if (poll(&ended, 1, static_cast<int>(ms)) > 0) return true;
    }
    return false;
  }

  /// A process, or a group of its own of which nothing is left that may be signalled.
  bool is_out_of_reach(pid_t pid) const {
    return (group_ || pid > 0) && kill(pid, 0) != 0 && errno == EPERM;
  }

  /// Only of a group of its own: the others in the caller's have nothing to do with it.
  void wait_for_the_rest(Clock::time_point until) const {
    while (group_ && is_reaped_ && Clock::now() < until &&
           (kill(-pid_, 0) == 0 || errno == EPERM)) {
      poll(nullptr, 0, kLookAgain_ms);
    }
  }

  pid_t pid_;
  FileDescriptor pidfd_;
  std::optional<HaltedGroup> group_;  ///< its own, where signals are heeded
  bool is_reaped_ = false;
  bool was_halted_ = false;
  std::string left_running_;
};

/// The program's side of its surroundings: no input, output into our pipes, ordinary signals.
class SpawnSetup {
 public:
  SpawnSetup(const Pipe& out, const Pipe& err) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions_, out.write.get(), STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions_, err.write.get(), STDERR_FILENO);
    posix_spawnattr_init(&attributes_);
    sigset_t signals;
    sigemptyset(&signals);
    posix_spawnattr_setsigmask(&attributes_, &signals);
    sigaddset(&signals, SIGPIPE);
    posix_spawnattr_setsigdefault(&attributes_, &signals);
    short flags = POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF;
    // Where nothing heeds signals, Ctrl-C has to reach the program by itself. The child enters its
    // group before it executes the program, and the parent goes on only then.
    if (interruption_fd() >= 0) {
      posix_spawnattr_setpgroup(&attributes_, 0);
      flags |= POSIX_SPAWN_SETPGROUP;
    }
    posix_spawnattr_setflags(&attributes_, flags);
  }
  SpawnSetup(const SpawnSetup&) = delete;
  SpawnSetup& operator=(const SpawnSetup&) = delete;
  ~SpawnSetup() {
    posix_spawnattr_destroy(&attributes_);
    posix_spawn_file_actions_destroy(&actions_);
  }

  /// An errno, 0 if it runs.
  int spawn(const std::vector<std::string>& words, pid_t& pid) const {
    std::vector<char*> arguments;
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    return posix_spawnp(
        &pid, arguments.front(), &actions_, &attributes_, arguments.data(), environ);
  }

 private:
  posix_spawn_file_actions_t actions_{};
  posix_spawnattr_t attributes_{};
};

/// Takes what is there; closes the pipe at its end.
void drain(FileDescriptor& pipe, std::string& text, std::size_t keep) {
  std::array<char, 4096> piece{};
  while (pipe.get() >= 0) {
    const ssize_t n = read(pipe.get(), piece.data(), piece.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return;
    if (n == 0) return pipe.close();
    text.append(piece.data(), static_cast<std::size_t>(n));
    if (text.size() > keep) text.erase(0, text.size() - keep);
  }
}

struct Ending {
  std::string out;
  std::string err;
  int status = 0;
};

/// Absent: it still ran at the deadline, or when this process was asked to end.
std::optional<Ending> attend(Child& child, Pipe& out, Pipe& err, Clock::time_point deadline) {
  Ending ending;
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
    if (left.count() <= 0) return std::nullopt;
    std::array<pollfd, 4> waiting = {{{.fd = child.pidfd(), .events = POLLIN, .revents = 0},
                                      {.fd = out.read.get(), .events = POLLIN, .revents = 0},
                                      {.fd = err.read.get(), .events = POLLIN, .revents = 0},
                                      {.fd = interruption_fd(), .events = POLLIN, .revents = 0}}};
    constexpr std::int64_t kLongest_ms = 1000;
    if (poll(waiting.data(),
             waiting.size(),
             static_cast<int>(std::min<std::int64_t>(left.count(), kLongest_ms))) < 0 &&
        errno != EINTR) {
      return std::nullopt;
    }
    drain(out.read, ending.out, kMaxOutput + 1);
    drain(err.read, ending.err, kLastWords);
    const bool has_ended = (waiting[0].revents & POLLIN) != 0;
    if (!has_ended && interruption() != 0) return std::nullopt;
    if (!has_ended) continue;
    ending.status = child.reap();
    // A signal to all processes of a service ends the wrapper first.
    if (interruption() != 0) child.halt();
    drain(out.read, ending.out, kMaxOutput + 1);
    drain(err.read, ending.err, kLastWords);
    return ending;
  }
}

std::string trimmed_answer(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\r\n");
  if (begin == std::string_view::npos) return {};
  return std::string(text.substr(begin, text.find_last_not_of(" \t\r\n") + 1 - begin));
}

std::string ending_text(const Ending& ending) {
  std::string text = WIFSIGNALED(ending.status)
                         ? fmt::format("was ended by signal {}", WTERMSIG(ending.status))
                         : fmt::format("ended with code {}", WEXITSTATUS(ending.status));
  const std::string last_words = trimmed_answer(ending.err);
  if (!last_words.empty()) text += ": " + quoted(last_words, kLastWords);
  return text;
}

/// A program that runs on although it was halted: a person has to stop the machine.
Diagnostic left_running(const std::vector<std::string>& words,
                        const std::string& why,
                        std::string what) {
  const std::string more = "could not be halted (" + why + "): the machine may still move";
  const std::string expected =
      "the machine stopped by hand, and a program that this user may signal";
  if (const auto interrupted = check_interruption(); !interrupted) {
    Diagnostic out = interrupted.error();
    out.what += ", and " + quoted(words.front()) + " " + more;
    out.expected = expected;
    return out;
  }
  return problem(words, std::move(what) + " and " + more, expected);
}

}  // namespace

Expected<std::string> run_program(const std::vector<std::string>& words, Time limit) {
  PANELCAL_CHECK(check_interruption());
  std::optional<Pipe> out = make_pipe();
  std::optional<Pipe> err = make_pipe();
  if (!out || !err) return failure(problem(words, "no pipe: " + system_text(errno), ""));
  const auto deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                           std::chrono::duration<double>(limit.in_s()));
  pid_t pid = 0;
  if (const int error = SpawnSetup(*out, *err).spawn(words, pid)) {
    return failure(problem(words,
                           "cannot be started: " + system_text(error),
                           "a program in PATH, or a path with a slash"));
  }
  Child child(pid, FileDescriptor(open_pidfd(pid)));
  if (child.pidfd() < 0) {
    return failure(problem(words, "cannot be watched: " + system_text(errno), ""));
  }
  out->write.close();
  err->write.close();
  const std::optional<Ending> ending = attend(child, *out, *err, deadline);
  if (!ending) child.halt();
  const std::string late = fmt::format("did not end within {} s", limit.in_s());
  if (!child.left_running().empty()) {
    return failure(left_running(words, child.left_running(), late));
  }
  if (!ending) {
    PANELCAL_CHECK(check_interruption());
    return failure(problem(
        words, late + " and was stopped", "an end with code 0 when the order is carried out"));
  }
  if (ending->status != 0) {
    // A signal to all processes of a service reaches the program as well.
    PANELCAL_CHECK(check_interruption());
    return failure(problem(words, ending_text(*ending), "code 0"));
  }
  if (ending->out.size() > kMaxOutput) {
    return failure(problem(words, "writes more than 64 KiB", "at most two numbers"));
  }
  return trimmed_answer(ending->out);
}

}  // namespace panelcal::internal
