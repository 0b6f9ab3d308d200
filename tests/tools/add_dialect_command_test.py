# SPDX-License-Identifier: Apache-2.0
"""A command of a dialect is one row of its table and the function that the row names.

usage: add_dialect_command_test.py SOURCE BUILD
"""

import sys
from pathlib import Path

from toy import Toy, expect

SOURCE, BUILD = sys.argv[1:]

MAIN = r"""
#include <cstdio>

/// Prints the messages of a program's walk, or what is wrong with it.
struct Printer final : panelcal::OperationSink {
  void put(const panelcal::Operation& operation) override {
    const auto* message = std::get_if<panelcal::Message>(&operation.what);
    if (message != nullptr) std::printf("%d: %s\n", operation.line, std::string(message->text).c_str());
  }
};

int main(int, char** argv) {
  using namespace panelcal;
  DiagnosticLog log;
  const Program program = load_program({"toy.drl", argv[1]}, log);
  const WalkOptions options;
  Survey survey;
  Printer printer;
  excellon::Walk walk(program, options, survey, {.sink = &printer, .log = log});
  excellon::run(walk);
  for (const Diagnostic& diagnostic : log.kept()) std::puts(diagnostic.text().c_str());
  std::printf("%s\n", std::string(excellon::info(*excellon::find_command('G', 66)).effect).c_str());
  return log.has_errors() ? 2 : 0;
}
"""

ROW = ('EXCELLON_COMMAND(Toy, \'G\', 66, Message, "", "Toy", "Greets the operator", "stops_test", '
       "if (is_alone(walk, block)) greet(walk, block))\n")
HANDLER = """void greet(Walk& walk, const Block& block) {
  walk.emitter.put(block.line, Message{"the toy greets"});
}

"""

toy = Toy(SOURCE, BUILD, "A command of a dialect")
toy.insert_before("program/excellon/text/commands.def", "EXCELLON_COMMAND(DualInLine1, ", ROW)
toy.insert_before("program/excellon/interpreter/parts.h", "void dwell(Walk& walk",
                  "void greet(Walk& walk, const Block& block);\n")
toy.insert_before("program/excellon/interpreter/events.cc", "void message(Walk& walk", HANDLER)

units = ["program/excellon/text/lexer.cc"]
units += sorted(str(path.relative_to(SOURCE)) for path in Path(SOURCE, "program/excellon/interpreter").glob("*.cc"))
program = toy.program("panelcal_program", units, '#include "program/walk/walk.h"\n' + MAIN, "tests/program/program_test")

HEAD = "M48\nMETRIC,TZ,000.000\nT1C0.8\n%\nT1\n"
code, text = toy.run(program, HEAD + "G66\nX1000Y1000\nM30\n")
expect((code, text) == (0, "6: the toy greets\nGreets the operator\n"), f"the toy does not greet: {text}")
code, text = toy.run(program, HEAD + "G66X1\nM30\n")
expect(code == 2 and "toy.drl:6:4: error[block-not-alone]" in text, f"the toy takes coordinates: {text}")
