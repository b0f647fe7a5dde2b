#include "IO/TimeSeriesIO.h"
#include "TestFiles.h"

#include "IO/DynamicModelFile.h"
#include "IO/TimeSeriesWriting.h"
#include "IO/VolumeIO.h"

#include <cstring>

using namespace innergs;
using namespace innergs::test;

namespace {

TimeSeries ramp(std::vector<double> times) {
  TimeSeries series;
  series.geometry.size = {5, 4, 3};
  series.geometry.spacing = {1.5, 2, 3};
  series.geometry.origin = {-10, 20, 5};
  for (std::size_t f = 0; f < times.size(); ++f) {
    auto& frame = series.frames.emplace_back();
    for (int v = 0; v < 60; ++v)
      frame.push_back(static_cast<float>(v + 100 * f));
  }
  series.times = std::move(times);
  return series;
}

Error errorOfReading(const std::filesystem::path& path, const TimeSeriesOptions& options = {}) {
  return errorOf([&] { readTimeSeries(path, options); });
}

void expectTimes(const std::vector<double>& times, const std::vector<double>& expected,
                 double tolerance = 1e-6) {
  ASSERT_EQ(times.size(), expected.size());
  for (std::size_t f = 0; f < times.size(); ++f)
    EXPECT_NEAR(times[f], expected[f], tolerance);
}

} // namespace

TEST(TimeSeriesIO, WrittenFilesReadBackWithTimesAndGeometry) {
  const TemporaryFolder folder;
  for (const char* name : {"a.seq.nrrd", "b.nii", "c.nii.gz"})
    for (const std::vector<double>& times :
         {std::vector<double>{0, 0.5, 1}, std::vector<double>{0.25, 0.5, 2}})
      for (const OutputType type : {OutputType::Float32, OutputType::Int16}) {
        SCOPED_TRACE(name);
        const TimeSeries series = ramp(times);
        EXPECT_EQ(writeTimeSeries(series, folder / name, type), "");
        const TimeSeries back = readTimeSeries(folder / name);
        EXPECT_EQ(back.frames, series.frames);
        EXPECT_TRUE(sameGrid(back.geometry, series.geometry));
        expectTimes(back.times, times);
      }
}

TEST(TimeSeriesIO, TimesComeFromTheOptionsTheSidecarOrTheHeader) {
  const TemporaryFolder folder;
  writeTimeSeries(ramp({0, 2, 4}), folder / "a.nii.gz");
  expectTimes(readTimeSeries(folder / "a.nii.gz").times, {0, 2, 4});
  expectTimes(readTimeSeries(folder / "a.nii.gz", {{}, 0.1}).times, {0, 0.1, 0.2});
  expectTimes(readTimeSeries(folder / "a.nii.gz", {{1, 2, 7}, {}}).times, {1, 2, 7});
  writeBytes(folder / "a.json", R"({"RepetitionTime": 2, "VolumeTiming": [0, 3, 4]})");
  expectTimes(readTimeSeries(folder / "a.nii.gz").times, {0, 3, 4});
  writeBytes(folder / "a.json", R"({"VolumeTiming": [0, 3]})");
  EXPECT_EQ(errorOfReading(folder / "a.nii.gz").code(), ErrorCode::InvalidArgument);
  EXPECT_EQ(errorOfReading(folder / "a.nii.gz", {{0, 1}, {}}).code(), ErrorCode::InvalidArgument);
  EXPECT_EQ(errorOfReading(folder / "a.nii.gz", {{0, 1, 1}, {}}).code(), ErrorCode::InvalidArgument);
  EXPECT_EQ(errorOfReading(folder / "a.nii.gz", {{}, -1.0}).code(), ErrorCode::InvalidArgument);
}

