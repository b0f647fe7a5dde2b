#include "CommandRunner.h"
#include "SyntheticImages.h"

#include "IO/TimeSeriesIO.h"
#include "IO/TimeSeriesWriting.h"
#include "IO/VolumeIO.h"
#include "Onnx/TestNetworks.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <locale>
#include <sstream>
#include <string>

namespace innergs::test {
namespace {

class SegmentTest : public CommandTest {
protected:
  void SetUp() override {
    CommandTest::SetUp();
    const Volume scan = phantom();
    writeVolume(scan, path("scan.nii"));
    // The left half of the grid is the liver; a corner of the other half has two kidneys.
    labels_ = scan;
    const auto& n = scan.geometry.size;
    for (std::int64_t k = 0; k < n[2]; ++k)
      for (std::int64_t j = 0; j < n[1]; ++j)
        for (std::int64_t i = 0; i < n[0]; ++i)
          labels_.voxels[static_cast<std::size_t>(i + n[0] * (j + n[1] * k))] = i < n[0] / 2       ? 1.f
                                                                                : j < n[1] / 3     ? 2.f
                                                                                : j > 2 * n[1] / 3 ? 3.f
                                                                                                   : 0.f;
    writeVolume(labels_, path("labels.nii"), OutputType::UInt8);
    write("names.json", R"({"1": "liver", "2": "kidney_left", "3": "kidney_right"})");
    expectSuccess(run(quickly({"reconstruct", path("scan.nii"), "-q", "--save-model", path("m.innergs")})));
  }
  Outcome segment(std::vector<std::string> arguments, bool learn = true) {
    std::vector<std::string> all{"segment", path(learn ? "m.innergs" : "named.innergs")};
    if (learn)
      for (const std::string& word :
           {std::string("--labels"), path("labels.nii"), std::string("--names"), path("names.json")})
        all.push_back(word);
    all.insert(all.end(), arguments.begin(), arguments.end());
    return run(all);
  }
  Volume labels_;
};

TEST_F(SegmentTest, LearnsAnswersAndKeepsWhatItLearned) {
  const Outcome outcome = segment({"--query", "left kindey", "--query", "liver", "-o",
                                   path("out/found.seg.nrrd"), "--save-model", path("named.innergs")});
  ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("\"left kindey\" is kidney_left."), std::string::npos) << outcome.err;
  const Volume found = readVolume(path("out/found.seg.nrrd"));
  ASSERT_TRUE(sameGrid(found.geometry, labels_.geometry));
  int wrong = 0;
  for (std::size_t v = 0; v < found.voxels.size(); ++v)
    wrong += (found.voxels[v] == 1) != (labels_.voxels[v] == 2) ||
             (found.voxels[v] == 2) != (labels_.voxels[v] == 1);
  EXPECT_LT(wrong, 0.1 * static_cast<double>(found.voxels.size()));

  // The same from the saved model, on another grid; without a side, the query returns both.
  expectSuccess(segment({"--query", "kidney", "--spacing", "2", "-o", path("out/coarse.nii"), "-q"}, false));
  const Volume coarse = readVolume(path("out/coarse.nii"));
  EXPECT_TRUE(sameGrid(coarse.geometry, withSpacing(labels_.geometry, {2, 2, 2})));
  EXPECT_EQ(*std::max_element(coarse.voxels.begin(), coarse.voxels.end()), 2);

  expectSuccess(segment({"--query", "liver", "--score", path("out/score.nii"), "--threshold", "0.9",
                         "--largest", "--minimum-size", "10", "-o", path("out/sure.nii"), "-q"},
                        false));
  expectSuccess(segment({"--query", "liver", "--smooth", "3", "-o", path("out/smooth.nii"), "-q"}, false));
  const Volume score = readVolume(path("out/score.nii")), sure = readVolume(path("out/sure.nii")),
               smooth = readVolume(path("out/smooth.nii"));
  const auto inside = [](const Volume& v) { return std::count(v.voxels.begin(), v.voxels.end(), 1.f); };
  EXPECT_GT(inside(smooth), 0.8 * static_cast<double>(inside(sure)));
  for (std::size_t v = 0; v < score.voxels.size(); ++v)
    if (sure.voxels[v] == 1) {
      ASSERT_GE(score.voxels[v], 0.9f);
    }
}

TEST_F(SegmentTest, LabelsEveryFrameOfAMovingScan) {
  writeTimeSeries(movingBlob(6), path("in.nii.gz"));
  expectSuccess(run(
      {"interpolate", path("in.nii.gz"), "--save-model", path("moving.innergs"), "--kind", "motion", "-q"}));
  const TimeSeries truth = movingBlobLabels(6);
  writeVolume({truth.geometry, truth.frames[1]}, path("frame1.nii"), OutputType::UInt8);
  write("blob.json", R"({"1": "liver"})");
  const Outcome outcome = run({"segment", path("moving.innergs"), "--labels", path("frame1.nii"),
                               "--label-time", "0.5", "--names", path("blob.json"), "--query", "liver", "-o",
                               path("out/all.nii.gz"), "--save-model", path("labelled.innergs")});
  ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("2.5 s, liver: label 1"), std::string::npos) << outcome.err;
  const TimeSeries found = readTimeSeries(path("out/all.nii.gz"));
  ASSERT_EQ(found.size(), 6);
  for (std::size_t f = 0; f < 6; ++f) {
    double both = 0, sum = 0;
    for (std::size_t v = 0; v < truth.frames[f].size(); ++v) {
      both += found.frames[f][v] == 1 && truth.frames[f][v] == 1;
      sum += found.frames[f][v] + truth.frames[f][v];
    }
    EXPECT_GT(2 * both / sum, 0.85) << f;
  }

