// SPDX-License-Identifier: Apache-2.0
// Time and memory of interpreting programs, beside other readers of the same file in one run.
// See README.md.
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include "calib/correction/stack.h"
#include "program/judge/job_verdict.h"
#include "program/judge/tally.h"
#include "program/walk/walk.h"
#include "program/writers/csv_writer.h"
#include "program/writers/excellon/writer.h"
#include "program/writers/sieb_meyer/writer.h"
#include <fmt/format.h>

#include "tests/bench/bench_peers.h"
#include "tests/bench/bench_program.h"

namespace panelcal::bench {
namespace {

/// Nothing that went wrong is timed.
[[noreturn]] void stop(const std::string& why) {
  throw std::runtime_error(why);
}

class CountingSink final : public OperationSink {
 public:
  void put(const Operation& operation) override {
    if (const auto* drill = std::get_if<Drill>(&operation.what)) {
      ++n_holes_;
      checksum_mm_ += drill->actual.in_mm().sum() + drill->cov_mm2.trace();
    }
  }
  int n_holes() const { return n_holes_; }

 private:
  int n_holes_ = 0;
  double checksum_mm_ = 0;  // uses what the walk computes
};

class DiscardingSink final : public ByteSink {
 public:
  Expected<void> write(std::string_view bytes) override {
    n_bytes_ += bytes.size();
    return {};
  }
  std::size_t n_bytes() const { return n_bytes_; }

 private:
  std::size_t n_bytes_ = 0;
};

/// A program with its survey, made before anything is timed.
class Job {
 public:
  Job(std::string text, int n_holes, WalkOptions options = rigid())
      : text_(std::move(text)), n_holes_(n_holes), options_(std::move(options)) {
    survey_ = check(load());
    if (!survey_.is_complete() || survey_.series.size() != 1) stop("the targets give no fit");
  }

  const std::string& text() const { return text_; }
  Program load() const { return load(text_); }
  Survey check(const Program& program) const {
    DiagnosticLog log;
    TurnedPanel panel;
    Survey found = survey(program, options_, panel, log);
    require_clean(log);
    return found;
  }
  void run(const Program& program, OperationSink& sink) const {
    DiagnosticLog log;
    execute(program, options_, survey_, sink, log);
    require_clean(log);
  }
  /// Reading and executing; the copy that load_program takes is made before.
  double count_s() const {
    std::string copy = text_;
    return timed([&] {
      CountingSink sink;
      run(load(std::move(copy)), sink);
      if (sink.n_holes() != n_holes_) stop(fmt::format("{} holes came", sink.n_holes()));
    });
  }
  /// The same where every hole's error is predicted and held against the tolerance.
  double judge_s() const {
    std::string copy = text_;
    return timed([&] {
      CountingSink counting;
      JobVerdict verdict(options_.tolerances);
      Tee tee({&counting, &verdict});
      run(load(std::move(copy)), tee);
      if (counting.n_holes() != n_holes_) stop(fmt::format("{} holes came", counting.n_holes()));
      if (verdict.n_judged() != n_holes_) stop(fmt::format("{} were judged", verdict.n_judged()));
    });
  }
  TransformEstimate<frame::Actual, frame::Nominal> correction() const {
    CorrectionStack stack(options_.uncertainty);
    stack.set_base(survey_.series.front().base);
    return stack.drilled_from_nominal();
  }
  double check_s() const {
    const Program program = load();
    return timed([&] { check(program); });
  }
  template <class Writer, class... Arguments>
  double write_s(ByteSink& bytes, Arguments... arguments) const {
    std::string copy = text_;
    return timed([&] {
      Writer writer(bytes, arguments...);
      run(load(std::move(copy)), writer);
      if (!writer.finish()) stop("the output cannot be written");
    });
  }
  template <class Writer, class... Arguments>
  double discard_s(Arguments... arguments) const {
    DiscardingSink bytes;
    const double write_s = this->write_s<Writer>(bytes, arguments...);
    if (bytes.n_bytes() < static_cast<std::size_t>(n_holes_)) stop("the output is too short");
    return write_s;
  }

  static double timed(const std::function<void()>& work) {
    const double start_s = cpu_s();
    work();
    return cpu_s() - start_s;
  }

 private:
  static Program load(std::string text) {
    DiagnosticLog log;
    Program program = load_program({"bench.exc", std::move(text)}, log);
    require_clean(log);
    return program;
  }
  static void require_clean(const DiagnosticLog& log) {
    if (!log.kept().empty()) stop(log.kept()[0].text());
  }

