// SPDX-License-Identifier: Apache-2.0
// Every code of the catalogue's sections "Part programs" can be seen: one program for each.
#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "panelcal/program/job_check.h"
#include "tests/program/program_run.h"

namespace panelcal {
namespace {

using test::metric;

using Texts = std::vector<std::string>;

/// The slugs of all that checking a program says.
class Collector {
 public:
  void see(const std::string& text, const WalkOptions& options = {}) {
    DiagnosticLog log;
    Program program = load_program({"p.exc", text}, log);
    program.patterns.emplace("SELF", SourceText{"SELF", "M99,SELF\nXY\n"});
    NominalSource source;
    const Survey survey = panelcal::survey(program, options, source, log);
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
    see(metric("G34,1\nT1\n" + body), options);
  }

  bool has_seen(std::string_view slug) const {
    return std::ranges::find(seen_, slug) != seen_.end();
  }

 private:
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
                           "X9999.Y0.\n"}) {
    collector.see_body(body);
  }
  for (const char* text : {"T1\nX01Y01\n",
                           "X1.Y1.\n",
                           "M48\nFOO\n",
                           "M48\nZA\n%\n",
                           "M48\nCCW,ON\n%\n",
                           "M48\nMETRIC,LZ\n%\nT1\nX0.Y0.\nX2500.Y0.\nM30\n"}) {
    collector.see(text);
  }
}

void see_tools(Collector& collector) {
  for (const char* body :
       {"T3\n", "T1C5.\n", "T1F9\n", "T3F2C1.\n", "X0.Y0.\n", "T3F2\nX0.Y0.G85X5.Y0.\n"}) {
    collector.see_body(body);
  }
}

void see_motion(Collector& collector) {
  for (const char* body : {"G00X0.Y0.\nG01X1.\n",
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
}

TEST(EveryCode, OfPartProgramsCanBeSeen) {
  Collector collector;
  see_reading(collector);
  see_tools(collector);
  see_motion(collector);
  see_step_repeat(collector);
  see_vision(collector);
  const auto first = static_cast<std::size_t>(Code::BlockSyntax);
  const auto last = static_cast<std::size_t>(Code::CalibrationNotPerformed);
  for (std::size_t i = first; i <= last; ++i) {
    const std::string_view slug = diagnostic_catalogue()[i].slug;
    EXPECT_TRUE(collector.has_seen(slug)) << slug;
  }
}

}  // namespace
}  // namespace panelcal
