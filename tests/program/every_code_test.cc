// SPDX-License-Identifier: Apache-2.0
// Every code of the catalogue's sections "Part programs" and "SIEB & MEYER programs" can be seen:
// one program for each.
#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calib/panel/smooth_panel.h"
#include "program/judge/job_check.h"
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/program/program_run.h"

namespace panelcal {
namespace {

using test::metric;

using Texts = std::vector<std::string>;

/// Finds the surface at these heights in turn; where there is none, it finds nothing.
class HeightSource final : public ProbeSource {
 public:
  explicit HeightSource(std::vector<std::optional<Length>> heights)
      : heights_(std::move(heights)) {}

  Expected<ProbeReading> probe(const ProbeRequest& request) override {
    ProbeReading reading{.request = request};
    const auto& height = heights_.at(static_cast<std::size_t>(request.seq));
    if (!height) return reading;
    reading.status = ProbeStatus::Found;
    reading.heights = {{*height, um(1)}};
    return reading;
  }

 private:
  std::vector<std::optional<Length>> heights_;
};

/// The slugs of all that checking a program says.
class Collector {
 public:
  void see(const std::string& text, const WalkOptions& options = {}) {
    NominalProbeSource probes;
    see(text, options, probes);
  }

  void see(const std::string& text,
           const WalkOptions& options,
           ProbeSource& probes,
           ReadOptions reading = {}) {
    DiagnosticLog log;
    if (text.find("%%") == std::string::npos) reading.last_format = test::last_set_to_inch();
    see_program(load_program({"p.exc", text}, log, reading), log, options, probes);
  }

  /// Without a last setting of the control.
  void see_unstated(const std::string& text, const ReadOptions& reading = {}) {
    DiagnosticLog log;
    NominalProbeSource probes;
    see_program(load_program({"p.exc", text}, log, reading), log, {}, probes);
  }

  void see_program(Program program,
                   DiagnosticLog& log,
                   const WalkOptions& options,
                   ProbeSource& probes) {
    program.patterns.emplace("SELF", SourceText{"SELF", "M99,SELF\nXY\n"});
    program.patterns.emplace("OFFS", SourceText{"OFFS.SS5", "@OFFS\nM31\nXY\nXYM50M30\n"});
    program.patterns.emplace("LOOP", SourceText{"LOOP.SS5", "@LOOP\nM99,LOOP\n"});
    NominalSource source;
    const Survey survey = panelcal::survey(program, options, source, probes, log);
    if (!log.has_errors()) {
      JobCheck check(Travel{position_mm<frame::Machine>(-5000, -5000),
                            position_mm<frame::Machine>(5000, 5000)});
      execute(program, options, survey, check, log);
      check.report(program, log);
    }
    for (const Diagnostic& diagnostic : log.kept()) {
      seen_.emplace_back(info(diagnostic.code).slug);
    }
  }

  /// With a short limit and two targets to a series.
  void see_body(const std::string& body) {
    WalkOptions options;
    options.max_operations = 1000;
    options.series_size = 2;
    see(metric("G34,1\nT1\n" + body + "M30\n"), options);
  }

  /// In SIEB & MEYER's format 5000, with tool 1.
  void see_5000(const std::string& body) { see(format_5000(body)); }
  void see_5000(const std::string& body, ProbeSource& probes) {
    see(format_5000(body), {}, probes);
  }

  bool has_seen(std::string_view slug) const {
    return std::ranges::find(seen_, slug) != seen_.end();
  }

 private:
  static std::string format_5000(const std::string& body) {
    return "%%5000\n" + body + "$\nT1D1.F3.\n$\n";
  }