  // One time, from the saved model.
  expectSuccess(run({"segment", path("labelled.innergs"), "--query", "liver", "--time", "1.5", "-o",
                     path("out/one.seg.nrrd"), "--score", path("out/score.nii"), "-q"}));
  EXPECT_EQ(readVolume(path("out/one.seg.nrrd")).voxels, found.frames[3]);

  // Writing the model again keeps its segments and what it was made from.
  expectSuccess(run({"interpolate", path("labelled.innergs"), "--save-model", path("again.innergs"), "-q"}));
  EXPECT_EQ(contents("again.innergs"), contents("labelled.innergs"));

  expectOneSentence(
      run({"segment", path("labelled.innergs"), "--query", "liver", "--time", "9", "-o", path("out/x.nii")}),
      1, "time");
  expectOneSentence(run({"segment", path("labelled.innergs"), "--query", "liver", "-o", path("out/x.mha")}),
                    1, ".seq.nrrd");
  expectOneSentence(
      run({"segment", path("labelled.innergs"), "--query", "liver", "--score", path("out/x.nii")}), 2,
      "--time");
  expectOneSentence(run({"segment", path("moving.innergs"), "--query", "liver", "-o", path("out/x.nii")}), 1,
                    "--labels");
  expectOneSentence(segment({"-q", "--query", "liver", "--time", "1"}), 2, "dynamic scan");
}

TEST_F(SegmentTest, WhatGoesWrongIsOneSentence) {
  const auto failing = [&](std::vector<std::string> arguments, const std::string& mention, int code = 1) {
    expectOneSentence(segment(std::move(arguments)), code, mention);
  };
  failing({"-q", "--query", ""}, "empty");
  failing({"-q", "--query", std::string(2000, 'x')}, "2000 bytes");
  failing({"-q", "--query", "bicycle"}, "matches no segment");
  failing({"-q", "--query", "heart"}, "not in this volume");
  failing({"-q", "-o", path("out/x.nii")}, "--query", 2);
  failing({"-q", "--query", "liver", "--query", "kidneys", "--score", path("out/x.nii")}, "--score", 2);
  expectOneSentence(run({"segment", path("m.innergs"), "--query", "liver"}), 1, "--labels");
  expectOneSentence(run({"segment", path("m.innergs"), "--labels", path("labels.nii"), "--query", "liver"}),
                    1, "--names");
  expectOneSentence(run({"segment", path("m.innergs"), "-q", "--labels", path("scan.nii"), "--names",
                         path("names.json"), "--query", "liver"}),
                    1, "labelmap");
  failing({"-q", "--query", "liver", "--text-model", path("nowhere")}, "There is no folder");
  Volume away = labels_;
  away.geometry.origin[0] += 900;
  writeVolume(away, path("away.nii"));
  expectOneSentence(run({"segment", path("m.innergs"), "-q", "--labels", path("away.nii"), "--names",
                         path("names.json"), "--query", "liver"}),
                    1, "same patient");
}

