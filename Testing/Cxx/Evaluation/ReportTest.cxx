#include "Evaluation/Report.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <limits>
#include <nlohmann/json.hpp>

using namespace innergs;

namespace {

EvaluationReport report(const std::string& protocol) {
  EvaluationReport r;
  r.protocol = protocol;
  r.caseName = protocol == "paper" ? "withheld-5%" : "thick-4";
  r.samples = "12 voxels: some, \"quoted\"";
  r.peak = 255;
  r.voxels = 12;
  MethodScore gaussians;
  gaussians.name = "gaussians";
  gaussians.psnr = 31.25;
  gaussians.ssim = 0.875;
  gaussians.seconds = 2.5;
  if (protocol == "paper")
    gaussians.perPlane = {{Plane::Axial, 30, 0.9, 29, 7}, {Plane::Coronal, 31, 0.8, 30, 8}};
  else
    gaussians.cpuSeconds = 4.5, gaussians.peakMemory = 640'000'000;
  MethodScore perfect;
  perfect.name = "linear";
  perfect.psnr = std::numeric_limits<double>::infinity();
  perfect.ssim = 1;
  r.methods = {gaussians, perfect};
  return r;
}

} // namespace

TEST(Report, JsonHasTheAgreedShape) {
  const std::vector<EvaluationReport> one{report("paper")};
  const auto json = nlohmann::json::parse(jsonReport(one));
  EXPECT_EQ(json["protocol"], "paper");
  EXPECT_EQ(json["case"], "withheld-5%");
  EXPECT_DOUBLE_EQ(json["methods"]["gaussians"]["psnr"], 31.25);
  EXPECT_DOUBLE_EQ(json["methods"]["gaussians"]["ssim"], 0.875);
  EXPECT_DOUBLE_EQ(json["methods"]["gaussians"]["seconds"], 2.5);
  EXPECT_DOUBLE_EQ(json["methods"]["gaussians"]["per_plane"]["axial"]["psnr"], 30);
  EXPECT_EQ(json["methods"]["gaussians"]["per_plane"]["coronal"]["slices"], 8);
  EXPECT_TRUE(json["methods"]["linear"]["psnr"].is_null());
  const std::vector<EvaluationReport> two{report("paper"), report("held-out")};
  const auto array = nlohmann::json::parse(jsonReport(two));
  ASSERT_EQ(array.size(), 2u);
  EXPECT_FALSE(array[1]["methods"]["gaussians"].contains("cpu_seconds"));
  EXPECT_DOUBLE_EQ(array[0]["methods"]["gaussians"]["cpu_seconds"], 4.5);
  EXPECT_FALSE(array[1]["methods"]["gaussians"].contains("peak_memory_bytes"));
  EXPECT_EQ(array[0]["methods"]["gaussians"]["peak_memory_bytes"], 640'000'000);
  EXPECT_EQ(array[0]["protocol"], "held-out");
}

TEST(Report, TextPutsHeldOutNumbersFirstAndNamesTheSamples) {
  const std::vector<EvaluationReport> two{report("paper"), report("held-out")};
  const std::string text = textReport(two);
  EXPECT_LT(text.find("Protocol H (held-out), thick-4"), text.find("Protocol P (paper), withheld-5%"));
  EXPECT_NE(text.find("Samples: 12 voxels"), std::string::npos);
  EXPECT_NE(text.find("31.25"), std::string::npos);
  EXPECT_NE(text.find("30.00 / 0.9000"), std::string::npos);
  EXPECT_NE(text.find("Memory: 640 MB at most until gaussians was done."), std::string::npos);
}

TEST(Report, CsvHasOneRowPerMethodAndPlane) {
  const std::vector<EvaluationReport> two{report("paper"), report("held-out")};
  const std::string csv = csvReport(two);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 2 + 4);
  EXPECT_NE(csv.find("paper,withheld-5%,gaussians,axial,30.0000,0.900000,29.0000,2.500,12,"),
            std::string::npos);
  EXPECT_NE(csv.find("\"12 voxels: some, \"\"quoted\"\"\""), std::string::npos);
}