  Texts seen_;
};

void see_reading(Collector& collector) {
  for (const char* body : {"#\n",
                           "X..\n",
                           "X1234567\n",
                           "G06\n",
                           "M01\n",
                           "G90T1\n",
                           "M50\n",
                           "G35\n",
                           "G35X1.Y1.\nX1.\n",
                           "X0.Y0.\n",
                           "M30\nT1\n",
                           "/X0.Y0.\n",
                           "x0.Y0.\n",
                           "ATC,ON\n",
                           "X9999.Y0.\n"}) {
    collector.see_body(body);
  }
  for (const char* text : {"T1\nX01Y01\n",
                           "%5000\nX1.Y1.T1\n",
                           "X1.Y1.\n",
                           "M48\nFOO\n",
                           "M48\nZA\n%\n",
                           "M48\nCCW,ON\n%\n",
                           "M48\nMETRIC,LZ\n%\nT1\nX0.Y0.\nX2500.Y0.\nM30\n"}) {
    collector.see(text);
  }
  collector.see_unstated("T1\nX01Y01\nM30\n");
  collector.see_unstated("T1C.02\nX01Y02\nX03Y04\nM30\n");
  collector.see_unstated("M48\nMETRIC,TZ\n%\nM30\n", {.forced_format = *parse_format("inch")});
  NominalProbeSource probes;
  collector.see("T1\nX01Y01\n", {}, probes, {.accepts_unterminated = true});
}

void see_tools(Collector& collector) {
  for (const char* body :
       {"T3\n", "T1C5.\n", "T1F9\n", "T3F2C1.\n", "X0.Y0.\n", "T3F2\nX0.Y0.G85X5.Y0.\n"}) {
    collector.see_body(body);
  }
}

void see_motion(Collector& collector) {
  for (const char* body :
       {"G00X0.Y0.\nG01X1.\n",
        "G00X0.Y0.\nM15\nT2\n",
        "G00X0.Y0.\nM15\nG02X1.\n",
        "G00X0.Y0.\nM15\nG02X1.A.1\nM17\n",
        "X0.Y0.G84X1.\n",
        "G82\nG05\n",
        "P2X1.\n",
        "M99,GONE\nX0.Y0.\n",
        "M99,SELF\nX0.Y0.\n",
        "M60\n",
        "G41\nG00X0.Y0.\n",
        "T1\nG00X0.Y0.\nG41\nM15\nG01X1.\nM17\n",
        "G00X0.Y0.\nT0102\nG41\nM15\nG01X1.\nM17\n",
        "G00X0.Y0.\nM25\nG00X1.Y0.\nM15\nG01X2.\nX3.F02\nM17\nM01\nM02X9.\nM08\n",
        "G82X1.Y1.\nX1.Y1.\nX4.Y3.\n",
        "M47,ABCDEFGHIJKLMNOPQRSTU\n"}) {
    collector.see_body(body);
  }
}

void see_step_repeat(Collector& collector) {
  std::string deep = "M25\n";
  for (int i = 0; i < 65; ++i) deep += "M01\n";
  for (const std::string& body : {std::string("M25\n"),
                                  std::string("G35X0.Y0.\nR1X1.\n"),
                                  std::string("X0.Y0.\nR9999X1.\n"),
                                  deep}) {
    collector.see_body(body);
  }
}

void see_vision(Collector& collector) {
  for (const char* body :
       {"G36X0.Y0.\nX0.Y0.\n",
        "G36X1.Y1.\nG36X1.Y1.\n",
        "M51,1\n",
        "M52\n",
        "M50,1\nM25\nG35X0.Y0.\nM01\nM08\nM51,1\nM52,2\n",
        "M50,1\nM25\nG36X0.Y0.\nG36X9.Y0.\nM01\nM08\nM51,1\nM52\nX1.Y1.\n",
        "M50,1\nM25\nG45X0.Y0.\nM01\nM08\nG35X0.Y0.\nM51,1\nM52\n",
        "M50,1\nM25\nG45X0.Y0.\nM01\nM02X9.\nM08\nM51,1\nM25\nM52\nM01\nM08\n",
        "M50,1\nM25\nG45X0.Y0.\nM01\nM08\nM51,1\nM25\nX1.Y1.\nM01\nM08\n",
        "M50,1\nM25\nG45X0.Y0.\nM01\nM02X9.\nM08\nM51,1\nM25\nM52\nM01\nM02X8.\nM08\n",
        "G35X0.Y0.\nG93X0.Y0.\n",
        "$uvis,calib\n"}) {
    collector.see_body(body);
  }
  collector.see("G35X1.Y1.\n");
  WalkOptions affine;
  affine.model = PanelModel::Affine;
  affine.series_size = 2;
  collector.see("G34,1\nG36X0.Y0.\nG36X9.Y9.\n", affine);
  WalkOptions smooth;
  smooth.bends_panel = true;
  smooth.series_size = kLeastSmoothTargets;
  collector.see(
      "G34,1\nG36X0.Y0.\nG36X9.Y0.\nG36X0.Y9.\nG36X9.Y9.\nG36X4.Y2.\nG36X3.Y6.\nG45X1.Y1.\n",
      smooth);
}

void see_sieb_meyer(Collector& collector) {
  collector.see("%%3000\nX1.Y1.T1M95\n$\n$\n");
  collector.see("%%5000\nX1.Y1.T1\n$\nT1D1.F3.\n");
  for (const std::string& body : {"X1.Y1.T1" + std::string(60, ' ') + "M94\n",
                                  std::string("X1.X2.Y1.T1\n"),
                                  std::string("M31\nX1.Y1.T1\n"),
                                  std::string("M31\nX1.Y1.T1\nXYM50\nX2.\nX9.YM50M30\n"),
                                  std::string("M99,LOOP\n"),
                                  std::string("T1\nM99,OFFS\n"),
                                  std::string("T1Z2.\nG81I4.J1.\nG89\n"),
                                  std::string("X1.Y1.T1\nX2.G1F1.\n"),
                                  std::string("X1.Y1.T1T0\nX2.G1F1.\nT2\n"),
                                  std::string("X1.Y1.T1T0\nX2.G1F1.\nX2.\n"),
                                  std::string("X1.Y1.G32T1\n"),
                                  std::string("G31\n"),
                                  std::string("X1.Y1.G32\nG31\nG39,SAVE1001\n"),
                                  std::string("X1.Y1.T1Z2.G81I4.5P20J1.2W500\n"),
                                  std::string("X1.Y1.M58D4.\nX1.Y1.T1\n"),
                                  std::string("M49,QQQ\n"),
                                  std::string("M49,SAX3.Y100.\nX1.Y1.T1\nX2.Y2.M93\n")}) {
    collector.see_5000(body);
  }
  WalkOptions layers;
  layers.sieb_meyer.measurement_mode = 3;
  collector.see("%%5000\nX1.Y1.G33\nG39,REQCOMP\nX1.Y1.T1\n$\nT1D1.F3.\n$\n", layers);
}

void see_surfaces(Collector& collector) {
  const std::string grid = "XYG79\nX9.YG79\nXY9.G79\n";
  std::string scans;
  for (int i = 0; i < 101; ++i) scans += "X1.Y1.G73\n";
  for (const std::string& body : {std::string("L5\n"),
                                  std::string("M31\nG71\nX1.Y1.G73L1\nXYM50\nX9.YM50M30\n"),
                                  std::string("G71\nX1.Y1.G73L1\nG82\nG70\n"),
                                  scans,
                                  grid + "X1.Y1.T1Z1.\n",
                                  grid + "X9.Y9.G79\nX11.Y1.T1Z1.\n"}) {
    collector.see_5000(body);
  }
  std::string most;  // of 4 x 4 nodes all but one
  for (int i = 1; i < 16; ++i) most += fmt::format("X{}.Y{}.G79\n", 3 * (i % 4), 3 * (i / 4));
  WalkOptions filling;
  filling.sieb_meyer.fills_gaps = true;
  collector.see("%%5000\n" + most + "X1.Y1.T1Z1.\n$\n$\n", filling);
  HeightSource nothing({std::nullopt});
  collector.see_5000("X1.Y1.G73L1\n", nothing);
  HeightSource uneven({mm(2), mm(3.2)});
  collector.see_5000("M49,MAPT1.0\nX1.Y1.G78\nX2.Y1.G79\n", uneven);
}

TEST(EveryCode, OfPartProgramsCanBeSeen) {
  Collector collector;
  see_reading(collector);
  see_tools(collector);
  see_motion(collector);
  see_step_repeat(collector);
  see_vision(collector);
  see_sieb_meyer(collector);
  see_surfaces(collector);
  const auto first = static_cast<std::size_t>(Code::BlockSyntax);
  const auto last = static_cast<std::size_t>(Code::SurfaceOutOfTolerance);
  for (std::size_t i = first; i <= last; ++i) {
    const std::string_view slug = diagnostic_catalogue()[i].slug;
    EXPECT_TRUE(collector.has_seen(slug)) << slug;
  }
}

}  // namespace
}  // namespace panelcal