TEST(TimeSeriesIO, SliceTimesComeFromTheSidecar) {
  const TemporaryFolder folder;
  writeTimeSeries(ramp({0, 2, 4}), folder / "a.nii.gz"); // 5 × 4 × 3
  EXPECT_TRUE(readTimeSeries(folder / "a.nii.gz").sliceTiming.empty());
  const auto timing = [&](const char* json) {
    writeBytes(folder / "a.json", json);
    return readTimeSeries(folder / "a.nii.gz").sliceTiming;
  };
  const auto code = [&](const char* json) {
    writeBytes(folder / "a.json", json);
    return errorOfReading(folder / "a.nii.gz").code();
  };
  SliceTiming expected{2, {0, 1, 0.5}};
  EXPECT_EQ(timing(R"({"SliceTiming": [0, 1, 0.5]})"), expected);
  EXPECT_EQ(timing(R"({"SliceTiming": [0, 1, 0.5], "SliceEncodingDirection": "k"})"), expected);
  expected.times = {0.5, 1, 0};
  EXPECT_EQ(timing(R"({"SliceTiming": [0, 1, 0.5], "SliceEncodingDirection": "k-"})"), expected);
  expected = {1, {0, 1, 0.5, 1.5}};
  EXPECT_EQ(timing(R"({"SliceTiming": [0, 1, 0.5, 1.5], "SliceEncodingDirection": "j"})"), expected);
  EXPECT_TRUE(timing(R"({"SliceTiming": [0, 0, 0]})").empty()); // all at once
  EXPECT_TRUE(timing(R"({"SliceTiming": "unknown"})").empty());
  EXPECT_EQ(code(R"({"SliceTiming": [0, 1]})"), ErrorCode::FileFormat);
  EXPECT_EQ(code(R"({"SliceTiming": [0, 1, "later"]})"), ErrorCode::FileFormat);
  EXPECT_EQ(code(R"({"SliceTiming": [0, 1, 0.5], "SliceEncodingDirection": "z"})"), ErrorCode::FileFormat);
  EXPECT_EQ(code(R"({"SliceTiming": [0, 1000, 500]})"), ErrorCode::InvalidArgument); // ms
  EXPECT_EQ(code(R"({"SliceTiming": [0, -1, 0.5]})"), ErrorCode::InvalidArgument);
}

TEST(TimeSeriesIO, SliceTimesComeFromAFileThatIsChosen) {
  const TemporaryFolder folder;
  GridGeometry grid;
  grid.size = {5, 4, 3};
  const auto read = [&](const char* name, const std::string& text) {
    writeBytes(folder / name, text);
    return readSliceTiming(folder / name, grid);
  };
  const SliceTiming expected{2, {0, 1, 0.5}};
  EXPECT_EQ(read("a.txt", "0\r\n1\n0.5\n"), expected);
  EXPECT_EQ(read("a.tsv", "[0, 1;\t5e-1]"), expected);
  EXPECT_EQ(read("a.json", R"({"SliceTiming": [0, 1, 0.5]})"), expected);
  EXPECT_EQ(sliceTimingFrom("0 0 1 1", "j-", 2, grid, "it"), (SliceTiming{1, {1, 1, 0, 0}}));
  for (const auto& [name, text] : {std::pair{"b.txt", "0 1"}, {"b.txt", "0 1 later"}, {"b.json", "{}"}})
    EXPECT_THROW(read(name, text), Error) << text;
  EXPECT_THROW(readSliceTiming(folder / "gone.txt", grid), Error);

  // Before what the scan says of itself, and where it says nothing.
  writeTimeSeries(ramp({0, 2, 4}), folder / "scan.nii.gz");
  writeBytes(folder / "scan.json", R"({"SliceTiming": [0, 0.2, 0.4]})");
  TimeSeriesOptions options;
  EXPECT_EQ(readTimeSeries(folder / "scan.nii.gz", options).sliceTiming, (SliceTiming{2, {0, 0.2, 0.4}}));
  options.sliceTimes = folder / "a.json";
  EXPECT_EQ(readTimeSeries(folder / "scan.nii.gz", options).sliceTiming, expected);
  writeTimeSeries(ramp({0, 2, 4}), folder / "scan.seq.nrrd");
  EXPECT_EQ(readTimeSeries(folder / "scan.seq.nrrd", options).sliceTiming, expected);
  options.sliceTimes = folder / "b.txt";
  EXPECT_EQ(errorOfReading(folder / "scan.nii.gz", options).code(), ErrorCode::FileFormat);
}

