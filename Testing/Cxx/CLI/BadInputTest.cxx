#include "CommandRunner.h"
#include "SyntheticImages.h"

#include "IO/VolumeIO.h"

namespace innergs::test {
namespace {

class BadInputTest : public CommandTest {
protected:
  // Reconstruction fails with one sentence and leaves no files.
  void expectRefused(const std::vector<std::string>& inputs, const std::string& mention = "") {
    std::vector<std::string> arguments{"reconstruct"};
    arguments.insert(arguments.end(), inputs.begin(), inputs.end());
    for (const auto& word : {"-o", "out/v.nii.gz", "--save-model", "out/m.innergs", "--report", "out/r.json"})
      arguments.push_back(word[0] == '-' ? word : path(word));
    SCOPED_TRACE(inputs.front());
    expectOneSentence(run(quickly(arguments)), 1, mention);
    EXPECT_EQ(filesIn("out"), std::vector<std::string>{});
  }
  std::string scan(const std::string& name, const Volume& volume = phantom()) {
    writeVolume(volume, path(name));
    return path(name);
  }
  std::string file(const std::string& name, const std::string& bytes) {
    write(name, bytes);
    return path(name);
  }
};

TEST_F(BadInputTest, FilesThatAreNotImages) {
  expectRefused({path("missing.nii.gz")}, "missing.nii.gz");
  expectRefused({file("empty.nii", "")}, "empty.nii");
  expectRefused({file("text.nii", "this is not an image, whatever its name says\n")}, "text.nii");
  expectRefused({file("text.txt", "neither is this\n")}, "text.txt");
  std::filesystem::create_directory(folder_ / "nothing");
  expectRefused({path("nothing")}, "nothing");
  const std::string whole = scan("whole.nii");
  expectRefused({file("cut.nii", contents("whole.nii").substr(0, 5000))}, "cut.nii");
  expectRefused({file("header.mha", MetaImage{}.bytes().substr(0, 60))}, "header.mha");
}

TEST_F(BadInputTest, PixelsThatAreNotScalars) {
  MetaImage rgb;
  rgb.type = "MET_UCHAR";
  rgb.channels = 3;
  expectRefused({file("rgb.mha", rgb.bytes())}, "rgb.mha");
  expectRefused({file("rgb.nii", niftiBytes({8, 8, 8}, 128, 24))}, "rgb.nii");
  expectRefused({file("complex.nii", niftiBytes({8, 8, 8}, 32, 64))}, "complex.nii");
}

TEST_F(BadInputTest, SingleSlice) {
  MetaImage flat;
  flat.size = {12, 12, 1};
  expectRefused({file("flat.mha", flat.bytes())}, "slice");
  flat.size = {12, 12};
  flat.matrix = "1 0 0 1";
  flat.offset = "0 0";
  flat.spacing = "1 1";
  expectRefused({file("flat2.mha", flat.bytes())}, "slice");
  expectRefused({scan("whole.nii"), path("flat.mha")}, "flat.mha' has a single slice");
}

TEST_F(BadInputTest, ScanWithoutContentAmongOthers) {
  Volume blank = phantom();
  for (auto& voxel : blank.voxels)
    voxel = 0;
  const std::string image = scan("image.nii"), zeros = scan("zeros.nii", blank);
  expectRefused({image, zeros}, "zeros.nii shows nothing: all its voxels are 0.");
  expectRefused({zeros, image, "--no-align"}, "zeros.nii shows nothing");
  Volume air = blank; // a slab of the same acquisition beyond the body
  air.geometry.origin[2] += static_cast<double>(air.geometry.size[2]) * air.geometry.spacing[2];
  expectSuccess(run(quickly({"reconstruct", image, scan("air.nii", air), "-o", path("slabs.nii")})));
}

TEST_F(BadInputTest, FourDimensionsNameTheOption) {
  const std::string movie = file("movie.nii", niftiBytes({8, 8, 8, 3}, 16, 32));
  expectRefused({movie}, "choose a frame (0 to 2)");
  expectRefused({movie, "--frame", "3"}, "3");
}

TEST_F(BadInputTest, Geometry) {
  MetaImage image;
  image.spacing = "0 1 1";
  expectRefused({file("zero.mha", image.bytes())}, "spacing");
  image = {};
  image.matrix = "1 0 0 1 0 0 0 0 1";
  expectRefused({file("singular.mha", image.bytes())}, "singular.mha");
  image.matrix = "1 0 0 0.5 0.8660254 0 0 0 1";
  expectRefused({file("sheared.mha", image.bytes())}, "sheared.mha");
}

TEST_F(BadInputTest, NoFiniteVoxel) {
  MetaImage image;
  image.values = {std::nanf(""), INFINITY};
  expectRefused({file("nan.mha", image.bytes())}, "finite");
}

TEST_F(BadInputTest, StacksThatDoNotOverlap) {
  Volume far = phantom();
  far.geometry.origin[0] += 500;
  expectRefused({scan("near.nii"), scan("far.nii", far)}, "overlap");
}

TEST_F(BadInputTest, MaskEmptyOrElsewhere) {
  Volume mask = phantom();
  const std::string image = scan("image.nii");
  for (auto& voxel : mask.voxels)
    voxel = 0;
  expectRefused({image, "--mask", scan("empty-mask.nii", mask)}, "mask");
  for (auto& voxel : mask.voxels)
    voxel = 1;
  mask.geometry.origin[1] += 500;
  expectRefused({image, "--mask", scan("far-mask.nii", mask)}, "mask");
  expectRefused({image, "--mask", path("no-mask.nii")}, "no-mask.nii");
  const std::string whole = scan("whole-mask.nii"), other = scan("other.nii");
  expectRefused({image, "--mask", whole, whole}, "2 masks for 1 scan:");
  expectRefused({image, other, "--mask", whole, whole, whole}, "3 masks for 2 scans:");
  expectRefused({image, other, "--mask", whole, path("far-mask.nii")}, "The mask of other.nii");
}

TEST_F(BadInputTest, RegionOutsideOrInverted) {
  const std::string image = scan("image.nii");
  expectRefused({image, "--roi", "500,510,0,10,0,10"}, "region");
  expectRefused({image, "--roi", "10,0,0,10,0,10"}, "region");
}

TEST_F(BadInputTest, SettingsOutOfRange) {
  const std::string image = scan("image.nii");
  expectRefused({image, "--spacing", "0"}, "spacing");
  expectRefused({image, "--spacing", "-1"}, "spacing");
  expectRefused({image, "--thickness", "-2"}, "thickness");
  expectRefused({image, "--thickness", "2,3"}, "thickness");
  expectRefused({image, "--ssim-weight", "-1"});
  expectRefused({image, "--instruction-set", "abacus"}, "abacus");
}

TEST_F(BadInputTest, MoreMemoryThanThereIs) {
  const std::string image = scan("image.nii");
  expectRefused({image, "--spacing", "0.0003"}, "memory");
}

TEST_F(BadInputTest, OutputsAreCheckedBeforeTheWork) {
  const std::string image = scan("image.nii");
  const auto refused = [&](std::vector<std::string> outputs, const std::string& mention) {
    std::vector<std::string> arguments{"reconstruct", image};
    arguments.insert(arguments.end(), outputs.begin(), outputs.end());
    const Outcome outcome = run(arguments); // a full fit would take far longer than the test allows
    expectOneSentence(outcome, 1, mention);
    EXPECT_EQ(filesIn("out"), std::vector<std::string>{});
  };
  refused({"-o", path("absent/v.nii.gz")}, "absent");
  refused({"-o", path("out/v.docx")}, "docx");
  refused({"-o", path("out/v")}, "out");
  refused({"-o", path("out/v.nii"), "--save-model", path("absent/m.innergs")}, "absent");
  refused({"-o", path("out/v.nii"), "--ply", path("absent/m.ply")}, "absent");
  refused({"-o", path("out/v.nii"), "--report", path("absent/r.json")}, "absent");
}

#ifndef _WIN32
// A file-size limit makes writes fail midway, like a full disk, without needing one.
TEST_F(BadInputTest, FullDiskLeavesNoHalfFile) {
  const std::string image = scan("image.nii", phantom({48, 48, 48}));
  const auto expectFull = [&](const std::string& name) {
    const Outcome outcome = run(quickly({"reconstruct", image, "-q", "-o", path("out/" + name)}),
                                "trap '' XFSZ; ulimit -f 64; exec ");
    EXPECT_EQ(outcome.exitCode, 1) << outcome.err;
    // The format's library may print messages first; the last line is ours.
    const std::string last = outcome.err.substr(outcome.err.rfind('\n', outcome.err.size() - 2) + 1);
    EXPECT_EQ(last.substr(0, 9), "innergs: ") << outcome.err;
    EXPECT_NE(last.find(name), std::string::npos) << outcome.err;
  };
  for (const char* name : {"v.nii", "v.nii.gz", "v.mha", "v.nrrd"})
    expectFull(name);
  EXPECT_EQ(filesIn("out"), std::vector<std::string>{});

  write("out/kept.nii", "what was there before");
  expectFull("kept.nii");
  EXPECT_EQ(contents("out/kept.nii"), "what was there before");
  EXPECT_EQ(filesIn("out").size(), 1u);
}
#endif

TEST_F(BadInputTest, ModelsTruncatedOrForged) {
  const std::string image = scan("image.nii");
  expectSuccess(run(quickly({"reconstruct", image, "-q", "--save-model", path("good.innergs")})));
  const std::string good = contents("good.innergs");
  ASSERT_GT(good.size(), 1000u);
  std::string forged = good;
  forged[3] = '\x7f'; // a header of gigabytes
  const std::vector<std::string> models{file("empty.innergs", ""),
                                        file("stub.innergs", good.substr(0, 5)),
                                        file("half.innergs", good.substr(0, good.size() / 2)),
                                        file("cut.innergs", good.substr(0, good.size() - 1)),
                                        file("forged.innergs", forged),
                                        file("text.innergs", "not a model at all, just some text"),
                                        path("missing.innergs")};
  for (const auto& model : models) {
    SCOPED_TRACE(model);
    expectOneSentence(run({"slice", model, "--plane", "axial", "-o", path("out/s.nii")}), 1);
    expectOneSentence(run({"resample", model, "-o", path("out/v.nii")}), 1);
    expectOneSentence(run({"info", model}), 1);
    expectRefused({image, "--resume", model});
  }
  EXPECT_EQ(filesIn("out"), std::vector<std::string>{});
}

// Real files of the same kinds.
TEST_F(BadInputTest, RealFiles) {
  const std::filesystem::path data = INNERGS_TEST_DATA;
  if (!std::filesystem::exists(data / "G_shear_sform.nii.gz")) GTEST_SKIP() << "no test volumes in " << data;
  expectRefused({(data / "G_shear_sform.nii.gz").string()}, "G_shear_sform");
  expectRefused({(data / "G_rgb24_ct_perfusion.nii.gz").string()}, "G_rgb24");
  expectRefused({(data / "G_single_slice.nii.gz").string()}, "slice");
  expectRefused({(data / "G_oblique_4d_TR2000.nii.gz").string()}, "choose a frame");
  expectRefused({(data / "G_minc2_4d.mnc").string()}, "choose a frame");
  expectRefused({(data / "C_labels117_names.json").string()}, "C_labels117_names");
}

} // namespace
} // namespace innergs::test
