# SPDX-License-Identifier: Apache-2.0
"""An output format is a writer and its rows in machine/job/output/output_format.

usage: add_output_format_test.py SOURCE BUILD
"""

import sys

from toy import Toy, expect

SOURCE, BUILD = sys.argv[1:]

WRITER = r"""// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "program/writers/description.h"
#include "program/writers/text_writer.h"

namespace panelcal {

/// Every operation as `name key=number ...`.
class ToyWriter final : public TextWriter {
 public:
  explicit ToyWriter(ByteSink& bytes) : TextWriter(bytes) {}
  void put(const Operation& operation) override {
    text() += operation_name(operation);
    describe(operation, *this);
    text() += '\n';
    flush_if_large();
  }

  void number(Field field, int n) { value(field, n); }
  void length(Field field, Length length) { value(field, length.in_mm()); }
  void point(Field field, const Eigen::Vector2d& p) { value(field, p.x()); }
  void value(Field field, double v) {
    key(field);
    append_fixed(text(), v, kMmDecimals);
  }
  void risk(Field field, double v) { value(field, v); }
  void flag(Field field) { key(field); }
  void word(Field field, std::string_view word) {
    key(field);
    text() += word;
  }
  void text(Field field, std::string_view words) { word(field, words); }
  using TextWriter::text;

 private:
  void key(Field field) {
    text() += ' ';
    text() += field.key;
    text() += '=';
  }
};

}  // namespace panelcal
"""

MAIN = r"""
#include <cstdio>

struct Printer final : panelcal::ByteSink {
  panelcal::Expected<void> write(std::string_view bytes) override {
    std::fwrite(bytes.data(), 1, bytes.size(), stdout);
    return {};
  }
};

int main() {
  using namespace panelcal;
  const auto by_name = output_format_from_name("toy");
  const auto by_extension = output_format_of_extension(".toy");
  if (!by_name || by_name != by_extension || name(*by_name) != "toy") return 1;
  Printer printer;
  const MachineConfig machine;
  const auto writer = make_writer(*by_name, printer, machine, {});
  writer->begin({});
  Drill hole;
  hole.tool = 3;
  hole.nominal = position_mm<frame::Nominal>(1.5, 2);
  writer->put({.line = 1, .path = {}, .what = hole, .file = {}});
  return writer->finish() ? 0 : 2;
}
"""

toy = Toy(SOURCE, BUILD, "An output format")
toy.write("program/writers/toy_writer.h", WRITER)
toy.insert_before("machine/job/output/output_format.h", ", Svg };", ", Toy")
path = "machine/job/output/output_format.cc"
toy.insert_before(path, '{OutputFormat::Jsonl, "jsonl"}', '{OutputFormat::Toy, "toy"}, ')
toy.insert_before(path, '{".jsonl", OutputFormat::Jsonl}', '{".toy", OutputFormat::Toy}, ')
toy.insert_before(path, "  if (format == OutputFormat::Csv) {",
                  "  if (format == OutputFormat::Toy) return std::make_unique<ToyWriter>(bytes);\n")
toy.insert_before(path, '#include "program/writers/svg/writer.h"', '#include "program/writers/toy_writer.h"\n')

program = toy.program("panelcal_machine", [path], MAIN, "tests/machine/machine_test")
code, text = toy.run(program)
expect((code, text) == (0, "drill tool=3 nominal=1.5 actual=0 sigma=0\n"), f"the toy does not write: {code} {text}")