/// slice_code etc. of NIfTI-1.
TEST(TimeSeriesIO, SliceTimesComeFromTheHeader) {
  const TemporaryFolder folder;
  writeTimeSeries(ramp({0, 2, 4}), folder / "a.nii"); // 4 slices along j
  const std::string original = readBytes(folder / "a.nii");
  const auto timing = [&](int code, float duration, int first = 0, int last = 0, int axis = 2) {
    std::string bytes = original;
    const auto put = [&](std::size_t at, auto value) {
      std::memcpy(bytes.data() + at, &value, sizeof value);
    };
    put(39, static_cast<char>(axis << 4));
    put(74, static_cast<std::int16_t>(first));
    put(120, static_cast<std::int16_t>(last));
    put(122, static_cast<char>(code));
    put(132, duration);
    writeBytes(folder / "b.nii", bytes);
    return readTimeSeries(folder / "b.nii").sliceTiming;
  };
  const std::vector<double> orders[] = {{0, 1, 2, 3}, {3, 2, 1, 0}, {0, 2, 1, 3},
                                        {3, 1, 2, 0}, {2, 0, 3, 1}, {1, 3, 0, 2}}; // codes 1 to 6
  for (int code = 1; code <= 6; ++code) {
    const SliceTiming read = timing(code, 0.5F, 0, 3);
    EXPECT_EQ(read.axis, 1);
    ASSERT_EQ(read.times.size(), 4u) << code;
    for (std::size_t s = 0; s < 4; ++s)
      EXPECT_NEAR(read.times[s], 0.5 * orders[code - 1][s], 1e-9) << code;
  }
  EXPECT_EQ(timing(1, 0.25F).times, (std::vector<double>{0, 0.25, 0.5, 0.75})); // slice_end left out
  EXPECT_EQ(timing(1, 0.25F, 1, 2).times, (std::vector<double>{0, 0, 0.25, 0}));
  EXPECT_TRUE(timing(0, 0.5F).empty());
  EXPECT_TRUE(timing(1, 0).empty());
  EXPECT_TRUE(timing(7, 0.5F).empty());
  EXPECT_TRUE(timing(1, 0.5F, 0, 9).empty());
  EXPECT_TRUE(timing(1, 0.5F, 0, 3, 0).empty());
}

TEST(TimeSeriesIO, TimesOfAFileBeforeDoNotStay) {
  const TemporaryFolder folder;
  writeTimeSeries(ramp({0, 0.5, 2}), folder / "a.nii.gz");
  expectTimes(readTimeSeries(folder / "a.nii.gz").times, {0, 0.5, 2});
  writeTimeSeries(ramp({0, 1, 2}), folder / "a.nii.gz");
  expectTimes(readTimeSeries(folder / "a.nii.gz").times, {0, 1, 2});
}

TEST(TimeSeriesIO, SequencesOf3DSlicer) {
  const TemporaryFolder folder;
  const auto write = [&](bool first, const std::string& unit, const std::string& name,
                         const std::string& values) {
    const std::string none = first ? "none (1,0,0) (0,1,0) (0,0,1)" : "(1,0,0) (0,1,0) (0,0,1) none";
    std::string text = "NRRD0005\ntype: uchar\ndimension: 4\nspace: right-anterior-superior\nsizes: ";
    text += first ? "2 3 2 2" : "3 2 2 2";
    text += "\nspace directions: " + none +
            "\nkinds: " + (first ? "list domain domain domain" : "domain domain domain list");
    text += std::string("\nlabels: ") +
            (first ? "\"" + name + "\" \"\" \"\" \"\"" : "\"\" \"\" \"\" \"" + name + "\"");
    if (!unit.empty())
      text += std::string("\nunits: ") +
              (first ? "\"" + unit + "\" \"\" \"\" \"\"" : "\"\" \"\" \"\" \"" + unit + "\"");
    text += "\nencoding: raw\nspace origin: (0,0,0)\n";
    if (!values.empty())
      text += std::string("axis ") + (first ? "0" : "3") + " index values:=" + values + "\n";
    text += "\n";
    for (int v = 0; v < 24; ++v) {
      const int frame = first ? v % 2 : v / 12, voxel = first ? v / 2 : v % 12;
      text += static_cast<char>(10 * frame + voxel);
    }
    writeBytes(folder / "s.seq.nrrd", text);
    return folder / "s.seq.nrrd";
  };
  for (const bool first : {true, false}) {
    const TimeSeries series = readTimeSeries(write(first, "s", "time", "0.5 2.25"));
    expectTimes(series.times, {0.5, 2.25});
    ASSERT_EQ(series.size(), 2);
    EXPECT_EQ(series.frames[1][7], 17);
    EXPECT_EQ(series.geometry.size, (std::array<std::int64_t, 3>{3, 2, 2}));
    expectTimes(readTimeSeries(write(first, "ms", "time", "500 2250")).times, {0.5, 2.25});
    expectTimes(readTimeSeries(write(first, "", "time", "0 2")).times, {0, 2});
    EXPECT_EQ(errorOfReading(write(first, "", "frame", "0 1")).code(), ErrorCode::InvalidArgument);
    EXPECT_EQ(errorOfReading(write(first, "%", "phase", "0 10")).code(), ErrorCode::InvalidArgument);
    EXPECT_EQ(errorOfReading(write(first, "s", "time", "3 1")).code(), ErrorCode::InvalidArgument);
    EXPECT_EQ(errorOfReading(write(first, "", "", "")).code(), ErrorCode::InvalidArgument);
    expectTimes(readTimeSeries(write(first, "%", "phase", "0 10"), {{}, 0.2}).times, {0, 0.2});
  }
}

