#include "Evaluation/ExperimentTable.h"
#include "Core/Base/Error.h"

#include <gtest/gtest.h>
#include <limits>

using namespace innergs;

TEST(ExperimentTable, AlignsTextAndQuotesCsv) {
  ExperimentTable table{"t", "A table", {"name", "psnr_db", "paper_db"}, {}, {"held out"}};
  table.add({"alpha, \"all\" axes", "32.5", "32.47"});
  table.add({"42³", "7.25", ""});
  EXPECT_EQ(textOf(table), "A table\n"
                           "name               psnr db  paper db\n"
                           "alpha, \"all\" axes     32.5     32.47\n"
                           "42³                   7.25         -\n"
                           "Note: held out\n\n");
  EXPECT_EQ(csvOf(table), "name,psnr_db,paper_db\n\"alpha, \"\"all\"\" axes\",32.5,32.47\n42³,7.25,\n");
}

TEST(ExperimentTable, RefusesRaggedRows) {
  ExperimentTable table{"t", "A table", {"a", "b"}, {}, {}};
  EXPECT_THROW(table.add({"1"}), Error);
}

TEST(ExperimentTable, WritesNumbersThatAreNone) {
  EXPECT_EQ(decimals(1.005, 1), "1.0");
  EXPECT_EQ(decimals(std::numeric_limits<double>::infinity(), 2), "inf");
  EXPECT_EQ(decimals(std::numeric_limits<double>::quiet_NaN(), 2), "");
}
