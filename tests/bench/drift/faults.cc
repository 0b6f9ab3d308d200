// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/drift/faults.h"

namespace panelcal::bench {

std::vector<Fault> faults(Channel channel) {
  using enum FaultShape;
  switch (channel) {
    case Channel::Offset:
      return {{"step of 1 um", channel, Step, 1},
              {"step of 2 um", channel, Step, 2},
              {"step of 3 um", channel, Step, 3},
              {"step of 5 um", channel, Step, 5},
              {"step of 8 um", channel, Step, 8},
              {"step of 12 um", channel, Step, 12},
              {"step of 20 um", channel, Step, 20},
              {"ramp of 0.05 um a day", channel, Ramp, 0.05},
              {"ramp of 0.1 um a day", channel, Ramp, 0.1},
              {"ramp of 0.3 um a day", channel, Ramp, 0.3},
              {"ramp of 1 um a day", channel, Ramp, 1},
              {"one wild night, 6 um", channel, Wild, 6},
              {"one wild night, 15 um", channel, Wild, 15},
              {"loose mount, 2 um a night", channel, Loose, 2},
              {"loose mount, 5 um a night", channel, Loose, 5},
              {"hall warmer by 8 K", channel, Temperature, 8}};
    case Channel::Scatter:
      return {{"scatter 1.2 times", channel, Step, 1.2},
              {"scatter 1.5 times", channel, Step, 1.5},
              {"scatter 2.5 times", channel, Step, 2.5},
              {"scatter grows by 1 % a day", channel, Ramp, 0.01},
              {"scatter grows by 3 % a day", channel, Ramp, 0.03},
              {"scatter grows by 10 % a day", channel, Ramp, 0.1},
              {"one night 2.5 times", channel, Wild, 2.5}};
    case Channel::Contrast:
      break;
  }
  return {{"contrast lower by 2 %", channel, Step, 0.02},
          {"contrast lower by 5 %", channel, Step, 0.05},
          {"contrast lower by 20 %", channel, Step, 0.22},
          {"dying sensor, half in 60 nights", channel, Ramp, 0.0001925},
          {"dying sensor, half in 20 nights", channel, Ramp, 0.00173},
          {"one night 10 % lower", channel, Wild, 0.105}};
}

std::vector<Method> methods(Channel channel) {
  std::vector<Method> all = {
      {.name = "EWMA", .has_average = true},
      {.name = "CUSUM", .has_sum = true},
      {.name = "night", .has_night = true},
      {.name = "EWMA, CUSUM", .has_average = true, .has_sum = true},
      {.name = "night, EWMA", .has_night = true, .has_average = true},
      {.name = "night, CUSUM", .has_night = true, .has_sum = true},
      {.name = "night, EWMA, CUSUM", .has_night = true, .has_average = true, .has_sum = true}};
  if (channel != Channel::Offset) return all;
  const Method charts = all.back();
  for (Method more : {all[3], all[4], all[5], charts}) {
    more.has_moved = true;
    all.push_back(more);
  }
  // As many alarms as all charts and the limit of moves together give.
  all.push_back(charts);
  all.back().nights_per_false_alarm = 145;
  return all;
}

int onset_of(std::uint64_t seed) {
  return 60 + static_cast<int>(60 * Random(seed).fork(1'000'000).uniform());
}

}  // namespace panelcal::bench
