// SPDX-License-Identifier: Apache-2.0
// CNC-7 manual, Vision Step and Repeat: M50, M51, M52.
#include "calib/correction/memory.h"

#include <climits>

#include <gmock/gmock.h>

namespace panelcal {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// As in the manual's first example: a pattern of three G46 and two copies of it under M50,1.
CorrectionMemory three_patterns_of_three() {
  CorrectionMemory memory;
  memory.start_recording(1);
  for (const std::size_t series : {4, 5, 6}) memory.store({series, 3});
  memory.stop_recording();
  return memory;
}

TEST(CorrectionMemory, ManualExampleWalksOnePatternPerM52) {
  CorrectionMemory memory = three_patterns_of_three();
  EXPECT_TRUE(memory.rewind(1));
  EXPECT_THAT(memory.advance(3).passed, ElementsAre(4));
  EXPECT_THAT(memory.advance(3).passed, ElementsAre(5));
  EXPECT_THAT(memory.advance(3).passed, ElementsAre(6));
  EXPECT_EQ(memory.points_left(), 0);
  // The same corrections serve the next tool.
  EXPECT_TRUE(memory.rewind(1));
  EXPECT_EQ(memory.points_left(), 9);
  EXPECT_THAT(memory.advance(3).passed, ElementsAre(4));
}

TEST(CorrectionMemory, ThreeSingleM52AreOneM52Of3) {
  CorrectionMemory memory = three_patterns_of_three();
  memory.rewind(1);
  EXPECT_THAT(memory.advance(1).passed, IsEmpty());
  EXPECT_TRUE(memory.is_inside_series());
  EXPECT_THAT(memory.advance(1).passed, IsEmpty());
  EXPECT_TRUE(memory.is_inside_series());
  EXPECT_THAT(memory.advance(1).passed, ElementsAre(4));
  EXPECT_FALSE(memory.is_inside_series());
}

TEST(CorrectionMemory, OneM52MayPassSeveralSeries) {
  CorrectionMemory memory = three_patterns_of_three();
  memory.rewind(1);
  const CorrectionMemory::Advance far = memory.advance(7);
  EXPECT_THAT(far.passed, ElementsAre(4, 5));
  EXPECT_FALSE(far.beyond_end);
  EXPECT_TRUE(memory.is_inside_series());
  EXPECT_EQ(memory.points_left(), 2);
}

TEST(CorrectionMemory, DoesNotMoveBeyondTheEnd) {
  CorrectionMemory memory = three_patterns_of_three();
  memory.rewind(1);
  memory.advance(7);
  for (const int n_points : {3, 1000, INT_MAX}) {
    const CorrectionMemory::Advance beyond = memory.advance(n_points);
    EXPECT_TRUE(beyond.beyond_end);
    EXPECT_THAT(beyond.passed, IsEmpty());
    EXPECT_EQ(memory.points_left(), 2);
  }
  EXPECT_THAT(memory.advance(2).passed, ElementsAre(6));
}

TEST(CorrectionMemory, KeepsLabelsApart) {
  CorrectionMemory memory = three_patterns_of_three();
  memory.start_recording(2);
  memory.store({9, 1});
  memory.store({10, 2});
  memory.stop_recording();
  EXPECT_TRUE(memory.rewind(2));
  EXPECT_EQ(memory.points_left(), 3);
  EXPECT_THAT(memory.advance(3).passed, ElementsAre(9, 10));
  EXPECT_TRUE(memory.rewind(1));
  EXPECT_EQ(memory.points_left(), 9);
}

TEST(CorrectionMemory, KnowsOnlyRecordedLabels) {
  CorrectionMemory memory = three_patterns_of_three();
  memory.rewind(1);
  memory.advance(4);
  EXPECT_FALSE(memory.rewind(7));
  EXPECT_EQ(memory.points_left(), 5) << "a failed rewind must not move the pointer";
}

TEST(CorrectionMemory, StoresOnlyWhileRecording) {
  CorrectionMemory memory = three_patterns_of_three();
  EXPECT_FALSE(memory.is_recording());
  memory.store({99, 3});
  memory.rewind(1);
  EXPECT_EQ(memory.points_left(), 9);
}

TEST(CorrectionMemory, RecordingAgainReplaces) {
  CorrectionMemory memory = three_patterns_of_three();
  memory.rewind(1);
  memory.advance(3);
  memory.start_recording(1);
  EXPECT_TRUE(memory.is_recording());
  EXPECT_FALSE(memory.is_rewound()) << "the pointer stood in what was replaced";
  memory.store({20, 2});
  memory.stop_recording();
  EXPECT_TRUE(memory.rewind(1));
  EXPECT_THAT(memory.advance(2).passed, ElementsAre(20));
}

TEST(CorrectionMemory, RecordingAnotherLabelLeavesThePointer) {
  CorrectionMemory memory = three_patterns_of_three();
  memory.rewind(1);
  memory.advance(3);
  memory.start_recording(2);
  EXPECT_TRUE(memory.is_rewound());
  EXPECT_EQ(memory.points_left(), 6);
}

TEST(CorrectionMemory, ALabelMayBeEmpty) {
  CorrectionMemory memory;
  EXPECT_TRUE(memory.empty());
  memory.start_recording(3);
  memory.stop_recording();
  EXPECT_FALSE(memory.empty());
  EXPECT_TRUE(memory.rewind(3));
  EXPECT_EQ(memory.points_left(), 0);
  EXPECT_TRUE(memory.advance(1).beyond_end);
}

TEST(CorrectionMemory, ClearForgetsEverything) {
  CorrectionMemory memory = three_patterns_of_three();
  memory.rewind(1);
  memory.advance(1);
  memory.start_recording(2);
  memory.clear();
  EXPECT_TRUE(memory.empty());
  EXPECT_FALSE(memory.is_recording());
  EXPECT_FALSE(memory.is_rewound());
  EXPECT_FALSE(memory.is_inside_series());
  EXPECT_EQ(memory.points_left(), 0);
}

}  // namespace
}  // namespace panelcal