TEST_F(SegmentTest, LearnsFromAFeatureVolumeAndItsTexts) {
  // Two numbers per voxel: the direction of each label's own.
  const auto number = [&](double angle) { return nlohmann::json{std::cos(angle), std::sin(angle)}; };
  write("texts.json",
        nlohmann::json{{"background", number(0)}, {"liver", number(1.2)}, {"kidney", number(2.4)}}.dump());
  const auto& n = labels_.geometry.size;
  const Mat3& d = labels_.geometry.direction;
  const Vec3 &spacing = labels_.geometry.spacing, &o = labels_.geometry.origin;
  std::ostringstream header;
  header.imbue(std::locale::classic());
  header << "NRRD0005\ntype: float\ndimension: 4\nspace: left-posterior-superior\nsizes: 2 " << n[0] << ' '
         << n[1] << ' ' << n[2] << "\nspace directions: none";
  for (int a = 0; a < 3; ++a)
    header << " (" << d[0][a] * spacing[a] << ',' << d[1][a] * spacing[a] << ',' << d[2][a] * spacing[a]
           << ')';
  header << "\nspace origin: (" << o[0] << ',' << o[1] << ',' << o[2]
         << ")\nkinds: vector domain domain domain\nendian: little\nencoding: raw\n\n";
  std::string bytes = header.str();
  for (const float label : labels_.voxels) {
    const double angle = label == 0 ? 0 : label == 1 ? 1.2 : 2.4;
    for (const float value : {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))})
      bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  write("features.nrrd", bytes);
  const std::vector<std::string> learn{"segment",
                                       path("m.innergs"),
                                       "--features",
                                       path("features.nrrd"),
                                       "--text-embeddings",
                                       path("texts.json"),
                                       "--query",
                                       "liver",
                                       "-o",
                                       path("liver.nii"),
                                       "--save-model",
                                       path("named.innergs")};
  expectSuccess(run(learn));
  const auto wrong = [&](const Volume& found, float label) {
    std::int64_t count = 0;
    for (std::size_t v = 0; v < found.voxels.size(); ++v)
      count += (found.voxels[v] == 1) != (labels_.voxels[v] == label);
    return static_cast<double>(count) / static_cast<double>(found.voxels.size());
  };
  EXPECT_LT(wrong(readVolume(path("liver.nii")), 1), 0.1);
  const Outcome again = run({"segment", path("named.innergs"), "--query", "liver", "-o", path("again.nii")});
  ASSERT_EQ(again.exitCode, 0) << again.err;
  EXPECT_EQ(readVolume(path("again.nii")).voxels, readVolume(path("liver.nii")).voxels);

  const auto refused = [&](const std::string& features, const std::string& texts) {
    std::vector<std::string> words = learn;
    words[3] = path(features);
    words[5] = path(texts);
    return run(words).err;
  };
  write("three.json", R"({"liver": [1, 0, 0]})");
  EXPECT_NE(refused("features.nrrd", "three.json").find("has 3 numbers, the feature volume 2"),
            std::string::npos);
  write("none.json", R"(["liver"])");
  EXPECT_NE(refused("features.nrrd", "none.json").find("does not hold text embeddings"), std::string::npos);
  EXPECT_NE(refused("labels.nii", "texts.json").find("one value per voxel"), std::string::npos);
  EXPECT_NE(refused("away.nrrd", "texts.json").find("does not exist"), std::string::npos);
}

TEST_F(SegmentTest, LearnsFromANetwork) {
  const auto learn = [&](std::vector<std::string> more) {
    std::vector<std::string> all{
        "segment", path("m.innergs"), "-q", "--network", path("network.onnx"), "--query", "liver"};
    all.insert(all.end(), more.begin(), more.end());
    return run(all);
  };
  write("channel.json", R"({"1": "liver"})");
  write("texts.json", R"({"background": [1, 0], "liver": [0, 1]})");
  expectOneSentence(learn({"--names", path("channel.json")}), 1, "There is no network");
  expectOneSentence(learn({}), 2, "--names");
  write("network.onnx", "no network");
  if (!openVino().functions) {
    expectOneSentence(learn({"--names", path("channel.json")}), 1, "OpenVINO");
    GTEST_SKIP() << openVino().problem;
  }
  expectOneSentence(learn({"--names", path("channel.json")}), 1, "not an ONNX network");
  // Bright voxels are the liver: the channels are the scaled image x and 1 - x.
  testing::writePointwise(path("network.onnx"), 3, 8, {-1, 1}, {1, 0});
  const Volume scan = readVolume(path("scan.nii"));
  const auto [low, high] = std::minmax_element(scan.voxels.begin(), scan.voxels.end());
  const std::vector<std::string> range{"--network-range", std::to_string(std::lround(*low)),
                                       std::to_string(std::lround(*high))};
  for (const auto& [option, file] :
       {std::pair{"--names", "channel.json"}, {"--text-embeddings", "texts.json"}}) {
    std::vector<std::string> more{option, path(file), "-o", path("bright.nii"), "--image", path("scan.nii")};
    more.insert(more.end(), range.begin(), range.end());
    const Outcome outcome = learn(more);
    ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
    const Volume found = readVolume(path("bright.nii"));
    ASSERT_EQ(found.voxels.size(), scan.voxels.size());
    int wrong = 0, bright = 0;
    const float middle =
        0.5f * (static_cast<float>(std::lround(*low)) + static_cast<float>(std::lround(*high)));
    for (std::size_t v = 0; v < found.voxels.size(); ++v) {
      bright += scan.voxels[v] > middle;
      wrong += (found.voxels[v] == 1) != (scan.voxels[v] > middle);
    }
    EXPECT_GT(bright, 0);
    EXPECT_LT(wrong, 0.1 * static_cast<double>(found.voxels.size())) << option;
  }
  write("seven.json", R"({"7": "liver"})");
  expectOneSentence(learn({"--names", path("seven.json")}), 1, "gives 2 channels");
}

} // namespace
} // namespace innergs::test
