// SPDX-License-Identifier: Apache-2.0
#include "tools/synth/sweep/command.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "calib/base/files/digest.h"
#include "calib/base/interruption.h"
#include "calib/base/number_text.h"
#include "calib/base/thread_pool.h"
#include "machine/job/checked_program.h"
#include "machine/sim/pictures/recording.h"
#include "machine/sim/pictures/sample_pictures.h"
#include "machine/sim/sim_machine.h"
#include "tools/batch/output/progress.h"
#include "tools/batch/work/result_files.h"
#include "tools/cli/process/version.h"
#include "tools/synth/sweep/sweep_file.h"
#include <fmt/format.h>

namespace panelcal::synth {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kRecordName = "sweep.json";
constexpr std::string_view kManifestName = "manifest.csv";
constexpr std::string_view kPointsName = "points";
/// Points that are tried before any picture is made.
constexpr std::size_t kTriedPoints = 1000;

/// One point's pictures.
struct RenderedPoint {
  std::optional<Diagnostic> problem;
  std::int64_t n_pictures = 0;
  bool is_there = false;     ///< of an earlier start
  bool misses_some = false;  ///< the virtual machine itself could not measure all targets
};

/// A field of CSV, RFC 4180.
std::string csv_text(const std::string& text) {
  if (text.find_first_of(",\"\r\n ") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

class SweepRun {
 public:
  SweepRun(const SynthOptions& options, CommandContext& context)
      : options_(options), context_(context), output_(options.output) {}

  Expected<Answer> run() {
    heed_interruptions();
    PANELCAL_CHECK(read_inputs());
    if (!is_readable_) return Answer{{}, ExitCode::BadInput};
    PANELCAL_CHECK(check_points());
    PANELCAL_CHECK(open_output());
    PANELCAL_CHECK(render_all());
    PANELCAL_CHECK(finish());
    context_.console.say(summary());
    return Answer{};
  }

 private:
  Expected<void> read_inputs() {
    PANELCAL_TRY(sweep_, read_sweep(options_.sweep));
    PANELCAL_TRY(machine_text_, read_file(sweep_.machine, kMaxConfigBytes));
    PANELCAL_TRY(MachineConfig config, read_machine_config(sweep_.machine));
    if (!config.sim) {
      return failure({Code::ConfigValue,
                      {sweep_.machine.string(), 0, 0},
                      "[sim] is missing, which describes the virtual camera",
                      "[sim]"});
    }
    PANELCAL_TRY(const std::string sweep_text, read_file(sweep_.file));
    std::string inputs = sha256(sweep_text) + sha256(machine_text_);
    if (config.camera) {
      PANELCAL_TRY(const std::string camera, read_file(config.camera_file));
      inputs += sha256(camera);
    }
    if (!sweep_.tool) PANELCAL_CHECK(read_program(config, inputs));
    record_ = fmt::format(
        "{{\"kind\":\"sweep\",\"version\":1,\"panelcal\":\"{}\",\"inputs_sha256\":\"{}\","
        "\"n_points\":{}}}\n",
        kVersion,
        sha256(inputs),
        sweep_.n_points());
    return {};
  }

  Expected<void> read_program(const MachineConfig& config, std::string& inputs) {
    DiagnosticLog log;
    checked_ = read_and_check(sweep_.program.string(), config.reading, config.walk, log);
    context_.console.print(log);
    is_readable_ = checked_ && !log.has_errors();
    if (is_readable_) inputs += sha256(checked_->program.source.bytes);
    return {};
  }

  /// Values that do not go together are found before hours of rendering.
  Expected<void> check_points() const {
    const std::size_t n = sweep_.n_points();
    const std::size_t step = std::max<std::size_t>(1, n / kTriedPoints);
    for (std::size_t i = 0; i < n; i += step) {
      PANELCAL_TRY(const MachineConfig config,
                   machine_of(sweep_, point_of(sweep_, i), machine_text_));
      if (sweep_.tool) PANELCAL_CHECK(SampleRenderer::create(config, *sweep_.tool));
    }
    return {};
  }

  Expected<void> open_output() {
    std::error_code ignored;
    const bool is_begun = fs::exists(output_ / kRecordName, ignored);
    const auto refuse = [&](std::string what, std::string expected) {
      return failure(
          {Code::OutputInUse, {options_.output, 0, 0}, std::move(what), std::move(expected)});
    };
    if (is_begun && !options_.resume) {
      return refuse("a sweep has its set there", "--resume to go on with it, or another folder");
    }
    if (is_begun) {
      PANELCAL_TRY(const std::string begun, read_file(output_ / kRecordName));
      if (begun != record_) {
        return refuse("the set was begun with other inputs, or by another version of panelcal",
                      "the inputs as they were, or another folder");
      }
    } else if (fs::exists(output_, ignored) && !holds_nothing()) {
      return refuse("it is no empty folder", "a folder that is new or empty");
    }
    PANELCAL_TRY(batch::ResultFolder folder, batch::ResultFolder::open(output_));
    folder_.emplace(std::move(folder));
    if (is_begun) return {};
    std::error_code error;
    fs::create_directories(output_ / kPointsName, error);
    if (error) {
      return failure({Code::DeviceWrite,
                      {options_.output, 0, 0},
                      "cannot make a folder: " + error.message(),
                      ""});
    }
    return write_file(output_ / kRecordName, record_);
  }

  /// But for what a start left that was killed at once.
  bool holds_nothing() const {
    std::error_code error;
    for (fs::directory_iterator at(output_, error), end; !error && at != end; at.increment(error)) {
      const fs::path name = at->path().filename();
      if (name != "lock" && name != "parts" && name != kPointsName) return false;
      std::error_code ignored;
      if (name == kPointsName && !fs::is_empty(at->path(), ignored)) return false;
    }
    return !error;
  }

  fs::path place_of(const Point& point) const { return output_ / kPointsName / point.id; }

  RenderedPoint render(std::size_t i) const {
    const Point point = point_of(sweep_, i);
    RenderedPoint out;
    std::error_code ignored;
    out.is_there = fs::exists(place_of(point), ignored);
    if (out.is_there || interruption() != 0) return out;
    const auto done = render_into(output_ / "parts" / point.id, point, out);
    if (!done) out.problem = done.error();
    return out;
  }

  Expected<void> render_into(const fs::path& folder, const Point& point, RenderedPoint& out) const {
    PANELCAL_TRY(const MachineConfig config, machine_of(sweep_, point, machine_text_));
    if (sweep_.tool) {
      PANELCAL_TRY(const SampleRenderer renderer, SampleRenderer::create(config, *sweep_.tool));
      PANELCAL_TRY(const SampleSet set, write_samples(renderer, sweep_.n_pictures, folder));
      out.n_pictures = static_cast<std::int64_t>(set.pictures.size());
      return {};
    }
    PANELCAL_TRY(SimMachine machine, SimMachine::create(config, checked_->nominal_survey));
    DiagnosticLog log;
    PANELCAL_TRY(const Recording recording,
                 record_pictures(checked_->program, config, machine, folder, log));
    out.n_pictures = static_cast<std::int64_t>(recording.rows.size());
    out.misses_some = log.has_errors();
    return {};
  }

  Expected<void> render_all() {
    const std::size_t n = sweep_.n_points();
    batch::Progress progress(context_.console, n, batch::Counted::Points);
    std::optional<Diagnostic> problem;
    const auto pool = make_thread_pool(options_.n_threads, n);
    make_in_order(
        pool.get(),
        n,
        [this](std::size_t i) { return render(i); },
        [&](std::size_t i, const RenderedPoint& point) {
          // A point that saw the signal has no pictures.
          if (interruption() != 0) return false;
          problem = point.problem;
          if (!problem && !point.is_there) problem = put_in_place(point_of(sweep_, i));
          if (problem) return false;
          n_there_ += point.is_there ? 1 : 0;
          n_missing_some_ += point.misses_some ? 1 : 0;
          n_pictures_ += point.n_pictures;
          progress.count(point.n_pictures);
          progress.show();
          return true;
        });
    context_.console.end_progress();
    if (problem) return failure(*std::move(problem));
    return check_interruption();
  }

  std::optional<Diagnostic> put_in_place(const Point& point) const {
    std::error_code error;
    fs::rename(output_ / "parts" / point.id, place_of(point), error);
    if (!error) return std::nullopt;
    return Diagnostic{Code::DeviceWrite,
                      {place_of(point).string(), 0, 0},
                      "cannot put it in place: " + error.message(),
                      ""};
  }

  /// A file as the manifest names it, from its own folder.
  std::string named(const fs::path& file) const {
    std::error_code ignored;
    const fs::path real = fs::weakly_canonical(fs::absolute(file), ignored);
    const fs::path folder = fs::weakly_canonical(fs::absolute(output_), ignored);
    return csv_text(real.lexically_proximate(folder).string());
  }

  /// The set is whole once it has a manifest.
  Expected<void> finish() const {
    PANELCAL_CHECK(folder_->publish({}));
    PANELCAL_TRY(AtomicFile file, AtomicFile::create(output_ / kManifestName));
    std::string head = sweep_.tool ? "id,machine,images,truth" : "id,program,machine,images,truth";
    for (const Factor& factor : sweep_.factors) head += "," + factor.column;
    PANELCAL_CHECK(file.write(head + "\n"));
    const std::string machine = named(sweep_.machine);
    const std::string subject = sweep_.tool ? machine : named(sweep_.program) + "," + machine;
    for (std::size_t i = 0; i < sweep_.n_points(); ++i) {
      const Point point = point_of(sweep_, i);
      const std::string folder = fmt::format("{}/{}", kPointsName, point.id);
      std::string row = fmt::format("{0},{1},{2},{2}/truth.json", point.id, subject, folder);
      for (const double value : point.values) row += fmt::format(",{}", value);
      PANELCAL_CHECK(file.write(row + "\n"));
    }
    PANELCAL_CHECK(file.commit());
    std::error_code ignored;
    fs::remove(output_ / "parts", ignored);
    return {};
  }

  std::string summary() const {
    std::string out =
        fmt::format("{} of {} in {}; {} written",
                    internal::counted(static_cast<std::int64_t>(sweep_.n_points()), "point"),
                    internal::counted(static_cast<std::int64_t>(sweep_.factors.size()), "factor"),
                    (output_ / kManifestName).string(),
                    internal::counted(n_pictures_, "picture"));
    if (n_there_ > 0) {
      out += fmt::format(", {} were there", internal::counted(n_there_, "point"));
    }
    if (n_missing_some_ > 0) {
      out += fmt::format("; at {} the virtual machine itself could not measure every target",
                         internal::counted(n_missing_some_, "point"));
    }
    return out;
  }

  const SynthOptions& options_;
  CommandContext& context_;
  fs::path output_;
  Sweep sweep_;
  std::string machine_text_;
  std::optional<CheckedProgram> checked_;
  bool is_readable_ = true;
  std::string record_;  ///< sweep.json
  std::optional<batch::ResultFolder> folder_;
  std::int64_t n_pictures_ = 0;
  std::int64_t n_there_ = 0;
  std::int64_t n_missing_some_ = 0;
};

}  // namespace

Expected<Answer> run_sweep(const SynthOptions& options, CommandContext& context) {
  return SweepRun(options, context).run();
}

}  // namespace panelcal::synth
