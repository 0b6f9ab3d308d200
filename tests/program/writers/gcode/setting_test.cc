// SPDX-License-Identifier: Apache-2.0
#include "program/writers/gcode/setting.h"

#include <gtest/gtest.h>

namespace panelcal {
namespace {

GcodeTool row_of(std::optional<int> number, std::optional<Length> drill, double drill_z_mm) {
  GcodeTool row;
  row.number = number;
  row.drill = drill;
  row.work.drill_z = mm(drill_z_mm);
  return row;
}

GcodeSetting example() {
  GcodeSetting setting;
  setting.usual.drill_z = mm(-1);
  setting.usual.infeed = mm_per_s(10);
  setting.usual.speed = rpm(20'000);
  setting.tools = {row_of({}, mm(0.8), -2), row_of(3, {}, -3)};
  setting.tools[0].work.infeed = mm_per_s(7);
  return setting;
}

TEST(GcodeSetting, NumbersGoBeforeDiametersBeforeWhatIsUsual) {
  const GcodeSetting setting = example();
  EXPECT_EQ(setting.work_of({.number = 1, .diameter = mm(1)}).drill_z, mm(-1));
  EXPECT_EQ(setting.work_of({.number = 1, .diameter = {}}).drill_z, mm(-1));
  EXPECT_EQ(setting.work_of({.number = 1, .diameter = mm(0.8004)}).drill_z, mm(-2));
  EXPECT_EQ(setting.work_of({.number = 1, .diameter = mm(0.801)}).drill_z, mm(-1));
  // Each word by itself: the row of the number says no infeed.
  const GcodeWork both = setting.work_of({.number = 3, .diameter = mm(0.8)});
  EXPECT_EQ(both.drill_z, mm(-3));
  EXPECT_EQ(both.infeed, mm_per_s(7));
  EXPECT_EQ(both.speed, rpm(20'000));
}

TEST(GcodeSetting, TheProgramsRatesWin) {
  const Tool tool{.number = 3,
                  .diameter = mm(0.8),
                  .infeed = mm_per_s(50),
                  .retract = mm_per_s(200),
                  .speed = rpm(60'000)};
  const GcodeWork work = example().work_of(tool);
  EXPECT_EQ(work.infeed, mm_per_s(50));
  EXPECT_EQ(work.retract, mm_per_s(200));
  EXPECT_EQ(work.speed, rpm(60'000));
  EXPECT_EQ(example().work_of({.number = 1}).retract, std::nullopt);
}

}  // namespace
}  // namespace panelcal
