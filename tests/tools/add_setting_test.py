# SPDX-License-Identifier: Apache-2.0
"""A setting is one row and one member: reader, unknown keys, range, page and schema come of them.

usage: add_setting_test.py SOURCE BUILD
"""

import sys
from pathlib import Path

from toy import Toy, expect

SOURCE, BUILD = sys.argv[1:]

MAIN = r"""
int main(int argc, char** argv) {
  using namespace panelcal;
  if (argc == 1) {
    std::fputs(internal::page_of(internal::machine_file()).c_str(), stdout);
    std::fputs(internal::schema_of(internal::machine_file()).c_str(), stdout);
    return 0;
  }
  const auto config = parse_machine_config(argv[1], "machine.toml");
  if (!config) {
    std::puts(config.error().text().c_str());
    return 2;
  }
  std::printf("%g\n", config->vision.toy_reach.in_mm());
  return 0;
}
"""

toy = Toy(SOURCE, BUILD, "A setting")
toy.insert_before("machine/config/settings/vision_options.h", "  FourViews four_views = ",
                  "  Length toy_reach = mm(7);  ///< [vision] toy_reach_mm: how far the toy reaches\n")
toy.insert_before("machine/config/sections/vision.def", '    field<&MachineConfig::vision, &VisionOptions::four_view_limit>',
                  '    field<&MachineConfig::vision, &VisionOptions::toy_reach>("toy_reach_mm", kDistance_mm, "how far the toy reaches"),\n')

units = sorted(str(path.relative_to(SOURCE)) for path in Path(SOURCE, "machine/config").rglob("*.cc"))
headers = '#include <cstdio>\n#include "calib/base/fields/page.h"\n#include "machine/config/machine_file.h"\n'
program = toy.program("panelcal_machine", units, headers + MAIN, "tests/machine/machine_test")

expect(toy.run(program, "[vision]\ntoy_reach_mm = 12.5") == (0, "12.5\n"), "the toy's value is not read")
expect(toy.run(program, "[vision]\n") == (0, "7\n"), "the toy's default is not kept")
code, text = toy.run(program, "[vision]\ntoy_reach_mm = -1")
expect(code == 2 and "machine.toml:2:16" in text, f"a value out of range is taken: {text}")
code, text = toy.run(program, "[vision]\ntoy_rech_mm = 1")
expect(code == 2 and "toy_reach_mm" in text, f"a misspelt key does not name the toy's: {text}")
code, text = toy.run(program)
expect("| `toy_reach_mm` |" in text and '"toy_reach_mm"' in text, "page or schema lack the toy")