TEST(TimeSeriesIO, AFolderOfFrames) {
  const TemporaryFolder folder;
  const TimeSeries series = ramp({0, 1, 2});
  const char* names[] = {"frame2.nii.gz", "frame9.nii.gz", "frame10.nii.gz"};
  for (int f = 0; f < 3; ++f)
    writeVolume({series.geometry, series.frames[f]}, folder / names[f]);
  EXPECT_EQ(errorOfReading(folder.path()).code(), ErrorCode::InvalidArgument); // no times
  EXPECT_TRUE(frameFiles(folder.path()).empty());
  writeBytes(folder / "times.txt", "# s\n0.1\n0.4\r\n\n1.5\n");
  ASSERT_EQ(frameFiles(folder.path()).size(), 3u);
  EXPECT_EQ(frameFiles(folder.path())[2].filename(), "frame10.nii.gz");
  EXPECT_TRUE(frameFiles(folder / "times.txt").empty());
  const TimeSeries back = readTimeSeries(folder.path());
  expectTimes(back.times, {0.1, 0.4, 1.5});
  EXPECT_EQ(back.frames[0], series.frames[0]);
  EXPECT_EQ(back.frames[2], series.frames[2]); // 10 comes after 9
  writeBytes(folder / "times.txt", "0.1\n0.4\n");
  EXPECT_EQ(errorOfReading(folder.path()).code(), ErrorCode::InvalidArgument);
  writeBytes(folder / "times.txt", "0.1\n0.4\nlater\n");
  EXPECT_EQ(errorOfReading(folder.path()).code(), ErrorCode::FileFormat);
  GridGeometry other = series.geometry;
  other.origin[0] += 1;
  writeVolume({other, series.frames[0]}, folder / "frame11.nii.gz");
  EXPECT_EQ(errorOfReading(folder.path()).code(), ErrorCode::Geometry);
}

TEST(TimeSeriesIO, WhatIsNoMovingScanIsRefused) {
  const TemporaryFolder folder;
  writeVolume({ramp({0}).geometry, ramp({0}).frames[0]}, folder / "one.nii.gz");
  EXPECT_EQ(errorOfReading(folder / "one.nii.gz").code(), ErrorCode::InvalidArgument);
  writeTimeSeries(ramp({0, 1}), folder / "dwi.nii.gz");
  writeBytes(folder / "dwi.bval", "0 1000");
  EXPECT_EQ(errorOfReading(folder / "dwi.nii.gz").code(), ErrorCode::UnsupportedImage);
  EXPECT_EQ(errorOfReading(folder / "none.nii.gz").code(), ErrorCode::FileNotFound);
  TimeSeries still = ramp({0, 1, 2});
  still.frames[1] = still.frames[2] = still.frames[0];
  writeTimeSeries(still, folder / "still.nii");
  EXPECT_EQ(errorOfReading(folder / "still.nii").code(), ErrorCode::NoData);
  writeTimeSeries(ramp({0, 1, 2}), folder / "vectors.nii");
  std::string bytes = readBytes(folder / "vectors.nii");
  const auto put = [&](std::size_t at, std::int16_t value) {
    std::memcpy(bytes.data() + at, &value, sizeof value);
  };
  put(68, 1007); // NIFTI_INTENT_VECTOR
  writeBytes(folder / "vectors.nii", bytes);
  EXPECT_EQ(errorOfReading(folder / "vectors.nii").code(), ErrorCode::UnsupportedImage);
  put(68, 0);
  put(40, 5), put(48, 1), put(50, 3); // a fifth axis
  writeBytes(folder / "vectors.nii", bytes);
  EXPECT_EQ(errorOfReading(folder / "vectors.nii").code(), ErrorCode::UnsupportedImage);
  put(40, 3), put(48, 1), put(50, 1);
  put(70, 128), put(72, 24); // RGB
  writeBytes(folder / "colour.nii", bytes);
  EXPECT_EQ(errorOfReading(folder / "colour.nii").code(), ErrorCode::UnsupportedImage);
  EXPECT_THROW(checkTimeSeriesPath(folder / "a.mha"), Error);
  EXPECT_THROW(checkTimeSeriesPath(folder / "a.nrrd"), Error);
}

