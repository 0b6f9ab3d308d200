// SPDX-License-Identifier: Apache-2.0
// No word vanishes: each row of the command tables is in the written program, has been executed, or
// is named as lost.
#include <algorithm>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "program/sieb_meyer/text/cnc_commands.h"
#include "program/sieb_meyer/text/lexer.h"
#include "program/writers/sieb_meyer/writer.h"
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/sieb_meyer/manual_run.h"

namespace panelcal {
namespace {

using sieb_meyer::CncInfo;
using sieb_meyer::code_text;
using sieb_meyer::CommandInfo;
using sieb_meyer::Treatment;
using sieb_meyer::WordInfo;
using test::format_5000;
using test::FunctionSource;
using test::shifted_by;
using test::SubprogramFolder;

enum class Fate {
  Written,   ///< a line of the output has it
  Executed,  ///< what is written or asked for depends on it
  Lost,      ///< a diagnostic names it
  Refused,   ///< the program fails because of it
  Ignored,   ///< it means nothing, by the manual
};

/// One row of a command table in a program. The word in question stands between < and >.
struct Form {
  std::string_view row;
  std::string_view body;
  Fate fate = Fate::Written;
  std::string_view line = "";  ///< of the output; or a part of the diagnostic
};

/// Targets are found 0.5 mm and 0.25 mm away, the surface 3 mm above the table.
constexpr auto kForms = std::to_array<Form>({
    {"G1", "X0Y0T0T2\nX5.Y0<G1>\nX5.Y0T0\n", Fate::Written, "X5.Y0.G1"},
    {"G2", "X0Y0T0T2\nX2.Y0<G2>R1.\nX2.Y0T0\n", Fate::Written, "X2.Y0.G2I-1.J0."},
    {"G3", "X0Y0T0T2\nX2.Y0<G3>R1.\nX2.Y0T0\n", Fate::Written, "X2.Y0.G3I-1.J0."},
    {"G6", "X0Y0T0T2Z2.\nX5.Y0G1<G6>Z3.\nX5.Y0T0\n", Fate::Written, "X5.Y0.G1G6Z3."},
    {"G11", "X0Y0T0T2\nX5.Y0G1<G11>\nX5.Y0T0\n", Fate::Written, "X5.Y0.G1G11"},
    {"G30", "X0Y0G32\nG31\nX5.Y5.T1\n<G30\n>X6.Y6.\n", Fate::Executed, "X6.Y6."},
    {"G31", "X0Y0G32\n<G31\n>X5.Y5.T1\n", Fate::Executed, "X5.5Y5.25T1"},
    {"G32", "X0Y0<G32>\nG31\nX5.Y5.T1\n", Fate::Executed, "X5.5Y5.25T1"},
    {"G33", "X0Y0<G33>\nG31\nX5.Y5.T1\n", Fate::Executed, "X5.5Y5.25T1"},
    {"G34", "X0Y0G32\nG31\nX5.Y5.T1\n<G34\n>X6.Y6.\n", Fate::Executed, "X6.Y6."},
    {"G35", "<G35,3\n>X0Y0G32\nG31\nX5.Y5.T1\n", Fate::Executed, ""},
    {"G36", "X5.Y5.T1<G36>\n", Fate::Executed, "X5.5Y5.25T1"},
    {"G39", "X0Y0G32\nG31\nG39,SAVE1\nG34\n<G39,LOAD1\n>X5.Y5.T1\n", Fate::Executed, "X5.5Y5.25T1"},
    {"G39", "X0Y0G33\n<G39,REQCOMP\n>X5.Y5.T1\n", Fate::Executed, "X5.5Y5.25T1"},
    {"G40", "X0Y0T0T2\nX5.Y0G1G41\nX5.Y5.<G40>\nX5.Y5.T0\n", Fate::Written, "X5.Y5.G1G40"},
    {"G41", "X0Y0T0T2\nX5.Y0G1<G41>\nX5.Y0T0\n", Fate::Written, "X5.Y0.G1G41"},
    {"G42", "X0Y0T0T2\nX5.Y0G1<G42>\nX5.Y0T0\n", Fate::Written, "X5.Y0.G1G42"},
    {"G43", "X20.Y20.T0T2\nX20.Y20.G45R5.<G43>\nX20.Y20.T0\n", Fate::Executed, ""},
    {"G45", "X20.Y20.T0T2\nX20.Y20.<G45>R5.\nX20.Y20.T0\n", Fate::Executed, ""},
    {"G46", "X20.Y20.T0T2\nX20.Y20.<G46>R5.\nX20.Y20.T0\n", Fate::Executed, ""},
    {"G47", "X20.Y20.T0T2\nX20.Y20.<G47>R5.\nX20.Y20.T0\n", Fate::Executed, ""},
    {"G48", "X20.Y20.T0T2\nX20.Y20.<G48>R5.\nX20.Y20.T0\n", Fate::Executed, ""},
    {"G49", "X20.Y20.T0T2\nX20.Y20.<G49>R6.\nX20.Y20.T0\n", Fate::Executed, ""},
    {"G50", "X20.Y20.T0T2\nX20.Y20.<G50>R6.\nX20.Y20.T0\n", Fate::Executed, ""},
    {"G70", "X1.Y1.G73L1\nL1\nG71K.4\nX5.Y5.T1\nZ1.<G70>X6.Y5.\nX7.Y5.\n", Fate::Executed, ""},
    {"G71", "X1.Y1.G73L1\nL1\n<G71>K.4\nX5.Y5.T1\nG70\n", Fate::Written, "G71K0.4"},
    {"G72", "X1.Y1.G73L1\n<G72\n>L1\n", Fate::Refused, "L1"},
    {"G73", "X1.Y1.<G73>\nX1.Y1.T1\n", Fate::Written, "X1.Y1.G73"},
    {"G74", "X1.Y1.G73\n<G74L1\n>L1\nG71K.4\nX5.Y5.T1\nG70\n", Fate::Written, "G74L1"},
    {"G75", "X1.Y1.G73\n<G75\n>X5.Y5.T1\n", Fate::Written, "G75"},
    {"G76", "X1.Y1.<G76>\nX5.Y5.T1\n", Fate::Written, "X1.Y1.G76"},
    {"G77", "X1.Y1.G73L1\nL1\nG71K.4\nX5.Y5.T1<G77>\nG70\n", Fate::Executed, "X5.Y5.T1"},
    {"G78", "X1.Y1.<G78>\nX5.Y5.T1\n", Fate::Executed, ""},
    {"G79", "X0Y0G78\nX0Y0G79\nX9.Y0G79\nX0Y9.G79\nX9.Y9.<G79>\n", Fate::Executed, ""},
    {"G80", "X1.Y1.T1Z1.G81I5.P80J1.4W1000\nX2.Y1.<G80>\n", Fate::Written, "G80"},
    {"G81", "X1.Y1.T1Z1.<G81>I5.P80J1.4W1000\n", Fate::Written, "G81I5.P80J1.4W1000"},
    {"G82", "X1.Y1.T1Z1.\nX2.Y1.G83K1.\nX3.Y1.<G82>\n", Fate::Written, "X3.Y1.G82"},
    {"G83", "X1.Y1.T1Z1.\nX2.Y1.<G83>K1.\n", Fate::Written, "X2.Y1.G83K1."},
    {"G84", "X20.Y20.T1<G84>R2.\n", Fate::Executed, ""},
    {"G85", "X1.Y1.T1<G85>\nX9.Y1.\n", Fate::Written, "X1.Y1.T1G85"},
    {"G88", "X1.Y1.T1Z1.G89I5.J1.\nX2.Y1.<G88>\n", Fate::Written, "G88"},
    {"G89", "X1.Y1.T1Z1.<G89>I5.J1.\n", Fate::Written, "G89I5.J1."},
    {"G90", "X1.Y1.T1G91\nX1.Y1.<G90>\n", Fate::Executed, "X1.Y1."},
    {"G91", "X1.Y1.T1\nX1.Y1.<G91>\n", Fate::Executed, "X2.Y2."},
    {"M20", "X1.Y1.T1\nX2.Y1.<M20>\n", Fate::Written, "X2.Y1.M20"},
    {"M20", "X1.Y1.T1\n<M20\n>X2.Y1.\n", Fate::Written, "M20"},
    {"M20", "X1.Y1.T1\nX2.Y1.V2<M20>\nX4.Y1.W2\n", Fate::Written, "X2.Y1.M20"},
    {"M20", "X0Y0T0T2<M20>\nX5.Y0G1\nX5.Y0T0\n", Fate::Written, "X0.Y0.T2M20T0"},
    {"M20", "X0Y0T0T2\nX5.Y0G1\nX5.Y0T0<M20>\n", Fate::Written, "X5.Y0.T0M20"},
    {"M21", "X1.Y1.T1\nX2.Y1.<M21>\n", Fate::Written, "X2.Y1.M21"},
    {"M21", "X1.Y1.T1\nX2.Y1.V2<M21>\nX4.Y1.W2\n", Fate::Written, "X4.Y1.M21"},
    {"M21", "X0Y0T0T2\nX5.Y0G1<M21>\nX6.Y0\nX6.Y0T0\n", Fate::Written, "X5.Y0.M21G1"},
    {"M21", "X0Y0T0T2\nX5.Y0G1\nX5.Y0T0<M21>\n", Fate::Written, "X5.Y0.T0M21"},
    {"M21", "X1.Y1.<M21>G73\nX1.Y1.T1\n", Fate::Lost, "M21"},
    {"M22", "X1.Y1.T1\n<M22\n>", Fate::Written, "M22"},
    {"M23", "X1.Y1.T1\n<M23\n>", Fate::Written, "M23"},
    {"M24", "X1.Y1.T1\n<M24\n>", Fate::Written, "M24"},
    {"M25", "X1.Y1.T1\n<M25\n>", Fate::Written, "M25"},
    {"M26", "X1.Y1.T1\n<M26\n>", Fate::Written, "M26"},
    {"M27", "X1.Y1.T1\n<M27\n>", Fate::Written, "M27"},
    {"M28", "X1.Y1.T1<M28>\n", Fate::Written, "M28"},
    {"M28", "X0Y0T0T2\nX5.Y0G1<M28>\nX5.Y0T0\n", Fate::Written, "M28"},
    {"M29", "X1.Y1.T1<M29>\n", Fate::Written, "M29"},
    {"M29", "X0Y0T0T2\nX5.Y0G1<M29>\nX5.Y0T0\n", Fate::Written, "M29"},
    {"M30", "X1.Y1.T1M31\nX5.Y5.M50<M30>\n", Fate::Executed, "X6.Y6.T1"},
    {"M31", "X1.Y1.T1\nX2.Y2.<M31>\nX5.Y5.M50M30\n", Fate::Executed, "X7.Y7."},
    {"M34", "X1.Y1.T1\n<M34\n>", Fate::Written, "M34"},
    {"M35", "X1.Y1.T1\n<M35\n>", Fate::Written, "M35"},
    {"M36", "X1.Y1.T1\n<M36\n>", Fate::Written, "M36"},
    {"M37", "X1.Y1.T1\n<M37\n>", Fate::Written, "M37"},
    {"M38", "X1.Y1.T1\n<M38\n>", Fate::Written, "M38"},
    {"M39", "X1.Y1.T1\n<M39\n>", Fate::Written, "M39"},
    {"M40", "X1.Y1.T1\n<M40\n>", Fate::Written, "M40"},
    {"M41", "X1.Y1.T1\n<M41\n>", Fate::Written, "M41"},
    {"M42", "X1.Y1.T1\n<M42\n>", Fate::Written, "M42"},
    {"M43", "X1.Y1.T1\n<M43\n>", Fate::Written, "M43"},
    {"M44", "X1.Y1.T1\n<M44\n>", Fate::Written, "M44"},
    {"M45", "X1.Y1.T1\n<M45\n>", Fate::Written, "M45"},
    {"M47", "<M47,HI\n>X1.Y1.T1\n", Fate::Written, "M47,HI"},
    {"M49", "<M49,BROK2\n>X1.Y1.T1\n", Fate::Written, "M49,BROK2"},
    {"M49", "<M49,M101\n>X1.Y1.T1\n", Fate::Written, "M49,M101"},
    {"M50", "X1.Y2.T1M31\nX5.Y5.<M50>M30\n", Fate::Executed, "X6.Y7.T1"},
    {"M52", "X1.Y1.T1\n<M52\n>", Fate::Written, "M52"},
    {"M53", "X1.Y1.T1\n<M53\n>", Fate::Written, "M53"},
    {"M54", "X1.Y1.T1\n<M54\n>", Fate::Written, "M54"},
    {"M55", "X1.Y1.T1\n<M55\n>", Fate::Written, "M55"},
    {"M56", "<X1.Y1.M56\n>X5.Y5.T1\n", Fate::Written, "X1.000Y1.000M56"},
    {"M56", "X1.Y1.T1G91\n<X1.M56\n>", Fate::Written, "X2.000Y1.000M56"},
    {"M57", "<X1.Y1.M57\n>X5.Y5.T1\n", Fate::Written, "X1.000Y1.000M57"},
    {"M58", "<X1.Y1.M58D2.\n>X5.Y5.T1\nX1.Y1.\n", Fate::Executed, "X5.Y5.T1"},
    {"M60", "X1.Y2.T1M31\nX5.Y5.<M60>M30\n", Fate::Executed, "X3.Y6.T1"},
    {"M70", "X1.Y2.T1M31\nX5.Y5.<M70>M30\n", Fate::Executed, "X4.Y7.T1"},
    {"M75", "<M75,FIND A\n>X1.Y1.T1\n", Fate::Lost, "M75,FIND A"},
    {"M76", "<M76,LOT 7\n>X1.Y1.T1\n", Fate::Written, "M76,LOT 7"},
    {"M80", "X1.Y2.T1M31\nX5.Y5.<M80>M30\n", Fate::Executed, "X6.Y3.T1"},
    {"M90", "X1.Y2.T1M31\nX5.Y5.<M90>M30\n", Fate::Executed, "X4.Y3.T1"},
    {"M92", "M49,SAX1000.Y\nX10.Y10.T1M93\nX20.Y20.<M92>\n", Fate::Executed, "X20.Y20."},
    {"M93", "M49,SAX1000.Y\nX10.Y10.T1M92\nX20.Y20.<M93>\n", Fate::Executed, "X20.02Y20."},
    {"M94", "X1.Y1.T1\n<M94\n>", Fate::Written, "M94"},
    {"M95", "X1.Y1.T1\n<M95\n>", Fate::Written, "M95"},
    {"M97", "X30.Y10.T4<M97,C>\n", Fate::Executed, ""},
    {"M98", "X30.Y10.T4<M98,C>\n", Fate::Executed, ""},
    {"M99", "X5.Y5.T1<M99,SUB>\n", Fate::Executed, "X6.Y5.T1"},

    {"X#Y#", "X1.Y1.T1\n<X2.Y1.\n>", Fate::Written, "X2.Y1."},
    {"T#", "X1.Y1.T1\nX2.Y1.<T2>\n", Fate::Written, "X2.Y1.T2"},
    {"T#", "X1.Y1.T1\nX2.Y1.<T0>\n", Fate::Written, "X2.Y1.T0"},
    {"T#", "X1.Y1.<TD>G73\nX1.Y1.T1\n", Fate::Written, "X1.Y1.TDG73"},
    {"V1 V2 V3 V4, W# in the next line", "X1.Y1.T1<V2>\nX9.Y1.W5\n", Fate::Executed, "X3.Y1."},
    {"V1 V2 V3 V4, W# in the next line", "X1.Y1.T1V2\nX9.Y1.<W5>\n", Fate::Executed, "X3.Y1."},
    {"D#", "X0Y0T0T2\nX9.Y0G1<D2.>\nX9.Y9.\nX9.Y9.T0\n", Fate::Executed, "X7.Y0.G1"},
    {"F#", "X0Y0T0T2\nX5.Y0G1<F1.5>\nX5.Y0T0\n", Fate::Written, "X5.Y0.G1F1.5"},
    {"H#", "<H5.\n>X1.Y1.T1\n", Fate::Written, "H5.000"},
    {"K#", "X1.Y1.T1G83K1.\nX2.Y1.<K2.>\n", Fate::Written, "X2.Y1.K2."},
    {"Z#", "X1.Y1.T1Z1.\nX2.Y1.<Z2.>\n", Fate::Written, "X2.Y1.Z2."},
    {"L#", "X1.Y1.G73L1\n<L5\n>X5.Y5.T1\n", Fate::Refused, "L5"},
    {"R#", "X0Y0T0T2\nX2.Y0G2R1.\nX4.Y0<R2.>\nX4.Y0T0\n", Fate::Executed, ""},
    {"I# J#", "X0Y0T0T2\nX2.Y0G2<I-1.J0>\nX2.Y0T0\n", Fate::Written, "X2.Y0.G2I-1.J0."},
    {"I#P#J#W# E#R#", "X1.Y1.T1Z1.G81<I5.P80J1.4W1000>\n", Fate::Written, "G81I5.P80J1.4W1000"},
    {"I#P#J#W# E#R#", "X1.Y1.T1Z1.G89<I5.J1.E30R.2>\n", Fate::Written, "G89I5.J1.E30R0.2"},
    {"@name", "X5.Y5.T1<M99,SUB>\n", Fate::Executed, "X6.Y5.T1"},
    {"(text", "X1.Y1.T1<(HERE)>\n", Fate::Ignored},
    {"/", "M49,BLKD\nX5.Y5.T1\n</>X1.Y1.\n", Fate::Executed, "X5.Y5.T1"},
    {"%% %%3000 %%5000", "%%<3000>\nX1000Y1000T1\n$\nT1D100\n$\n", Fate::Executed, "X1.Y1.T1"},
    {"$", "%%5000\nX1.Y1.T1\n$\nT1<D1.>\n$\n", Fate::Written, "T1D1."},
    {"$", "%%5000\nX1.Y1.T1\n$\nT1<S50>\n$\n", Fate::Written, "T1S50."},
    {"$", "%%5000\nX1.Y1.T1\n$\nT1<F2.>\n$\n", Fate::Written, "T1F2."},
    {"$", "%%5000\nX1.Y1.T1\n$\nT1<R9.9>\n$\n", Fate::Written, "T1R9.9"},
    {"$", "%%5000\nX1.Y1.T1\n$\nT1<N3000>\n$\n", Fate::Written, "T1N3000"},
    {"$", "%%5000\nX1.Y1.T1\n$\nT1<A300>\n$\n", Fate::Written, "T1A0.3"},
    {"$", "%%5000\nX1.Y1.T1\n$\nT1<Z.01>\n$\n", Fate::Written, "T1Z0.01"},
    {"$", "%%5000\nX1.Y1.T1\n$\nT1D1.<S>\n$\n", Fate::Written, "T1D1.S"},
    {"$", "%%5000\nX1.Y1.T1\n$\nT1D1.\n<M1M2\n>$\n", Fate::Written, "M1M2"},
    {"$", "%%5000\nX1.Y1.T1\n$\nT1D1.\n<T7D3.\n>$\n", Fate::Written, "T7D3."},

    {"M49,FV", "<M49,FV2\n>X1.Y2.T1\n", Fate::Written, "M49,FV2"},
    {"M49,SAZ", "M49,SAX1000.Y\n<M49,SAZX10.Y\n>X20.Y2.T1M93\n", Fate::Executed, "X20.01Y2.T1"},
    {"M49,SA", "<M49,SAX1000.Y\n>X20.Y2.T1M93\n", Fate::Executed, "X20.02Y2.T1"},
    {"M49,NOSA", "M49,SAX1000.Y\n<M49,NOSA\n>X20.Y2.T1M93\n", Fate::Executed, "X20.Y2.T1"},
    {"M49,FA", "<M49,FAX5.Y6.\n>X1.Y2.T1\n", Fate::Written, "M49,FAX5.Y6."},
    {"M49,FA", "<M49,FAX0Y0\n>X1.Y2.T1\n", Fate::Written, "M49,FAX0.Y0."},
    {"M49,NOFA", "<M49,NOFA\n>X1.Y2.T1\n", Fate::Written, "M49,NOFA"},
    {"M49,RA", "<M49,RA90\n>X1.Y2.T1\n", Fate::Executed, "X-2.Y1.T1"},
    {"M49,NORA", "M49,RA90\n<M49,NORA\n>X1.Y2.T1\n", Fate::Executed, "X1.Y2.T1"},
    {"M49,NIBO", "<M49,NIBO\n>X1.Y1.T1G85\nX9.Y1.\n", Fate::Written, "M49,NIBO"},
    {"M49,NONIBO", "M49,NIBO\n<M49,NONIBO\n>X1.Y1.T1G85\nX9.Y1.\n", Fate::Executed, "M49,NONIBO"},
    {"M49,NIB", "<M49,NIB.02\n>X1.Y1.T1G85\nX9.Y1.\n", Fate::Written, "M49,NIB.02"},
    {"M49,BLKD", "<M49,BLKD\n>X5.Y5.T1\n/X1.Y1.\n", Fate::Written, "M49,BLKD"},
    {"M49,NOBLKD", "<M49,NOBLKD\n>X5.Y5.T1\n/X1.Y1.\n", Fate::Written, "M49,NOBLKD"},
    {"M49,CAMA",
     "<M49,CAMA\n>X1.Y1.T1M31\nX2.Y2.G36\nX3.Y3.\nXYM50M30\n",
     Fate::Executed,
     "X3.5Y3.25"},
    {"M49,NOCAMA",
     "M49,CAMA\n<M49,NOCAMA\n>X1.Y1.T1M31\nX2.Y2.G36\nX3.Y3.\nXYM50M30\n",
     Fate::Executed,
     "X3.Y3."},
    {"M49,SPAV", "<M49,SPAV,M\n>X1.Y1.T1\n", Fate::Written, "M49,SPAV,M"},
    {"M49,BOTR", "<M49,BOTR3.\n>X1.Y1.T1\n", Fate::Written, "M49,BOTR3."},
    {"M49,TOPR", "<M49,TOPR3.\n>X1.Y1.T1\n", Fate::Written, "M49,TOPR3."},
    {"M49,BOTT", "<M49,BOTT,R.1\n>X1.Y1.T1\n", Fate::Written, "M49,BOTT,R.1"},
    {"M49,TOPT", "<M49,TOPT,R.1\n>X1.Y1.T1\n", Fate::Written, "M49,TOPT,R.1"},
    {"M49,MAPT", "<M49,MAPT1.\n>X1.Y1.T1\n", Fate::Written, "M49,MAPT1."},
    {"M49,PRGM", "<M49,PRGM,-C\n>X1.Y1.T1\n", Fate::Written, "M49,PRGM,-C"},
    {"M49,ROUT", "<M49,ROUT,A\n>X1.Y1.T1\n", Fate::Written, "M49,ROUT,A"},
    {"M49,BOTK", "<M49,BOTK1.\n>X1.Y1.T1\n", Fate::Written, "M49,BOTK1."},
    {"M49,TOPK", "<M49,TOPK1.\n>X1.Y1.T1\n", Fate::Written, "M49,TOPK1."},
    {"M49,BOTL", "<M49,BOTL5\n>X1.Y1.T1\n", Fate::Written, "M49,BOTL5"},
    {"M49,TOPL", "<M49,TOPL5\n>X1.Y1.T1\n", Fate::Written, "M49,TOPL5"},
    {"M49,FORB", "<M49,FORB,A\n>X1.Y1.T1\n", Fate::Written, "M49,FORB,A"},
    {"M49,PEKM", "<M49,PEKM,D\n>X1.Y1.T1Z2.G81I4.5P20J1.2W500\n", Fate::Written, "M49,PEKM,D"},
    {"M49,PEKM",
     "M49,PEKM,D\n<M49,PEKM,-D\n>X1.Y1.T1Z2.G81I4.5P20J1.2W500\n",
     Fate::Lost,
     "[peck-target-missed]"},
    {"M49,OPID", "<M49,OPID,I\n>X30.Y10.T4M97,*\n", Fate::Written, "M49,OPID,I"},
    {"M49,OPID", "<M49,OPID,I\n>X30.Y10.T4M97,*\n", Fate::Executed, "X33.6Y17.2"},
});

/// A command that is passed on as it stands needs no example of its own.
std::vector<std::string> passed_on() {
  std::vector<std::string> texts;
  for (const CncInfo& row : sieb_meyer::cnc_table()) {
    if (row.treatment == Treatment::Passed) texts.push_back(fmt::format("M49,{}", row.name));
  }
  return texts;
}

struct Outcome {
  std::vector<std::string> lines;  ///< of the output
  std::string all;                 ///< that, all that was asked for, and all that was said
  std::vector<std::string> said;
  bool is_refused = false;
};

Outcome outcome_of(const std::string& body) {
  SubprogramFolder folder;
  folder.with("SUB.SS5", "@SUB\nX1.Y0\n");
  WalkOptions options;
  options.slots = Cycles::Kept;
  options.sieb_meyer.obeys_areas = true;
  options.sieb_meyer.surface_height = mm(3);
  // G39,REQCOMP "requires measurement mode 3"; to one layer of a target all modes do the same.
  if (body.find("REQCOMP") != std::string::npos) options.sieb_meyer.measurement_mode = 3;
  const bool is_whole = body.starts_with("%%");
  DiagnosticLog log;
  const Program program =
      load_program({"p", is_whole ? body : format_5000(body)}, log, folder.reading());
  FunctionSource source = shifted_by(0.5, 0.25);
  const Survey found = survey(program, options, source, log);
  Outcome outcome;
  StringSink bytes;
  SiebMeyerWriter writer(bytes, ProgramWriterOptions{});
  if (!log.has_errors()) {
    execute(program, options, found, writer, log);
    if (const Expected<void> done = writer.finish(); !done) log.add(done.error());
  }
  outcome.is_refused = log.has_errors();
  for (const Diagnostic& diagnostic : log.kept()) outcome.said.push_back(diagnostic.text());
  for (const Diagnostic& loss : writer.losses().kept()) outcome.said.push_back(loss.text());
  outcome.all = bytes.text() + measurement_lines(found);
  for (const ProbeReading& reading : found.probes) outcome.all += to_json(reading) + '\n';
  for (const std::string& text : outcome.said) outcome.all += text + '\n';
  std::string_view rest = bytes.text();
  while (!rest.empty()) {
    const auto end = std::min(rest.find('\n'), rest.size() - 1);
    outcome.lines.emplace_back(rest.substr(0, end));
    rest.remove_prefix(end + 1);
  }
  return outcome;
}

std::string text_of(const Outcome& outcome) {
  std::string text;
  for (const std::string& line : outcome.lines) text += line + '\n';
  return text;
}

std::string with_word(std::string_view body) {
  std::string text(body);
  std::erase_if(text, [](char c) { return c == '<' || c == '>'; });
  return text;
}

std::string without_word(std::string_view body) {
  const auto begin = body.find('<');
  const auto end = body.find('>', begin);
  return std::string(body.substr(0, begin)) + std::string(body.substr(end + 1));
}

void expect_fate(const Form& form) {
  SCOPED_TRACE(fmt::format("{}: {}", form.row, form.body));
  const Outcome with = outcome_of(with_word(form.body));
  const Outcome without = outcome_of(without_word(form.body));
  EXPECT_EQ(with.is_refused, form.fate == Fate::Refused) << testing::PrintToString(with.said);
  if (form.fate == Fate::Ignored) {
    EXPECT_EQ(with.all, without.all);
    return;
  }
  EXPECT_NE(with.all, without.all) << "it vanishes";
  switch (form.fate) {
    case Fate::Lost:
      EXPECT_THAT(with.said, testing::Contains(testing::HasSubstr(std::string(form.line))));
      EXPECT_THAT(without.said,
                  testing::Not(testing::Contains(testing::HasSubstr(std::string(form.line)))));
      return;
    case Fate::Refused:
      EXPECT_FALSE(without.is_refused) << testing::PrintToString(without.said);
      EXPECT_THAT(with.said, testing::Contains(testing::HasSubstr(std::string(form.line))));
      return;
    default:
      if (!form.line.empty()) {
        EXPECT_THAT(with.lines, testing::Contains(form.line));
      }
      if (form.fate == Fate::Written) {
        EXPECT_THAT(without.lines, testing::Not(testing::Contains(form.line)));
      }
  }
}

TEST(SiebMeyerWrittenForm, NoWordVanishes) {
  for (const Form& form : kForms) expect_fate(form);
  for (const std::string& text : passed_on()) {
    const std::string body = '<' + text + ",1\n>X1.Y1.T1\n";
    const std::string line = text + ",1";
    expect_fate({text, body, Fate::Written, line});
  }
}

TEST(SiebMeyerWrittenForm, EveryRowOfTheTablesHasAForm) {
  std::set<std::string, std::less<>> shown;
  for (const Form& form : kForms) shown.emplace(form.row);
  for (const std::string& text : passed_on()) shown.emplace(text);
  std::vector<std::string> missing;
  const auto look_for = [&](std::string row) {
    if (!shown.contains(row)) missing.push_back(std::move(row));
  };
  for (const CommandInfo& row : sieb_meyer::command_table()) look_for(code_text(row.command));
  for (const WordInfo& row : sieb_meyer::word_table()) look_for(std::string(row.form));
  for (const CncInfo& row : sieb_meyer::cnc_table()) {
    if (row.treatment != Treatment::Refused) look_for(fmt::format("M49,{}", row.name));
  }
  EXPECT_THAT(missing, testing::IsEmpty());
}

TEST(SiebMeyerWrittenForm, RefusedCncCommandsWriteNothing) {
  for (const CncInfo& row : sieb_meyer::cnc_table()) {
    if (row.treatment != Treatment::Refused) continue;
    const Outcome outcome = outcome_of(fmt::format("M49,{}1\nX1.Y1.T1\n", row.name));
    EXPECT_TRUE(outcome.is_refused) << row.name;
    EXPECT_THAT(outcome.lines, testing::IsEmpty()) << row.name;
  }
}

/// What we write is a program of its own: it needs nothing that was executed before it was written.
TEST(SiebMeyerWrittenForm, WrittenAgainItIsTheSame) {
  for (const Form& form : kForms) {
    if (form.fate == Fate::Refused) continue;
    SCOPED_TRACE(fmt::format("{}: {}", form.row, form.body));
    const Outcome once = outcome_of(with_word(form.body));
    const Outcome twice = outcome_of(text_of(once));
    EXPECT_FALSE(twice.is_refused) << testing::PrintToString(twice.said);
    EXPECT_EQ(twice.lines, once.lines);
  }
}

// --- a program does not depend on what the control did before ------------------------------------

/// "The programmed CNC commands remain active after the execution is finished" (M49).
TEST(SiebMeyerWrittenForm, EveryProgramStatesItsAxesItsNibblingAndThatNothingIsScaledOrTurned) {
  const auto first_lines = [](const std::string& body, std::size_t n) {
    std::vector<std::string> lines = outcome_of(body).lines;
    lines.resize(std::min(lines.size(), n));
    return lines;
  };
  using testing::ElementsAre;
  EXPECT_THAT(
      first_lines("X1.Y2.T1\n", 7),
      ElementsAre(
          "%%5000", "M49,FV1", "M49,NONIBO", "M49,NIB0.013", "M49,NORA", "M49,NOSA", "X1.Y2.T1"));
  EXPECT_THAT(
      first_lines("M49,FV2\nX1.Y2.T1\n", 7),
      ElementsAre(
          "%%5000", "M49,FV2", "M49,NONIBO", "M49,NIB0.013", "M49,NORA", "M49,NOSA", "X1.Y2.T1"));
  EXPECT_THAT(first_lines("M49,RA90\nM49,SAX1000.Y1000.\nX1.Y2.T1M93\n", 7),
              ElementsAre("%%5000",
                          "M49,FV1",
                          "M49,NONIBO",
                          "M49,NIB0.013",
                          "M49,NORA",
                          "M49,NOSA",
                          "X-2.002Y1.001T1"));
}

/// What SA alone scales is written as what M93 scales: no control has to read it in one way.
TEST(SiebMeyerWrittenForm, AScaleThatIsAssumedIsWrittenAsOneThatIsStated) {
  const Outcome assumed = outcome_of("M49,SAX1000.Y1000.\nX10.Y20.T1\nX30.Y40.\n");
  const Outcome stated = outcome_of("M49,SAX1000.Y1000.\nX10.Y20.T1M93\nX30.Y40.\n");
  EXPECT_EQ(assumed.lines, stated.lines);
  EXPECT_THAT(assumed.lines, testing::IsSupersetOf({"M49,NOSA", "X10.01Y20.02T1", "X30.03Y40.04"}));
}

/// What is passed on as written keeps its meaning: the program goes on in the axes that it states.
TEST(SiebMeyerWrittenForm, WritesInTheAxesThatTheSourceStates) {
  EXPECT_THAT(outcome_of("M47,A\nM49,FV3\nX1.Y2.T1\nX5.Y6.M56\n").lines,
              testing::IsSupersetOf({"M47,A", "M49,FV3", "X1.Y2.T1", "X5.000Y6.000M56"}));
}

/// M20 and M21 act on the coordinate of their line: alone, M20 sends the table to machine zero, and
/// M21 is over when the next line starts.
TEST(SiebMeyerWrittenForm, StopsAndOutputsStandInTheLineOfTheirPlace) {
  const auto body = [](const Outcome& outcome) {
    const auto end = std::ranges::find(outcome.lines, "$");
    return std::vector<std::string>(outcome.lines.begin() + 6, end);
  };
  using testing::ElementsAre;
  EXPECT_THAT(body(outcome_of("X1.Y1.T1M20\nX2.Y1.M20M21\nX3.Y1.\n")),
              ElementsAre("X1.Y1.T1M20", "X2.Y1.M20M21", "X3.Y1."));
  EXPECT_THAT(body(outcome_of("X1.Y1.T1\nX2.Y1.V2M20M21\nX4.Y1.W2\nX5.Y1.\n")),
              ElementsAre("X1.Y1.T1", "X2.Y1.M20M21", "X4.Y1.M21", "X5.Y1."));
  // M20 stops before its coordinate: in the line that ends the contour, with the cutter down.
  EXPECT_THAT(body(outcome_of("X1.Y1.T0T2\nX5.Y1.G1\nX5.Y1.T0\nX5.Y1.T0M20\nX9.Y1.G1\nX9.Y1.T0\n"
                              "X9.Y1.T0M21\nX9.Y5.G1\nX9.Y5.T0\n")),
              ElementsAre("X1.Y1.T2T0",
                          "X5.Y1.G1",
                          "X5.Y1.T0",
                          "X5.Y1.M20T0",
                          "X9.Y1.G1",
                          "X9.Y1.T0",
                          "X9.Y1.M21T0",
                          "X9.Y5.G1",
                          "X9.Y5.T0"));
  // The hole of that line is left out.
  const Outcome omitted = outcome_of("X1.Y1.M58D2.\nX5.Y5.T1\nX1.Y1.M20M21\nX6.Y5.\n");
  EXPECT_THAT(body(omitted), ElementsAre("X5.Y5.T1", "M20", "X6.Y5."));
  EXPECT_THAT(omitted.said,
              testing::Contains(testing::HasSubstr("M21 at a place that is not worked at")));
}

/// "If only the code letter is saved for a parameter, the value is reset to zero"; "ten magazines
/// in the list and the end of the magazine list are followed by a line break" (A.7.1).
TEST(SiebMeyerWrittenForm, TheToolTableIsWhole) {
  const std::string table = "$\nT1D1.SNA0.3Z\nM1M2M3M4M5M6M7M8M9M10\nM11M12\nT2D2.5\n$\n";
  EXPECT_THAT(text_of(outcome_of("%%5000\nX1.Y1.T1\n" + table)), testing::EndsWith('\n' + table));
  // Format 1000: six empty values of T2, which is in M2 (A.5).
  EXPECT_THAT(text_of(outcome_of("%%\nX1000Y1000T2\n$" + std::string(90, '$') + "\n")),
              testing::EndsWith("\n$\nT2DSFRNA\nM2\n$\n"));
}

/// A control that was left in any axis version: what we write is read as it was meant.
TEST(SiebMeyerWrittenForm, ReadsBackAlikeWhateverTheControlWasLeftWith) {
  for (int version = 1; version <= 8; ++version) {
    const std::string body = fmt::format("M49,FV{}\nX1.Y2.T1\nX3.Y5.\n", version);
    ReadOptions reading;
    const auto places = [](const std::string& text, int left_in) {
      ReadOptions left;
      left.axis_version = left_in;
      return test::hole_places(test::run_program(text, {}, left));
    };
    const std::string written = text_of(outcome_of(body));
    for (int left_in = 1; left_in <= 8; ++left_in) {
      test::expect_places(places(written, left_in), places(format_5000(body), 1));
    }
  }
}

}  // namespace
}  // namespace panelcal