  std::string text_;
  int n_holes_;
  WalkOptions options_;
  Survey survey_;
};

/// Corrects so many places, with or without their covariances: what propagating costs by itself.
double correct_s(const Job& job, int n_holes, bool with_covariance) {
  const auto map = job.correction();
  double sum = 0;
  const double correct_s = Job::timed([&] {
    for (int i = 0; i < n_holes; ++i) {
      const auto nominal = position_mm<frame::Nominal>(1e-3 * (i % 1000), 1e-6 * i);
      if (with_covariance) {
        const auto corrected = map(nominal);
        sum += corrected.position.in_mm().x() + corrected.cov.trace() + corrected.cov(0, 1);
      } else {
        sum += map.map(nominal).in_mm().x();
      }
    }
  });
  if (!(sum > 0)) stop("nothing was corrected");
  return correct_s;
}

double write_file_s(const Job& job, const std::filesystem::path& path) {
  auto file = AtomicFile::create(path);
  if (!file) stop(file.error().text());
  return job.write_s<ExcellonWriter>(*file, ProgramWriterOptions{}) + Job::timed([&] {
           if (!file->commit()) stop("the file cannot be written");
         });
}

constexpr std::string_view kWithoutPropagation = "<= 2 floor, <= libgerbv / 5";
constexpr std::string_view kPropagationGoal = "< 2 times without";

struct Row {
  std::string name;
  std::function<std::optional<double>()> measure_s;
  std::string_view goal;
  std::optional<double> best_s = std::nullopt;
};

std::vector<Row> sieb_meyer_rows(const Job& plain, const Job& repeat) {
  return {
      {"floor: from_chars over the plain file",
       [&] { return from_chars_floor_s(plain.text()); },
       ""},
      {"plain: read and execute, counted", [&] { return plain.count_s(); }, "<= 2 floor"},
      {"plain: survey", [&] { return plain.check_s(); }, ""},
      {"plain: to CSV", [&] { return plain.discard_s<CsvWriter>(); }, "<= 4 floor"},
      {"plain: to SIEB & MEYER",
       [&] { return plain.discard_s<SiebMeyerWriter>(ProgramWriterOptions{}); },
       "<= 4 floor"},
      {"plain: to Excellon",
       [&] { return plain.discard_s<ExcellonWriter>(ProgramWriterOptions{}); },
       "<= 4 floor"},
      {"repeat: read and execute, counted", [&] { return repeat.count_s(); }, "<= 2 floor"},
      {"repeat: to CSV", [&] { return repeat.discard_s<CsvWriter>(); }, "<= 4 floor"},
      {"repeat: to SIEB & MEYER",
       [&] { return repeat.discard_s<SiebMeyerWriter>(ProgramWriterOptions{}); },
       "<= 4 floor"},
  };
}

void measure(std::vector<Row>& rows, int n_repetitions) {
  for (int i = 0; i < n_repetitions; ++i) {
    for (Row& row : rows) {
      const std::optional<double> now_s = row.measure_s();
      if (now_s) row.best_s = std::min(*now_s, row.best_s.value_or(*now_s));
    }
  }
}

void print(const std::vector<Row>& rows, int n_holes) {
  fmt::print("{:<44}{:>10}{:>9}  {}\n", "", "ns/hole", "/ floor", "goal");
  const double floor_s = rows.front().best_s.value();
  for (const Row& row : rows) {
    if (row.best_s) {
      const double ns = *row.best_s * 1e9 / n_holes;
      fmt::print("{:<44}{:>10.1f}{:>9.2f}  {}\n", row.name, ns, *row.best_s / floor_s, row.goal);
    } else {
      fmt::print("{:<44}{:>10}\n", row.name, "missing");
    }
  }
}

/// In a child that has held nothing but this job.
void print_peak_memory(const char* name, std::string (*program)(int), int n_holes) {
  const auto peak = in_child([=] {
    Job(program(n_holes), n_holes).discard_s<ExcellonWriter>(ProgramWriterOptions{});
    return peak_mib();
  });
  fmt::print("peak memory, {} repeat to Excellon, {:>10} holes: {} MiB\n",
             name,
             n_holes,
             peak ? fmt::format("{:.1f}", *peak) : "unknown");
}

/// Prints the cost of propagating to every hole; the first of these rows does without.
void print_ratios(const std::vector<Row>& rows) {
  const Row* without = nullptr;
  for (const Row& row : rows) {
    if (row.goal == kWithoutPropagation) without = &row;
    if (row.goal != kPropagationGoal || without == nullptr) continue;
    fmt::print("{}: {:.2f} times the run without, goal {}\n",
               row.name,
               row.best_s.value() / without->best_s.value(),
               row.goal);
  }
}

void run(int n_holes, int n_repetitions) {
  for (const int n : {n_holes, 10 * n_holes}) {
    print_peak_memory("Excellon", repeat_program, n);
    print_peak_memory("SIEB & MEYER", repeat_sieb_meyer_program, n);
  }

  const Job plain(plain_program(n_holes), n_holes);
  const Job repeat(repeat_program(n_holes), n_holes);
  const Job uncertain(plain_program(n_holes), n_holes, with_uncertainty());
  const Job judged(plain_program(n_holes), n_holes, with_tolerance());
  const TemporaryFolder folder;
  const auto plain_file = folder.path() / "plain.exc";
  const auto repeat_file = folder.path() / "repeat.exc";
  if (!write_file(plain_file, plain.text()) || !write_file(repeat_file, repeat.text())) {
    stop("the programs cannot be written");
  }

  std::vector<Row> rows = {
      {"floor: from_chars over the plain file",
       [&] { return from_chars_floor_s(plain.text()); },
       ""},
      {"plain: read and execute, counted", [&] { return plain.count_s(); }, kWithoutPropagation},
      {"plain: the same with [uncertainty]", [&] { return uncertain.count_s(); }, kPropagationGoal},
      {"plain: the same with [tolerance]", [&] { return judged.judge_s(); }, kPropagationGoal},
      {"places corrected", [&] { return correct_s(uncertain, n_holes, false); }, ""},
      {"places corrected, with covariance",
       [&] { return correct_s(uncertain, n_holes, true); },
       ""},
      {"plain: survey", [&] { return plain.check_s(); }, ""},
      {"plain: to CSV", [&] { return plain.discard_s<CsvWriter>(); }, "<= 4 floor"},
      {"plain: to Excellon",
       [&] { return plain.discard_s<ExcellonWriter>(ProgramWriterOptions{}); },
       "<= 4 floor"},
      {"plain: to an Excellon file",
       [&] { return write_file_s(plain, folder.path() / "out.exc"); },
       ""},
      {"repeat: read and execute, counted", [&] { return repeat.count_s(); }, "<= 2 floor"},
      {"repeat: survey", [&] { return repeat.check_s(); }, ""},
      {"repeat: to CSV", [&] { return repeat.discard_s<CsvWriter>(); }, "<= 4 floor"},
      {"repeat: to Excellon",
       [&] { return repeat.discard_s<ExcellonWriter>(ProgramWriterOptions{}); },
       "<= 4 floor"},
      {"peer: libgerbv loads the plain file", [&] { return libgerbv_load_s(plain_file); }, ""},
      {"peer: gerbv -x rs274x of the plain file",
       [&] {
         return gerbv_rewrite_s(
             plain_file, folder.path() / "out.gbr", static_cast<std::size_t>(n_holes));
       },
       ""},
  };
  fmt::print("{} holes, plain file {:.1f} MB, best of {} interleaved repetitions\n",
             n_holes,
             static_cast<double>(plain.text().size()) / 1e6,
             n_repetitions);
  measure(rows, n_repetitions);
  print(rows, n_holes);
  print_ratios(rows);

  const Job sm_plain(plain_sieb_meyer_program(n_holes), n_holes);
  const Job sm_repeat(repeat_sieb_meyer_program(n_holes), n_holes);
  std::vector<Row> sm_rows = sieb_meyer_rows(sm_plain, sm_repeat);
  fmt::print("\nSIEB & MEYER, plain file {:.1f} MB\n",
             static_cast<double>(sm_plain.text().size()) / 1e6);
  measure(sm_rows, n_repetitions);
  print(sm_rows, n_holes);
}

std::optional<int> count_from(const char* text) {
  const std::string_view digits = text;
  int count = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), count);
  if (error != std::errc() || end != digits.data() + digits.size() || count < 1)
    return std::nullopt;
  return count;
}

}  // namespace
}  // namespace panelcal::bench

int main(int argc, char** argv) {
  const auto n_holes = argc > 1 ? panelcal::bench::count_from(argv[1]) : 1'000'000;
  const auto n_repetitions = argc > 2 ? panelcal::bench::count_from(argv[2]) : 7;
  constexpr int kMostHoles = std::numeric_limits<int>::max() / 10;
  if (!n_holes || !n_repetitions || *n_holes % 100 != 0 || *n_holes > kMostHoles || argc > 3) {
    fmt::print(stderr, "usage: interpreter_bench [HOLES, a multiple of 100] [REPETITIONS]\n");
    return 2;
  }
  try {
    panelcal::bench::run(*n_holes, *n_repetitions);
  } catch (const std::exception& error) {
    fmt::print(stderr, "interpreter_bench: {}\n", error.what());
    return 1;
  }
}
