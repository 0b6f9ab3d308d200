// SPDX-License-Identifier: Apache-2.0
#include "tools/batch/manifest/manifest.h"

#include <algorithm>
#include <string>

#include "tools/batch/manifest/csv_fields.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal::batch {
namespace {

using testing::ElementsAre;
using testing::IsSubsetOf;
using testing::Pair;
using testing::SizeIs;

Expected<Manifest> parsed(const std::string& text) {
  return parse_manifest(text, "jobs.csv", "folder", {.machine = "default.toml"});
}

TEST(BatchManifest, TakesNamesFromItsFolderAndKeepsFactors) {
  const auto manifest = parsed(
      "id,program,images,measurements,noise_um,note\n"
      "a,x/../job.exc,images,,2.50,\"one, \"\"two\"\"\"\n"
      "\n"
      ",/else/job.exc,,m.jsonl,,\r\n");
  ASSERT_TRUE(manifest) << manifest.error().text();
  ASSERT_THAT(manifest->jobs, SizeIs(2));
  const ManifestJob& first = manifest->jobs[0];
  EXPECT_EQ(first.program, "folder/job.exc");
  EXPECT_EQ(first.machine, "default.toml");
  EXPECT_EQ(first.images, "folder/images");
  EXPECT_THAT(first.factors, ElementsAre(Pair("noise_um", "2.50"), Pair("note", "one, \"two\"")));
  const ManifestJob& second = manifest->jobs[1];
  EXPECT_EQ(second.id, "000002");
  EXPECT_EQ(second.line, 4);
  EXPECT_EQ(second.program, "/else/job.exc");
  EXPECT_EQ(second.measurements, "folder/m.jsonl");
}

TEST(BatchManifest, ReadsTheSameFromJsonLines) {
  const auto manifest =
      parsed(R"({"program": "job.exc", "id": "a", "noise": 2.5, "lens": null, "is_new": true})"
             "\n");
  ASSERT_TRUE(manifest) << manifest.error().text();
  EXPECT_EQ(manifest->jobs.at(0).program, "folder/job.exc");
  EXPECT_THAT(manifest->jobs[0].factors,
              testing::UnorderedElementsAre(Pair("noise", "2.5"), Pair("is_new", "true")));
}

TEST(BatchManifest, RefusesTextBesideAQuote) {
  EXPECT_EQ(split_csv("a,\"b\"c").error(), 3);
  EXPECT_EQ(split_csv("a,b\"c\"").error(), 4);
  EXPECT_THAT(*split_csv(" a , ,\"\""), SizeIs(3));
}

TEST(BatchManifest, SampleOfMoreHoldsSampleOfFewer) {
  Manifest manifest;
  for (int i = 1; i <= 100; ++i) {
    manifest.jobs.push_back({.number = i, .id = "job-" + std::to_string(i)});
  }
  const auto few = sample_of(manifest, 10);
  const auto many = sample_of(manifest, 30);
  EXPECT_THAT(few, SizeIs(10));
  EXPECT_TRUE(std::ranges::is_sorted(many));
  EXPECT_THAT(few, IsSubsetOf(many));
  // Of the ids only: another order of the rows gives the same jobs.
  std::ranges::reverse(manifest.jobs);
  EXPECT_EQ(sample_of(manifest, 10), few);
  EXPECT_THAT(sample_of(manifest, 1000), SizeIs(100));
}

}  // namespace
}  // namespace panelcal::batch