TEST(TimeSeriesIO, RealFilesHaveTimesInSeconds) {
  const auto data = [](const char* name) { return dataFile(name); };
  if (!std::filesystem::exists(data("G_4d_units_micron_msec.nii.gz"))) GTEST_SKIP() << "no real volumes here";
  const TimeSeries milliseconds = readTimeSeries(data("G_4d_units_micron_msec.nii.gz"));
  EXPECT_EQ(milliseconds.size(), 7);
  EXPECT_NEAR(milliseconds.times[1], 2.2, 1e-6);
  EXPECT_NEAR(milliseconds.geometry.spacing[2], 17.5, 1e-3);
  EXPECT_EQ(errorOfReading(data("G_rgb24_ct_perfusion.nii.gz")).code(), ErrorCode::UnsupportedImage);
  EXPECT_NE(remarkOnPairs(readTimeSeries(data("D_asl_multipld_64x64x24x25.nii.gz"))), "");
  EXPECT_EQ(remarkOnPairs(readTimeSeries(data("D_wrist_sim_deviation_64x64x12x38.nii.gz"))), "");
  EXPECT_EQ(remarkOnPairs(readTimeSeries(data("E_studyforrest_bold_32x32x16x156.nii.gz"))), "");
}

namespace {

DynamicField smallField(DynamicKind kind) {
  DynamicField field;
  field.kind = kind;
  field.times = {0, 0.5, 1.75};
  field.canonical.domain = ramp({0, 1}).geometry;
  for (int i = 0; i < 4; ++i) {
    Gaussian g{};
    g.mean[0] = static_cast<float>(i);
    g.quaternion[0] = 1;
    g.intensity = 0.1F * static_cast<float>(i);
    field.canonical.gaussians.push_back(g);
    field.anchors.insert(field.anchors.end(), g.mean, g.mean + 3);
  }
  if (kind == DynamicKind::Intensity) {
    field.anchors.clear();
    field.canonical.residual = {field.canonical.domain, std::vector<float>(60, 0.5F)};
    field.change = {0, 1.75, 4};
    field.changes.assign(16, 0.25F);
    return field;
  }
  if (kind == DynamicKind::Network) {
    field.network.levels = {{{2, 3, 4}, 4}, {{3, 3, 2}, 5}};
    field.network.low = {-1, -1, -1};
    field.network.high = {5, 5, 6};
    field.network.end = 1.75;
    field.network.scale.fill(0.5F);
    initialise(field.network, 3);
    return field;
  }
  field.motionGrid = motionGridOver({-1, -1, -1}, {5, 5, 5}, {3, 3, 6});
  field.motion = {0, 1.75, 5};
  field.nodes.assign(field.motionGrid.nodes() * MotionGrid::kValues * 5, 0.125F);
  field.own = {0, 1.75, 4};
  field.ownPath.assign(48, -0.5F);
  return field;
}

} // namespace

