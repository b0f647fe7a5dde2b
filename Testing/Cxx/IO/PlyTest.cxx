#include "IO/Ply.h"
#include "IO/ModelFile.h"

#include "TestFiles.h"

#include "TestFields.h"

namespace innergs::test {
namespace {

TEST(Ply, RoundTripIsExact) {
  const TemporaryFolder folder;
  for (const bool linearIntensity : {false, true})
    for (const Blending blending : {Blending::Normalised, Blending::Additive, Blending::Alpha}) {
      if (linearIntensity && blending == Blending::Alpha) continue;
      GaussianField field = randomField(41, linearIntensity);
      field.blending = blending;
      field.gaussians[0].logWeight = 12; // beyond the range of an opacity
      writePly(field, folder / "a.ply");
      const GaussianField read = readPly(folder / "a.ply");
      expectSameFrame(read, field);
      EXPECT_TRUE(sameBits(read.gaussians, field.gaussians));
    }
  EXPECT_EQ(folder.fileCount(), 1);
}

TEST(Ply, IsAModelWhoseFitIsOver) {
  const TemporaryFolder folder;
  const GaussianField field = randomField(41, true);
  writePly(field, folder / "a.PLY");
  ModelNotes notes{{"Version", "of an earlier file"}};
  const Model model = readModel(folder / "a.PLY", &notes);
  EXPECT_TRUE(sameBits(model.field.gaussians, field.gaussians));
  EXPECT_EQ(model.finished, 41);
  EXPECT_EQ(model.iteration, 0);
  EXPECT_TRUE(model.complete() && notes.empty());
  std::filesystem::copy_file(folder / "a.PLY", folder / "renamed");
  EXPECT_TRUE(isPly(folder / "renamed"));
  EXPECT_EQ(readModel(folder / "renamed").finished, 41);
}

/// The vertex properties of a file as floats, by position.
std::vector<float> vertexFloats(const std::string& bytes, std::size_t properties, std::size_t vertex) {
  const std::size_t start = bytes.find("end_header\n") + 11;
  std::vector<float> values(properties);
  std::memcpy(values.data(), bytes.data() + start + vertex * properties * 4, properties * 4);
  return values;
}

Mat3 covarianceOf(const double* q, const float* logScale) {
  const double n = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const double w = q[0] / n, x = q[1] / n, y = q[2] / n, z = q[3] / n;
  const Mat3 r{{{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                 {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                 {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}}};
  return r *
         diagonal({std::exp(2.0 * logScale[0]), std::exp(2.0 * logScale[1]), std::exp(2.0 * logScale[2])}) *
         transpose(r);
}

TEST(Ply, SaysInNumbersWhatItLeavesOut) {
  GaussianField field = randomField(1234, true);
  EXPECT_EQ(droppedByPly(field), "");
  field.residual = {{{2, 3, 4}, {0, 0, 0}, {1, 1, 1}, {}}, std::vector<float>(24, 0.25f)};
  field.residual.voxels[5] = -0.25f;
  field.intensityScale = -10;
  const std::string sentence = droppedByPly(field);
  for (const char* part : {"1,234 Gaussians", "2x3x4 values", "RMS 2.5 "})
    EXPECT_NE(sentence.find(part), std::string::npos) << sentence;
  field.support = {field.residual.geometry, std::vector<std::uint8_t>(24, 1)};
  EXPECT_NE(droppedByPly(field).find("mask of 24 voxels"), std::string::npos);
  field.residual = {};
  EXPECT_EQ(droppedByPly(field).find("detail"), std::string::npos) << droppedByPly(field);
}

TEST(Ply, KeepsTheValueRange) {
  const TemporaryFolder folder;
  GaussianField field = randomField(5, true);
  writePly(field, folder / "a.ply");
  EXPECT_FALSE(readPly(folder / "a.ply").range);
  field.range = {-1000.0f / 7, 3.25f};
  writePly(field, folder / "a.ply");
  EXPECT_EQ(readPly(folder / "a.ply").range->low, field.range->low);
  EXPECT_EQ(readPly(folder / "a.ply").range->high, field.range->high);
}

// Other programs get the Gaussians in patient space.
TEST(Ply, NamesOf3dgsHoldPatientSpace) {
  const TemporaryFolder folder;
  for (const double angle : {0.0, 0.7, 2.0, 3.1, -2.5}) {
    GaussianField field = randomField(5, true);
    field.modelToWorld = tiltedFrame(angle);
    writePly(field, folder / "a.ply");
    const std::string bytes = readBytes(folder / "a.ply");
    EXPECT_NE(bytes.find("property float x\nproperty float y\nproperty float z\nproperty float nx"),
              std::string::npos);
    for (std::size_t n = 0; n < 5; ++n) {
      const Gaussian& g = field.gaussians[n];
      const std::vector<float> v = vertexFloats(bytes, 29, n);
      const Vec3 world = field.modelToWorld({g.mean[0], g.mean[1], g.mean[2]});
      for (int axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(v[static_cast<std::size_t>(axis)], world[axis], 1e-3);
      EXPECT_NEAR(0.5 + 0.28209479177387814 * v[6], g.intensity, 1e-6);
      EXPECT_NEAR(1 / (1 + std::exp(-double(v[9]))), std::min(std::exp(double(g.logWeight)), 1 - 1e-6), 1e-5);
      const double inWorld[4] = {v[13], v[14], v[15], v[16]};
      const double inModel[4] = {g.quaternion[0], g.quaternion[1], g.quaternion[2], g.quaternion[3]};
      const Mat3 &turn = field.modelToWorld.linear, a = covarianceOf(inWorld, v.data() + 10),
                 b = turn * covarianceOf(inModel, g.logScale) * transpose(turn);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          EXPECT_NEAR(a[i][j], b[i][j], 1e-4);
    }
  }
}

std::string plainHeader(int vertices, const std::string& format = "binary_little_endian",
                        const std::string& more = "") {
  std::string header = "ply\nformat " + format + " 1.0\nelement vertex " + std::to_string(vertices) + "\n";
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"})
    header += "property float " + std::string(name) + "\n";
  for (int n = 0; n < 45; ++n)
    header += "property float f_rest_" + std::to_string(n) + "\n";
  for (const char* name : {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
    header += "property float " + std::string(name) + "\n";
  return header + more + "end_header\n";
}

std::string plainVertex(float at) {
  std::vector<float> v{at, 2, 3, 0, 0, 0, 1, 0.5f, 0};
  v.insert(v.end(), 45, 99.f);
  for (const float x : {1.5f, -1.f, -2.f, -3.f, 1.f, 0.f, 0.f, 0.f})
    v.push_back(x);
  return rawBytes(v);
}

TEST(Ply, PlainSplats) {
  const TemporaryFolder folder;
  writeBytes(folder / "a.ply", plainHeader(2) + plainVertex(1) + plainVertex(11));
  const GaussianField field = readPly(folder / "a.ply");
  ASSERT_EQ(field.size(), 2);
  const Gaussian& g = field.gaussians[0];
  EXPECT_EQ(g.mean[0], 1);
  EXPECT_EQ(g.mean[2], 3);
  EXPECT_EQ(g.logScale[2], -3);
  EXPECT_EQ(g.quaternion[0], 1);
  EXPECT_NEAR(std::exp(g.logWeight), 1 / (1 + std::exp(-1.5)), 1e-6);
  EXPECT_NEAR(g.intensity, 0.5 + 0.28209479177387814 * 0.5, 1e-6);
  EXPECT_FALSE(field.linearIntensity);
  EXPECT_EQ(field.modelToWorld, Affine3{});
  EXPECT_EQ(field.domain.size, (std::array<std::int64_t, 3>{256, 1, 1}));
  EXPECT_EQ(field.domain.origin, (Vec3{1, 2, 3}));
}

TEST(Ply, ElementsAfterTheVerticesAreIgnored) {
  const TemporaryFolder folder;
  const std::string more = "element face 1\nproperty list uchar int vertex_indices\n";
  writeBytes(folder / "a.ply",
             plainHeader(1, "binary_little_endian", more) + plainVertex(1) + std::string(13, '\3'));
  EXPECT_EQ(readPly(folder / "a.ply").size(), 1);
}

TEST(Ply, Refused) {
  const TemporaryFolder folder;
  EXPECT_EQ(errorOf([&] { readPly(folder / "missing.ply"); }).code(), ErrorCode::FileNotFound);
  const auto refused = [&](const std::string& bytes) {
    writeBytes(folder / "a.ply", bytes);
    Error error = errorOf([&] { readPly(folder / "a.ply"); });
    EXPECT_EQ(error.code(), ErrorCode::FileFormat);
    return error;
  };
  const std::string vertex = plainVertex(1);
  refused("");
  refused("text\n");
  EXPECT_TRUE(contains(refused(plainHeader(1, "ascii") + "1 2 3\n"), "ASCII"));
  EXPECT_TRUE(contains(refused(plainHeader(1, "binary_big_endian") + vertex), "big-endian"));
  refused(plainHeader(2) + vertex);
  refused(plainHeader(-1) + vertex);
  refused(plainHeader(2000000000) + vertex);
  std::string header = plainHeader(1);
  header.replace(header.find("vertex 1\n"), 9, "vertex 99999999999999999999\n");
  refused(header + vertex);
  header = plainHeader(1);
  header.replace(header.find("float opacity"), 13, "list uchar float opacity");
  EXPECT_TRUE(contains(refused(header + vertex), "list"));
  header = plainHeader(1);
  header.replace(header.find("opacity"), 7, "opazity");
  EXPECT_TRUE(contains(refused(header + vertex), "opacity"));
  header = plainHeader(1);
  header.replace(header.find("scale_1"), 7, "scale_0");
  refused(header + vertex);
  header = plainHeader(1);
  header.erase(header.find("end_header"));
  refused(header + vertex);
  refused("ply\nformat binary_little_endian 1.0\nelement vertex 5\nend_header\n");
  refused("ply\nformat binary_little_endian 1.0\nelement face 1\nproperty float x\nelement vertex "
          "1\nproperty float x\n"
          "end_header\n" +
          vertex);
  refused("ply\n" + std::string(100000, 'x'));
  refused("ply\ncomment " + std::string(100000, '\n'));
  std::string nan = vertex;
  const float value = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(nan.data(), &value, 4);
  refused(plainHeader(1) + nan);
}

TEST(Ply, ForgedOrTruncatedOwnFiles) {
  const TemporaryFolder folder;
  writePly(randomField(3, true), folder / "a.ply");
  const std::string bytes = readBytes(folder / "a.ply");
  const auto codeOf = [&](const std::string& forged) {
    writeBytes(folder / "b.ply", forged);
    return errorOf([&] { readPly(folder / "b.ply"); }).code();
  };
  for (std::size_t length = 0; length < bytes.size(); length += 17)
    ASSERT_EQ(codeOf(bytes.substr(0, length)), ErrorCode::FileFormat) << length;
  const std::pair<const char*, const char*> forgeries[] = {{"blending normalised", "blending alpha"},
                                                           {"innergs epsilon", "innergs epsilom"},
                                                           {"cutoff 2.75", "cutoff two"},
                                                           {"cutoff 2.75", "cutoff inf"},
                                                           {"domain_size 30 40 50", "domain_size 30 40"},
                                                           {"domain_size 30 40 50", "domain_size 30 -4 50"},
                                                           {"domain_spacing 0.", "domain_spacing -0."},
                                                           {"format_version 1", "format_version 2"},
                                                           {"innergs_intensity", "innergs_intensitx"}};
  for (const auto& [from, to] : forgeries) {
    std::string forged = bytes;
    const std::size_t at = forged.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    forged.replace(at, std::string(from).size(), to);
    EXPECT_EQ(codeOf(forged), ErrorCode::FileFormat) << to;
  }
  std::mt19937 random(99);
  const std::size_t header = bytes.find("end_header") + 11;
  for (int n = 0; n < 500; ++n) {
    std::string forged = bytes;
    for (unsigned flips = 1 + random() % 4; flips > 0; --flips)
      forged[random() % header] ^= static_cast<char>(1 << random() % 8);
    writeBytes(folder / "b.ply", forged);
    try {
      readPly(folder / "b.ply");
    } catch (const Error& error) {
      EXPECT_TRUE(error.code() == ErrorCode::FileFormat || error.code() == ErrorCode::Memory) << error.what();
    }
  }
}

} // namespace
} // namespace innergs::test
