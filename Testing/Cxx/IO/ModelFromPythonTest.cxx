#include "Core/Base/NumberText.h"
#include "Core/Render/RenderPoints.h"
#include "IO/ModelFile.h"

#include "TestFiles.h"

#include "TestFields.h"

#include <cstdlib>
#include <locale>
#include <sstream>

namespace innergs::test {
namespace {

const std::string kPython = INNERGS_PYTHON;

bool runs(const std::string& command) {
#ifdef _WIN32
  return std::system((command + " >NUL 2>NUL").c_str()) == 0;
#else
  return std::system((command + " >/dev/null 2>/dev/null").c_str()) == 0;
#endif
}

/// Runs a script in the folder and returns the numbers that it wrote to out.txt.
std::vector<double> runPython(const TemporaryFolder& folder, const std::string& script) {
  const std::string start = "import os\nos.chdir(r'" + folder.path().string() + "')\n";
  writeBytes(folder / "script.py", start + script);
  EXPECT_EQ(std::system((kPython + " \"" + (folder / "script.py").string() + "\"").c_str()), 0);
  std::istringstream words(readBytes(folder / "out.txt"));
  words.imbue(std::locale::classic());
  std::vector<double> values;
  for (double value; words >> value;)
    values.push_back(value);
  return values;
}

/// The ```python blocks of the format's documentation.
std::string documentedCode() {
  const std::string text = readBytes(std::filesystem::path(INNERGS_DOCS) / "model-format.md");
  std::string code;
  for (std::size_t at = text.find("```python\n"); at != std::string::npos;
       at = text.find("```python\n", at)) {
    at += 10;
    code += text.substr(at, text.find("```", at) - at);
  }
  return code;
}

/// A direct implementation of the field's definition in double precision.
double valueAt(const GaussianField& field, const Vec3& world) {
  const Vec3 x = inverse(field.modelToWorld)(world);
  double numerator = 0, denominator = 0;
  for (const Gaussian& g : field.gaussians) {
    const double n =
        std::sqrt(double(g.quaternion[0]) * g.quaternion[0] + double(g.quaternion[1]) * g.quaternion[1] +
                  double(g.quaternion[2]) * g.quaternion[2] + double(g.quaternion[3]) * g.quaternion[3]);
    const double w = g.quaternion[0] / n;
    const Vec3 v{g.quaternion[1] / n, g.quaternion[2] / n, g.quaternion[3] / n};
    const Vec3 d = x - Vec3{g.mean[0], g.mean[1], g.mean[2]};
    const Vec3 t = 2.0 * cross(d, v); // d rotated by the inverse rotation
    const Vec3 local = d + w * t + cross(t, v);
    double square = 0;
    for (int axis = 0; axis < 3; ++axis)
      square += std::pow(local[axis] / std::exp(double(g.logScale[axis])), 2);
    if (square > field.cutoff * field.cutoff) continue;
    const double weight = std::exp(double(g.logWeight)) *
                          (std::exp(-0.5 * square) - std::exp(-0.5 * field.cutoff * field.cutoff));
    numerator += weight * (g.intensity + dot(d, {g.slope[0], g.slope[1], g.slope[2]}));
    denominator += weight;
  }
  const double value =
      field.blending == Blending::Additive ? numerator : numerator / (denominator + field.epsilon);
  return field.intensityScale * value + field.intensityOffset;
}

TEST(ModelFromPython, StandardLibraryReadsIt) {
  if (!runs(kPython + " --version")) GTEST_SKIP() << "no " << kPython;
  const TemporaryFolder folder;
  Model model;
  model.field = randomField(9, true);
  writeModel(model, folder / "model.innergs");
  const std::vector<double> values = runPython(folder, R"(
import json, struct
raw = open("model.innergs", "rb").read()
size, = struct.unpack("<Q", raw[:8])
header = json.loads(raw[8:8 + size])
meta = header["__metadata__"]
assert meta["format"] == "InnerGS" and meta["format_version"] == "1" and meta["blending"] == "normalised"
assert set(header) == {"__metadata__", "mean", "log_scale", "quaternion", "log_weight", "intensity", "slope"}
begin, end = header["mean"]["data_offsets"]
assert header["mean"] == {"dtype": "F32", "shape": [9, 3], "data_offsets": [begin, end]} and (8 + size) % 8 == 0
mean = struct.unpack("<27f", raw[8 + size + begin:8 + size + end])
with open("out.txt", "w") as out:
    for x in list(mean) + json.loads(meta["model_to_world"]) + [json.loads(meta["intensity_scale"])] + json.loads(meta["domain"])["spacing"]:
        print(repr(x), file=out)
)");
  ASSERT_EQ(values.size(), 27u + 16 + 1 + 3);
  for (std::size_t n = 0; n < 27; ++n)
    EXPECT_EQ(values[n], model.field.gaussians[n / 3].mean[n % 3]);
  EXPECT_EQ(values[27 + 1], model.field.modelToWorld.linear[0][1]);
  EXPECT_EQ(values[27 + 7], model.field.modelToWorld.offset[1]);
  EXPECT_EQ(values[27 + 16], model.field.intensityScale);
  EXPECT_EQ(values[27 + 17 + 2], model.field.domain.spacing[2]);
}

TEST(ModelFromPython, DocumentedCodeEvaluatesTheField) {
  if (!runs(kPython + " -c \"import numpy\"")) GTEST_SKIP() << kPython << " has no numpy";
  const std::vector<Vec3> inModel{{0, 0, 0}, {3, -4, 5}, {-8, 2, 1}, {60, 0, 0}, {-5, 3, 2}, {1, 1, -2}};
  for (const bool linearIntensity : {false, true})
    for (const Blending blending : {Blending::Normalised, Blending::Additive})
      for (const bool masked : {false, true}) {
        const TemporaryFolder folder;
        Model model;
        GaussianField& field = model.field;
        field = randomField(300, linearIntensity);
        field.blending = blending;
        field.domain.origin =
            field.modelToWorld.offset - 0.5 * (field.domain.direction * field.domain.extent());
        if (masked) {
          field.support.geometry = cropped(field.domain, {3, 4, 5}, {25, 30, 40});
          field.support.voxels.assign(25 * 30 * 40, 1);
          std::fill_n(field.support.voxels.begin(), 25 * 30 * 23, std::uint8_t{0});
          field.fill = 12.5f;
          field.range = {-500, 0};
          field.residual.geometry = withSpacing(field.domain, {3, 3, 3});
          for (std::int64_t v = 0; v < field.residual.geometry.voxelCount(); ++v)
            field.residual.voxels.push_back(0.1f * std::sin(static_cast<float>(v)));
        }
        writeModel(model, folder / "model.innergs");
        std::string script = documentedCode() + "\nwith open('out.txt', 'w') as out:\n";
        std::vector<Vec3> points;
        for (const Vec3& x : inModel) {
          points.push_back(field.modelToWorld(x));
          script += formatted("    print(repr(float(value([%.17g, %.17g, %.17g]))), file=out)\n",
                              points.back()[0], points.back()[1], points.back()[2]);
        }
        const std::vector<double> values = runPython(folder, script);
        ASSERT_EQ(values.size(), points.size());
        const std::vector<float> rendered = renderPoints(field, points);
        for (std::size_t n = 0; n < points.size(); ++n) {
          EXPECT_NEAR(values[n], rendered[n], 1e-4 * field.intensityScale);
          if (!masked && n < 3) {
            EXPECT_NEAR(values[n], valueAt(field, points[n]), 1e-5 * field.intensityScale);
          }
        }
        EXPECT_EQ(rendered[3], masked ? 12.5f : static_cast<float>(field.intensityOffset));
        if (!masked) continue;
        EXPECT_EQ(std::count(rendered.begin(), rendered.end(), 12.5f), 3) << "outside the mask";
        for (const float v : rendered)
          EXPECT_TRUE(v == 12.5f || (v >= -500 && v <= 0));
      }
}

} // namespace
} // namespace innergs::test
