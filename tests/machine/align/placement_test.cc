// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "machine/align/pad_readers.h"
#include <fmt/format.h>
#include <gtest/gtest.h>

namespace panelcal {
namespace {

std::string fiducials(const std::string& text) {
  if (!internal::is_placement(text)) return "no placement";
  const auto found = internal::pads_of_placement(text, "a.pos");
  if (!found) return std::string(info(found.error().code).slug);
  std::string out;
  for (const internal::FoundPad& one : found->pads) {
    const Eigen::Vector2d at_mm = one.pad.nominal.in_mm();
    out += fmt::format("{}:{} {:g} {:g};", one.pad.line, one.pad.name, at_mm.x(), at_mm.y());
  }
  return out;
}

TEST(Placement, ReadsPositionsOfKicad) {
  EXPECT_EQ(
      fiducials(
          "### Footprint positions - created on Sat ###\n## Unit = mm, Angle = deg.\n"
          "# Ref     Val       Package                PosX       PosY       Rot  Side\n"
          "C1        100n      C_0402             10.0000   -20.0000    0.0000  top\n"
          "FID1      Fid       Fiducial_1mm      107.5000   -52.2500    0.0000  top\n"
          "FID2      Fid       Fiducial_1mm        1.0000    -2.0000    0.0000  bottom\n## End\n"),
      "5:FID1 107.5 -52.25;");
  EXPECT_EQ(fiducials("## Unit = inches, Angle = deg.\n# Ref Val Package PosX PosY Rot Side\n"
                      "FID1 F F 1.0 2.0 0 top\n"),
            "3:FID1 25.4 50.8;");
}

TEST(Placement, ReadsCsvOfKicadAndBoardHouses) {
  EXPECT_EQ(
      fiducials("Ref,Val,Package,PosX,PosY,Rot,Side\n\"FID3\",\"a, b\",\"F\",1.5,-2.5,0.0,top\n"),
      "2:FID3 1.5 -2.5;");
  EXPECT_EQ(fiducials("Designator;Mid X;Mid Y;Layer\nFID1;1.5mm;100mil;T\n"), "2:FID1 1.5 2.54;");
  EXPECT_EQ(fiducials("Designator,Center-X(mil),Center-Y(mil),Layer\nFID1,1000,0,TopLayer\n"),
            "2:FID1 25.4 0;");
}

TEST(Placement, RefusesRowsWithoutPlaceAndFilesWithoutFiducials) {
  EXPECT_EQ(fiducials("Ref,PosX,PosY\nFID1,1.5\n"), "number-malformed");
  EXPECT_EQ(fiducials("Ref,PosX,PosY\nFID1,1.5,abc\n"), "number-malformed");
  EXPECT_EQ(fiducials("Ref,PosX,PosY\nC1,1.5,2\nFIDDLE,1,2\n"), "usage");
  EXPECT_EQ(fiducials("M48\nMETRIC\n%\nX1Y1\nM30\n"), "no placement");
}

}  // namespace
}  // namespace panelcal
