#include "IO/SegmentNames.h"
#include "IO/VolumeIO.h"
#include "TestFiles.h"

#include <algorithm>

namespace innergs::test {
namespace {

std::string textOf(std::vector<SegmentName> names) {
  std::sort(names.begin(), names.end(), [](const auto& a, const auto& b) { return a.label < b.label; });
  std::string text;
  for (const SegmentName& name : names)
    text += std::to_string(name.label) + "=" + name.name + ";";
  return text;
}

TEST(SegmentNames, JsonEitherWayRound) {
  const TemporaryFolder folder;
  writeBytes(folder / "a.json", R"({"0": "background", "1": "liver", "12": "left kidney"})");
  EXPECT_EQ(textOf(readSegmentNames(folder / "a.json")), "1=liver;12=left kidney;");
  writeBytes(folder / "b.json", R"({"liver": 1, "spleen": 2})");
  EXPECT_EQ(textOf(readSegmentNames(folder / "b.json")), "1=liver;2=spleen;");
  for (const char* bad : {"", "{}", "[1]", R"({"x": "liver"})", R"({"1": 2.5})", R"({"70000": "liver"})"}) {
    writeBytes(folder / "c.json", bad);
    EXPECT_EQ(errorOf([&] { readSegmentNames(folder / "c.json"); }).code(), ErrorCode::FileFormat) << bad;
  }
}

TEST(SegmentNames, ASegmentationKeepsItsNamesAndCodes) {
  const TemporaryFolder folder;
  Volume labels;
  labels.geometry.size = {4, 5, 6};
  labels.voxels.assign(120, 2.f);
  labels.voxels[0] = 1;
  std::vector<SegmentInfo> segments(2);
  segments[0] = {{1, "liver"}, "", {0.1, 0.25, 1}};
  segments[1] = {{2, "kidney_left"}, "context~SCT^64033007^Kidney", {}};
  writeVolume(labels, folder / "a.seg.nrrd", OutputType::UInt8, {}, segmentFields(segments, labels.geometry));
  EXPECT_EQ(textOf(readSegmentNames(folder / "a.seg.nrrd")), "1=liver;2=kidney_left;");
  const std::string bytes = readBytes(folder / "a.seg.nrrd");
  for (const char* field : {"Segment0_Color:=0.1 0.25 1", "Segment1_Extent:=0 3 0 4 0 5",
                            "Segment1_Tags:=TerminologyEntry:context~SCT^64033007^Kidney|"})
    EXPECT_NE(bytes.find(field), std::string::npos) << field;
  EXPECT_EQ(readVolume(folder / "a.seg.nrrd").voxels, labels.voxels);
}

TEST(SegmentNames, AnotherImageHasNone) {
  const TemporaryFolder folder;
  Volume labels;
  labels.geometry.size = {4, 5, 6};
  labels.voxels.assign(120, 1.f);
  writeVolume(labels, folder / "a.nrrd");
  EXPECT_TRUE(readSegmentNames(folder / "a.nrrd").empty());
  writeVolume(labels, folder / "a.nii");
  EXPECT_TRUE(readSegmentNames(folder / "a.nii").empty());
  EXPECT_EQ(errorOf([&] { readSegmentNames(folder / "none.json"); }).code(), ErrorCode::FileNotFound);
}

} // namespace
} // namespace innergs::test
