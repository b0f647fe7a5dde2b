#include "IO/ModelFile.h"

#include "TestFiles.h"

#include "TestFields.h"

namespace innergs::test {
namespace {

Model modelOf(int count, bool linearIntensity, bool resumable) {
  Model model;
  model.field = randomField(count, linearIntensity);
  model.iteration = 137;
  model.settingsKey = "preset=balanced \"quoted\" {1,2} \xC3\xA4";
  if (resumable) {
    for (int n = 0; n < 16 * count; ++n) {
      model.optimizer.moment1.push_back(0.001f * static_cast<float>(n) / 3);
      model.optimizer.moment2.push_back(1e-9f * static_cast<float>(n * n));
    }
    for (int n = 0; n < model.iteration; ++n)
      model.optimizer.losses.push_back(1 / (1 + static_cast<float>(n)));
    for (int n = 0; n < count; ++n)
      model.optimizer.gradients.push_back(0.3f * static_cast<float>(n));
  }
  return model;
}

void expectSame(const Model& read, const Model& written) {
  expectSameFrame(read.field, written.field);
  EXPECT_TRUE(sameBits(read.field.gaussians, written.field.gaussians));
  EXPECT_EQ(read.optimizer.moment1, written.optimizer.moment1);
  EXPECT_EQ(read.optimizer.moment2, written.optimizer.moment2);
  EXPECT_EQ(read.optimizer.losses, written.optimizer.losses);
  EXPECT_EQ(read.optimizer.gradients, written.optimizer.gradients);
  EXPECT_EQ(read.iteration, written.iteration);
  EXPECT_EQ(read.settingsKey, written.settingsKey);
}

TEST(ModelFile, RoundTripIsExact) {
  const TemporaryFolder folder;
  for (const bool linearIntensity : {false, true})
    for (const bool resumable : {false, true})
      for (const Blending blending : {Blending::Normalised, Blending::Additive, Blending::Alpha}) {
        if (linearIntensity && blending == Blending::Alpha) continue;
        Model model = modelOf(57, linearIntensity, resumable);
        model.field.blending = blending;
        writeModel(model, folder / "a.innergs");
        expectSame(readModel(folder / "a.innergs"), model);
      }
  EXPECT_EQ(folder.fileCount(), 1);
}

TEST(ModelFile, NotesAreKeptAndOptional) {
  const TemporaryFolder folder;
  const Model model = modelOf(5, false, false);
  const ModelNotes written{
      {"Settings", "preset=fast; seed=1"}, {"Inputs", "Kopf \xC3\xA4 \"1\""}, {"Empty", ""}};
  writeModel(model, folder / "a.innergs", written);
  ModelNotes read{{"Stale", "x"}};
  expectSame(readModel(folder / "a.innergs", &read), model);
  EXPECT_EQ(read, written);
  writeModel(model, folder / "b.innergs"); // as earlier versions wrote them
  readModel(folder / "b.innergs", &read);
  EXPECT_TRUE(read.empty());
  writeModel(model, folder / "c.innergs", {{"Inputs", "broken \xFF bytes"}});
  readModel(folder / "c.innergs", &read);
  EXPECT_NE(read["Inputs"].find("broken"), std::string::npos);
}

TEST(ModelFile, UnknownTensorsAndKeysAreIgnored) {
  const TemporaryFolder folder;
  const Model model = modelOf(5, true, false);
  writeModel(model, folder / "a.innergs");
  std::string bytes = readBytes(folder / "a.innergs");
  std::uint64_t length;
  std::memcpy(&length, bytes.data(), 8);
  const std::uint64_t data = bytes.size() - 8 - length;
  std::string header = bytes.substr(8, length);
  header.erase(header.find_last_of('}'));
  header += ",\"latent\":{\"dtype\":\"F16\",\"shape\":[3,2],\"data_offsets\":[" + std::to_string(data) + "," +
            std::to_string(data + 12) + "]}}";
  header.insert(header.find("\"format\""), "\"colour\":\"blue\",");
  const std::uint64_t longer = header.size();
  std::string extended(8, '\0');
  std::memcpy(extended.data(), &longer, 8);
  writeBytes(folder / "b.innergs", extended + header + bytes.substr(8 + length) + std::string(12, '\7'));
  expectSame(readModel(folder / "b.innergs"), model);
}

/// The file with one piece of its header replaced, possibly by one of another length.
std::string withHeader(const std::string& bytes, const std::string& from, const std::string& to) {
  std::uint64_t length;
  std::memcpy(&length, bytes.data(), 8);
  std::string header = bytes.substr(8, length);
  const std::size_t at = header.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  if (at == std::string::npos) return bytes;
  header.replace(at, from.size(), to);
  length = header.size();
  std::string result(8, '\0');
  std::memcpy(result.data(), &length, 8);
  std::uint64_t before;
  std::memcpy(&before, bytes.data(), 8);
  return result + header + bytes.substr(8 + before);
}

TEST(ModelFile, ForgedHeaders) {
  const TemporaryFolder folder;
  writeModel(modelOf(5, true, true), folder / "a.innergs");
  const std::string bytes = readBytes(folder / "a.innergs");
  const std::pair<const char*, const char*> forgeries[] = {
      {"\"format\":\"InnerGS\"", "\"format\":\"Other\""},
      {"\"format_version\":\"1\"", "\"format_version\":\"one\""},
      {"\"blending\":\"normalised\"", "\"blending\":\"alpha\""},
      {"\"blending\"", "\"blendung\""},
      {"\"cutoff\":\"2.75\"", "\"cutoff\":\"nan\""},
      {"\"cutoff\":\"2.75\"", "\"cutoff\":2.75"},
      {"\"cutoff\":\"2.75\"", "\"cutoff\":\"1e999\""},
      {"\"iteration\":\"137\"", "\"iteration\":\"-1\""},
      {"\"iteration\":\"137\"", "\"iteration\":\"99999999999999\""},
      {"[30,40,50]", "[30,40]"},
      {"[30,40,50]", "[30,-40,50]"},
      {"[30,40,50]", "[30,40.5,50]"},
      {"[30,40,50]", "[1000000000,1000000000,1000000000]"},
      {"\\\"spacing\\\":[0.7,", "\\\"spacing\\\":[0,"},
      {"\\\"spacing\\\":[0.7,", "\\\"spacing\\\":[null,"},
      {"\"mean\":{\"data_offsets\":[0,60],\"dtype\":\"F32\",\"shape\":[5,3]}",
       "\"mean\":{\"data_offsets\":[0,60],\"dtype\":\"I32\",\"shape\":[5,3]}"},
      {"\"shape\":[5,3]", "\"shape\":[3,5]"},
      {"\"shape\":[5,3]", "\"shape\":[-5,-3]"},
      {"\"shape\":[5,3]", "\"shape\":[4611686018427387904,3]"},
      {"\"shape\":[5,3]", "\"shape\":[0,3]"},
      {"\"shape\":[5,3]", "\"shape\":15"},
      {"\"data_offsets\":[0,60]", "\"data_offsets\":[60,0]"},
      {"\"data_offsets\":[0,60]", "\"data_offsets\":[0,61]"},
      {"\"data_offsets\":[0,60]", "\"data_offsets\":[-4,56]"},
      {"\"data_offsets\":[0,60]", "\"data_offsets\":[60,120]"},
      {"\"data_offsets\":[0,60]", "\"data_offsets\":[100000,100060]"},
      {"\"data_offsets\":[0,60]", "\"data_offsets\":[18446744073709551555,18446744073709551615]"},
      {"\"mean\":", "\"moon\":"},
      {"\"quaternion\":", "\"quaternio\":"},
      {"\"adam_moment2\":", "\"adam_moment3\":"},
      {"\"dtype\":\"F32\",\"shape\":[137]", "\"dtype\":\"F32\",\"shape\":[138]"},
  };
  for (const auto& [from, to] : forgeries) {
    SCOPED_TRACE(std::string(from) + " -> " + to);
    writeBytes(folder / "b.innergs", withHeader(bytes, from, to));
    EXPECT_EQ(errorOf([&] { readModel(folder / "b.innergs"); }).code(), ErrorCode::FileFormat);
  }
  writeBytes(folder / "b.innergs", withHeader(bytes, "\"format_version\":\"1\"", "\"format_version\":\"2\""));
  EXPECT_TRUE(contains(errorOf([&] { readModel(folder / "b.innergs"); }), "newer version"));
  writeBytes(folder / "b.innergs", bytes + "more");
  EXPECT_EQ(errorOf([&] { readModel(folder / "b.innergs"); }).code(), ErrorCode::FileFormat);
}

/// With a support of 4×3×2 voxels: runs of 2 outside, 7 inside, 1 outside, 14 inside.
Model maskedModel() {
  Model model = modelOf(5, false, false);
  GaussianField& field = model.field;
  field.support.geometry = cropped(field.domain, {3, 5, 7}, {4, 3, 2});
  field.support.voxels.assign(24, 1);
  for (const int outside : {0, 1, 9})
    field.support.voxels[outside] = 0;
  field.fill = -1.0f / 3;
  field.range = {-1000.0f / 7, 1234.5f};
  return model;
}

TEST(ModelFile, KeepsSupportFillAndRange) {
  const TemporaryFolder folder;
  const Model written = maskedModel();
  writeModel(written, folder / "a.innergs");
  GaussianField read = readModel(folder / "a.innergs").field;
  EXPECT_EQ(read.support.geometry, written.field.support.geometry);
  EXPECT_EQ(read.support.voxels, written.field.support.voxels);
  EXPECT_EQ(read.fill, written.field.fill);
  ASSERT_TRUE(read.range);
  EXPECT_EQ(read.range->low, written.field.range->low);
  EXPECT_EQ(read.range->high, written.field.range->high);
  for (const std::uint8_t all : {0, 1}) {
    Model whole = written;
    whole.field.support.voxels.assign(24, all);
    writeModel(whole, folder / "b.innergs");
    EXPECT_EQ(readModel(folder / "b.innergs").field.support.voxels, whole.field.support.voxels);
  }
  // Without a mask, and as earlier versions wrote them: no support and no extra data.
  writeModel(modelOf(5, false, false), folder / "c.innergs");
  read = readModel(folder / "c.innergs").field;
  EXPECT_TRUE(read.support.voxels.empty());
  EXPECT_FALSE(read.range);
  EXPECT_EQ(readBytes(folder / "c.innergs").find("support"), std::string::npos);
}

TEST(ModelFile, DamagedSupportIsRefused) {
  const TemporaryFolder folder;
  writeModel(maskedModel(), folder / "a.innergs");
  const std::string bytes = readBytes(folder / "a.innergs");
  const std::size_t runs = bytes.size() - 16;
  const auto refuse = [&](const std::string& damaged, const char* part) {
    SCOPED_TRACE(part);
    writeBytes(folder / "b.innergs", damaged);
    const Error error = errorOf([&] { readModel(folder / "b.innergs"); });
    EXPECT_EQ(error.code(), ErrorCode::FileFormat);
    EXPECT_TRUE(contains(error, part)) << error.what();
  };
  std::string other = bytes;
  other[runs + 4] = 8; // one voxel too many
  refuse(other, "'support'");
  other = bytes;
  other[runs + 15] = '\x7f'; // two billion
  refuse(other, "'support'");
  refuse(bytes.substr(0, bytes.size() - 4), "does not fit the file");
  refuse(withHeader(bytes, "[4,3,2]", "[4,3,3]"), "'support'");
  refuse(withHeader(bytes, "[4,3,2]", "[1000000000,1000000000,1000000000]"), "'support_grid'");
  refuse(withHeader(bytes, "\"U32\"", "\"F32\""), "'support'");
  refuse(withHeader(bytes, "\"shape\":[4]", "\"shape\":[2,2]"), "'support'");
  refuse(withHeader(bytes, "\"support_grid\"", "\"support_gird\""), "'support_grid'");
  refuse(withHeader(bytes, "\"fill_value\":\"", "\"fill_value\":\"x"), "'fill_value'");
  refuse(withHeader(bytes, "\"value_range\":\"[", "\"value_range\":\"[0,"), "'value_range'");
  refuse(withHeader(bytes, ",1234.5]", ",-1234.5]"), "value range");
}

TEST(ModelFile, NonFiniteValues) {
  const TemporaryFolder folder;
  for (int part = 0; part < 3; ++part) {
    Model model = modelOf(5, true, true);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    if (part == 0) model.field.gaussians[3].mean[1] = nan;
    if (part == 1) model.optimizer.moment1[7] = nan;
    if (part == 2) model.optimizer.moment2[7] = -nan;
    writeModel(model, folder / "a.innergs");
    EXPECT_EQ(errorOf([&] { readModel(folder / "a.innergs"); }).code(), ErrorCode::FileFormat) << part;
  }
}

TEST(ModelFile, NoModel) {
  const TemporaryFolder folder;
  EXPECT_EQ(errorOf([&] { readModel(folder / "missing.innergs"); }).code(), ErrorCode::FileNotFound);
  const auto codeOf = [&](const std::string& bytes) {
    writeBytes(folder / "a.innergs", bytes);
    return errorOf([&] { readModel(folder / "a.innergs"); }).code();
  };
  EXPECT_EQ(codeOf(""), ErrorCode::FileFormat);
  EXPECT_EQ(codeOf("text"), ErrorCode::FileFormat);
  EXPECT_EQ(codeOf("This is a longer text that is no model."), ErrorCode::FileFormat);
  EXPECT_EQ(codeOf(std::string(100, '\0')), ErrorCode::FileFormat);
  EXPECT_EQ(codeOf(std::string(100, '\xFF')), ErrorCode::FileFormat);
  EXPECT_EQ(codeOf(std::string("\2\0\0\0\0\0\0\0{}", 10)), ErrorCode::FileFormat);
  EXPECT_EQ(codeOf(std::string("\2\0\0\0\0\0\0\0[]", 10)), ErrorCode::FileFormat);
  EXPECT_EQ(codeOf(std::string("\x10\x27\0\0\0\0\0\0", 8) + std::string(10000, '[')), ErrorCode::FileFormat);
  EXPECT_EQ(errorOf([&] { readModel(folder.path()); }).code(), ErrorCode::FileFormat);
}

TEST(ModelFile, TruncatedAtAnyLength) {
  const TemporaryFolder folder;
  writeModel(modelOf(7, true, true), folder / "a.innergs");
  const std::string bytes = readBytes(folder / "a.innergs");
  for (std::size_t length = 0; length < bytes.size(); length += length < 64 ? 1 : 23) {
    writeBytes(folder / "b.innergs", bytes.substr(0, length));
    ASSERT_EQ(errorOf([&] { readModel(folder / "b.innergs"); }).code(), ErrorCode::FileFormat) << length;
  }
}

TEST(ModelFile, FlippedHeaderBytesNeverCrash) {
  const TemporaryFolder folder;
  const Model model = modelOf(3, true, false);
  writeModel(model, folder / "a.innergs");
  const std::string bytes = readBytes(folder / "a.innergs");
  std::uint64_t length;
  std::memcpy(&length, bytes.data(), 8);
  std::mt19937 random(2024);
  int refused = 0;
  for (int n = 0; n < 1500; ++n) {
    std::string forged = bytes;
    for (unsigned flips = 1 + random() % 4; flips > 0; --flips)
      forged[random() % (8 + length)] ^= static_cast<char>(1 << random() % 8);
    writeBytes(folder / "b.innergs", forged);
    try { // a flipped bit in a number or a text can leave a valid file
      EXPECT_EQ(readModel(folder / "b.innergs").field.size(), 3);
    } catch (const Error& error) {
      ++refused;
      EXPECT_TRUE(error.code() == ErrorCode::FileFormat || error.code() == ErrorCode::Memory) << error.what();
    }
  }
  EXPECT_GT(refused, 750);
}

TEST(ModelFile, UnwritableFolderLeavesNothing) {
  const TemporaryFolder folder;
  EXPECT_EQ(errorOf([&] { writeModel(modelOf(3, false, false), folder / "missing/a.innergs"); }).code(),
            ErrorCode::Io);
  EXPECT_EQ(folder.fileCount(), 0);
}

} // namespace
} // namespace innergs::test