TEST(DynamicModelFile, ReadsBackAndIsNoStaticModel) {
  const TemporaryFolder folder;
  for (const DynamicKind kind : {DynamicKind::Motion, DynamicKind::Intensity, DynamicKind::Network}) {
    const DynamicField field = smallField(kind);
    writeDynamicModel(field, folder / "a.innergs", {{"Inputs", "b.nii"}});
    EXPECT_TRUE(isDynamicModel(folder / "a.innergs"));
    ModelNotes notes;
    const DynamicField back = readDynamicModel(folder / "a.innergs", &notes);
    EXPECT_EQ(notes.at("Inputs"), "b.nii");
    EXPECT_EQ(back.kind, field.kind);
    EXPECT_EQ(back.times, field.times);
    EXPECT_EQ(back.motionGrid.size, field.motionGrid.size);
    EXPECT_EQ(back.motionGrid.origin, field.motionGrid.origin);
    EXPECT_EQ(back.motion, field.motion);
    EXPECT_EQ(back.own, field.own);
    EXPECT_EQ(back.change, field.change);
    EXPECT_EQ(back.nodes, field.nodes);
    EXPECT_EQ(back.anchors, field.anchors);
    EXPECT_EQ(back.ownPath, field.ownPath);
    EXPECT_EQ(back.changes, field.changes);
    EXPECT_EQ(back.network.levels, field.network.levels);
    EXPECT_EQ(back.network.low, field.network.low);
    EXPECT_EQ(back.network.high, field.network.high);
    EXPECT_EQ(back.network.start, field.network.start);
    EXPECT_EQ(back.network.end, field.network.end);
    EXPECT_EQ(back.network.parameters, field.network.parameters);
    if (kind == DynamicKind::Network) {
      EXPECT_EQ(back.network.scale, field.network.scale);
    }
    EXPECT_EQ(back.canonical.residual.voxels, field.canonical.residual.voxels);
    RefinementState none, state{40, 0.125, "rounds=9; input=ab", {40, 0}, {1, 2, 3.5F, -4}};
    readDynamicModel(folder / "a.innergs", nullptr, &none);
    EXPECT_TRUE(none.empty());
    writeDynamicModel(field, folder / "a.innergs", {}, state);
    RefinementState read;
    EXPECT_EQ(readDynamicModel(folder / "a.innergs", nullptr, &read).kind, field.kind);
    EXPECT_EQ(read.step, state.step);
    EXPECT_EQ(read.mse, state.mse);
    EXPECT_EQ(read.key, state.key);
    EXPECT_EQ(read.steps, state.steps);
    EXPECT_EQ(read.moments, state.moments);
    EXPECT_EQ(errorOf([&] { readModel(folder / "a.innergs"); }).code(), ErrorCode::UnsupportedImage);
  }
  Model still;
  still.field = smallField(DynamicKind::Motion).canonical;
  still.finished = still.field.size();
  writeModel(still, folder / "b.innergs");
  EXPECT_FALSE(isDynamicModel(folder / "b.innergs"));
  EXPECT_EQ(errorOf([&] { readDynamicModel(folder / "b.innergs"); }).code(), ErrorCode::FileFormat);
  EXPECT_FALSE(isDynamicModel(folder / "none.innergs"));
}

TEST(DynamicModelFile, DamagedOnesAreRefused) {
  const TemporaryFolder folder;
  const auto bytesOf = [&](DynamicKind kind) {
    writeDynamicModel(smallField(kind), folder / "a.innergs");
    return readBytes(folder / "a.innergs");
  };
  std::string bytes = bytesOf(DynamicKind::Motion);
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string changed = bytes;
    const std::size_t at = changed.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    ASSERT_EQ(from.size(), to.size());
    changed.replace(at, from.size(), to);
    writeBytes(folder / "b.innergs", changed);
    EXPECT_EQ(errorOf([&] { readDynamicModel(folder / "b.innergs"); }).code(), ErrorCode::FileFormat) << to;
  };
  replaced("coefficients\\\":5", "coefficients\\\":6");
  replaced("coefficients\\\":5", "coefficients\\\":2");
  replaced("\"moving\":\"motion\"", "\"moving\":\"notion\"");
  replaced("[0.0,0.5,1.75]", "[0.0,1.5,1.25]");
  replaced("\"anchor\"", "\"amchor\"");
  const std::string motion = std::exchange(bytes, bytesOf(DynamicKind::Network));
  replaced("times\\\":4", "times\\\":5");
  replaced("times\\\":4", "times\\\":3");
  replaced("channels\\\":16", "channels\\\":32");
  replaced("\"deformation\"", "\"deformatiom\"");
  bytes = motion;
  writeBytes(folder / "b.innergs", std::string_view(bytes).substr(0, bytes.size() - 8));
  EXPECT_EQ(errorOf([&] { readDynamicModel(folder / "b.innergs"); }).code(), ErrorCode::FileFormat);
}
