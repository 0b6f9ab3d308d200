// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calib/base/clock.h"
#include "calib/base/files/atomic_file.h"
#include "machine/config/machine_config.h"
#include "machine/job/checked_program.h"
#include "machine/job/walk_terms.h"
#include "program/judge/tally.h"
#include "program/writers/excellon/writer.h"
#include "program/writers/sieb_meyer/writer.h"
#include "tools/cli/commands.h"
#include "tools/cli/output_paths.h"
#include "tools/cli/provenance.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

Diagnostic translate_usage(std::string what, std::string expected) {
  return {Code::Usage, {"panelcal translate", 0, 0}, std::move(what), std::move(expected)};
}

/// Counts what a translation keeps together.
class StructureTally final : public OperationSink {
 public:
  void put(const Operation& operation) override {
    if (const auto* end = std::get_if<PatternEnd>(&operation.what)) {
      ++n_patterns_;
      n_copies_ += static_cast<std::int64_t>(end->copies.size());
    }
    if (std::holds_alternative<VisionSeries>(operation.what)) ++n_series_;
  }
  std::string summary() const {
    std::string text;
    if (n_patterns_ > 0) {
      text += fmt::format(
          ", {} executed at {}", amount(n_patterns_, "pattern"), amount(n_copies_, "place"));
    }
    if (n_series_ > 0) text += fmt::format(", {} series of targets", n_series_);
    return text;
  }

 private:
  std::int64_t n_patterns_ = 0;
  std::int64_t n_copies_ = 0;
  std::int64_t n_series_ = 0;
};

/// One translation, stage by stage. Every stage leaves its problems in log_.
class Translation {
 public:
  Translation(const TranslateOptions& options, CommandContext& context)
      : options_(options), context_(context) {}

  ExitCode execute_all() {
    if (prepare()) write_program();
    context_.console.print(log_);
    if (is_written_) {
      context_.console.say(fmt::format("{} into {}: {} as written{}; {}",
                                       name(checked_->program.dialect),
                                       name(to_),
                                       amount(tally_),
                                       structure_.summary(),
                                       left_out()));
    } else if (log_.has_errors()) {
      context_.console.say("nothing was written to " + output_name());
    }
    return exit_code(log_);
  }

 private:
  bool refuse(Diagnostic diagnostic) {
    log_.add(std::move(diagnostic));
    return false;
  }
  template <class T>
  bool take(Expected<T> value, T& out) {
    if (!value) return refuse(std::move(value).error());
    out = *std::move(value);
    return true;
  }
  bool take(Expected<void> done) { return done ? true : refuse(std::move(done).error()); }

  std::string output_name() const {
    return options_.output == "-" ? "standard output" : options_.output;
  }

  bool prepare() {
    if (!options_.machine.empty() && !take(read_machine_config(options_.machine), config_)) {
      return false;
    }
    const WalkTerms terms = {.program = options_.program,
                             .clock = options_.clock,
                             .now = system_clock()(),
                             .max_operations = options_.max_operations,
                             .reading = options_.reading,
                             .ages_offset = false,
                             .command = "panelcal translate"};
    std::string time;
    if (!take(set_walk_terms(terms, config_), time)) return false;
    WalkOptions& walk = config_.walk;
    walk.slots = walk.step_slots = Cycles::Kept;
    if (walk.scaling && walk.scaling->starts_enabled) {
      return refuse(translate_usage("[reference_scaling] is enabled in " +
                                        quoted(options_.machine) +
                                        ", and a translation does not scale",
                                    "`panelcal run`, or enabled = false"));
    }
    walk.scaling.reset();  // the other machine's reference scaling is not this one's
    walk.table.reset();    // nor is its table: nothing is corrected here
    checked_ = read_and_check(options_.program, config_.reading, walk, log_);
    if (!checked_ || log_.has_errors()) return false;
    if (!take(check_patterns(context_.options, checked_->program, context_.files))) return false;
    const bool is_excellon = checked_->program.dialect == Dialect::Excellon;
    to_ = options_.to.empty()         ? (is_excellon ? Dialect::SiebMeyer : Dialect::Excellon)
          : options_.to == "excellon" ? Dialect::Excellon
                                      : Dialect::SiebMeyer;
    return true;
  }

  std::unique_ptr<ProgramWriter> make_writer(ByteSink& bytes) const {
    ProgramWriterOptions writing;
    writing.comments =
        comment_lines(provenance_of(context_.options, checked_->program, {options_.machine}));
    writing.allow_losses = true;  // all of them are to be named
    writing.keeps_vision = true;
    writing.default_vision_tool = config_.walk.sieb_meyer.vision_tool;
    writing.absolute_zero = config_.walk.absolute_zero;
    writing.work_zero = config_.walk.work_zero;
    if (to_ == Dialect::Excellon) return std::make_unique<ExcellonWriter>(bytes, writing);
    return std::make_unique<SiebMeyerWriter>(bytes, writing);
  }

  void write_program() {
    const bool is_file = options_.output != "-";
    StringSink text;  // standard output must not get half a program
    std::optional<AtomicFile> file;
    if (is_file) {
      Expected<AtomicFile> created = AtomicFile::create(options_.output);
      if (!created) return log_.add(std::move(created).error());
      file.emplace(*std::move(created));
    }
    const auto writer = make_writer(is_file ? static_cast<ByteSink&>(*file) : text);
    Tee tee({writer.get(), &tally_, &structure_});
    WalkOptions walk = config_.walk;
    walk.structure = Structure::Kept;
    execute_nominal(*checked_, walk, tee, log_);
    if (!take(writer->finish())) return;
    n_left_out_ = writer->losses().n_warnings() + writer->losses().n_errors();
    for (const Diagnostic& loss : writer->losses().kept()) log_.add(loss);
    const bool only_losses = exit_code(log_) <= ExitCode::GateFailed;
    if (log_.has_errors() && !(options_.force && only_losses)) return;
    is_written_ = is_file ? take(file->commit()) : take(context_.output.write(text.text()));
  }

  std::string left_out() const {
    return n_left_out_ == 0 ? "nothing is left out" : amount(n_left_out_, "thing") + " left out";
  }

  const TranslateOptions& options_;
  CommandContext& context_;
  DiagnosticLog log_;
  MachineConfig config_;
  std::optional<CheckedProgram> checked_;
  Dialect to_ = Dialect::Excellon;
  Tally tally_;
  StructureTally structure_;
  std::size_t n_left_out_ = 0;
  bool is_written_ = false;
};

}  // namespace

Expected<Answer> run_command(const TranslateOptions& options, CommandContext& context) {
  return Answer{{}, Translation(options, context).execute_all()};
}

}  // namespace panelcal
