#include "Core/Features/FeatureTraining.h"
#include "Core/Features/FeatureDevices.h"
#include "Core/Features/FeatureQuery.h"
#include "Features/BoxPhantom.h"
#include "ThrownError.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace innergs::testing {
namespace {

const std::vector<SegmentName> kNames{{1, "liver"}, {2, "spleen"}, {3, "kidney_left"}, {9, "heart"}};

int wrongVoxels(const ClassImage& image, const FeatureModel& model, const Labelmap& truth) {
  int wrong = 0;
  for (std::size_t v = 0; v < truth.voxels.size(); ++v)
    wrong += model.labels[image.classes[v]] != truth.voxels[v];
  return wrong;
}

TEST(FeatureTraining, NamedBoxesAreFoundExactly) {
  const BoxPhantom phantom;
  const FeatureModel model = trainFeatures(phantom.field, phantom.labels, kNames);
  EXPECT_EQ(model.names, (std::vector<std::string>{"background", "liver", "spleen", "kidney_left"}));
  EXPECT_NO_THROW(checkFeatures(model, phantom.field));
  const ClassImage image = classify(phantom.field, model, phantom.labels.geometry);
  EXPECT_EQ(wrongVoxels(image, model, phantom.labels), 0);
}

/// Fails at its third step, or when the result is fetched.
class FailingDevice final : public FeatureDevice {
public:
  explicit FailingDevice(int steps) : left_(steps) {}
  void step(const FeatureStep&) override { use(); }
  void download(std::span<float> latents, std::span<float>) override {
    std::fill(latents.begin(), latents.end(), 7.f);
    use();
  }

private:
  void use() {
    if (left_-- == 0) throw Error(ErrorCode::Internal, "The device is lost.");
  }
  int left_;
};

class FailingDevices final : public FeatureDevices {
public:
  int steps = 0, made = 0;
  std::string said;
  std::unique_ptr<FeatureDevice> make(const FeatureProblem&, int, const std::stop_token&) override {
    ++made;
    if (steps < 0) return nullptr;
    return std::make_unique<FailingDevice>(steps);
  }
  void failed(const std::string& why) override { said = why; }
};

TEST(FeatureTraining, ADeviceThatFailsLeavesNoTrace) {
  const BoxPhantom phantom;
  FeatureTraining training;
  training.iterations = 4;
  const FeatureModel cpu = trainFeatures(phantom.field, phantom.labels, kNames, training);
  for (const int steps : {-1, 0, 2, 4}) {
    const auto devices = std::make_shared<FailingDevices>();
    devices->steps = steps;
    training.devices = devices;
    const FeatureModel model = trainFeatures(phantom.field, phantom.labels, kNames, training);
    EXPECT_EQ(devices->made, 1);
    EXPECT_EQ(devices->said, steps < 0 ? "" : "The device is lost.");
    EXPECT_EQ(model.latents, cpu.latents) << steps;
    EXPECT_EQ(model.codes, cpu.codes) << steps;
  }
}

TEST(FeatureTraining, LabelsOnAnotherGridAndQueriesOnAnyPlane) {
  const BoxPhantom phantom;
  GridGeometry turned = withSpacing(phantom.labels.geometry, {1.5, 1.5, 1.5});
  turned.direction = turned.direction * Mat3{{{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}}};
  turned.origin = turned.origin + (phantom.labels.geometry.centre() - turned.centre());
  const FeatureModel model = trainFeatures(phantom.field, resampled(phantom.labels, turned), kNames);
  const ClassImage image = classify(phantom.field, model, phantom.labels.geometry);
  EXPECT_LE(wrongVoxels(image, model, phantom.labels), 0.03 * static_cast<double>(image.classes.size()));
  const ClassImage plane =
      classify(phantom.field, model, cropped(phantom.labels.geometry, {0, 0, 6}, {14, 14, 1}));
  for (std::size_t v = 0; v < plane.classes.size(); ++v)
    EXPECT_EQ(plane.classes[v], image.classes[v + 6 * 14 * 14]);
  GridGeometry away = phantom.labels.geometry;
  away.origin[0] += 500;
  const ClassImage nothing = classify(phantom.field, model, away);
  EXPECT_EQ(std::count(nothing.classes.begin(), nothing.classes.end(), 0),
            static_cast<std::ptrdiff_t>(nothing.classes.size()));
}

/// Balls of two labels in space: 1 at the left, 2 at the right, 0 around.
std::uint16_t ballAt(const Vec3& x, const Vec3& middle) {
  for (const auto& [side, label] : {std::pair{-1.0, std::uint16_t{1}}, {1.0, std::uint16_t{2}}})
    if (norm(x - middle - Vec3{5.5 * side, 0.7, -0.4}) < 5) return label;
  return 0;
}

Labelmap ballsOn(const GridGeometry& geometry, const Vec3& middle) {
  Labelmap out{geometry, {}, {}};
  const auto& n = geometry.size;
  for (std::int64_t v = 0; v < geometry.voxelCount(); ++v)
    out.voxels.push_back(
        ballAt(geometry.indexToWorld()({static_cast<double>(v % n[0]), static_cast<double>(v / n[0] % n[1]),
                                        static_cast<double>(v / (n[0] * n[1]))}),
               middle));
  return out;
}

TEST(FeatureTraining, TheResidualReachesOtherGrids) {
  BoxPhantom phantom;
  const GridGeometry own = phantom.labels.geometry;
  for (Gaussian& gaussian : phantom.field.gaussians) { // blurred, and the image says nothing of the labels
    gaussian.intensity = 0.5f;
    for (float& scale : gaussian.logScale)
      scale = std::log(2.2f);
  }
  phantom.labels = ballsOn(own, own.centre());
  const FeatureModel model = trainFeatures(phantom.field, phantom.labels, kNames);
  ASSERT_FALSE(model.residual.empty());
  FeatureModel alone = model;
  alone.residual = {};
  EXPECT_EQ(wrongVoxels(classify(phantom.field, model, own), model, phantom.labels), 0);
  EXPECT_GT(wrongVoxels(classify(phantom.field, alone, own), alone, phantom.labels), 0);
  GridGeometry oblique = own;
  const double c = std::cos(0.4), s = std::sin(0.4);
  oblique.direction = Mat3{{{{1, 0, 0}, {0, c, -s}, {0, s, c}}}} * own.direction;
  oblique.origin = own.centre() + (oblique.origin - oblique.centre());
  for (const GridGeometry& grid : {oblique, withSpacing(own, {1, 1, 1})}) {
    const Labelmap truth = ballsOn(grid, own.centre()); // continuous: no voxel of the labels is repeated
    const int wrong = wrongVoxels(classify(phantom.field, model, grid), model, truth),
              without = wrongVoxels(classify(phantom.field, alone, grid), alone, truth);
    EXPECT_LT(wrong, without);
    int repeated = 0;
    const Labelmap nearest = resampled(phantom.labels, grid);
    for (std::size_t v = 0; v < truth.voxels.size(); ++v)
      repeated += nearest.voxels[v] != truth.voxels[v];
    EXPECT_LT(wrong, repeated);
  }
}

TEST(FeatureTraining, TheResidualIsOfLabelledSlicesAlone) {
  const BoxPhantom phantom(20);
  FeatureTraining training;
  training.iterations = 1;
  const FeatureModel model = trainFeatures(phantom.field, phantom.every(5), kNames, training);
  ASSERT_FALSE(model.residual.empty());
  for (const std::uint32_t voxel : model.residual.voxels)
    EXPECT_EQ(voxel / (20 * 20) % 5, 0u);
}

TEST(FeatureTraining, SparseSlicesFollowTheImage) {
  const BoxPhantom phantom(20);
  const Labelmap teacher = phantom.every(5);
  const FeatureModel model = trainFeatures(phantom.field, teacher, kNames);
  const ClassImage image = classify(phantom.field, model, phantom.labels.geometry);
  EXPECT_LE(wrongVoxels(image, model, phantom.labels), 0.01 * static_cast<double>(image.classes.size()));
}

TEST(FeatureTraining, SameBitsAtAnyNumberOfThreads) {
  const BoxPhantom phantom;
  FeatureTraining training;
  training.iterations = 8;
  training.threads = 1;
  const FeatureModel one = trainFeatures(phantom.field, phantom.every(3), kNames, training);
  training.threads = 5;
  const FeatureModel many = trainFeatures(phantom.field, phantom.every(3), kNames, training);
  EXPECT_EQ(one.latents, many.latents);
  EXPECT_EQ(one.codes, many.codes);
  EXPECT_EQ(one.residual.voxels, many.residual.voxels);
  EXPECT_EQ(one.residual.entries, many.residual.entries);
  FeatureQueryOptions options;
  options.threads = 3;
  EXPECT_EQ(classify(phantom.field, one, phantom.labels.geometry).classes,
            classify(phantom.field, many, phantom.labels.geometry, options).classes);
}

TEST(FeatureTraining, ReportsProgressAndStops) {
  const BoxPhantom phantom;
  std::stop_source stop;
  std::vector<double> seen;
  FeatureTraining training;
  training.stop = stop.get_token();
  training.progress = [&](double fraction) {
    seen.push_back(fraction);
    if (fraction > 0.7) stop.request_stop();
  };
  EXPECT_EQ(test::codeOf([&] { trainFeatures(phantom.field, phantom.every(3), kNames, training); }),
            ErrorCode::Cancelled);
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
  EXPECT_LT(seen.back(), 0.8);
}

TEST(FeatureTraining, RefusesWhatCannotBeLearned) {
  const BoxPhantom phantom;
  const auto codeOf = [&](const Labelmap& labels, const FeatureTraining& training) {
    return test::codeOf([&] { trainFeatures(phantom.field, labels, kNames, training); });
  };
  Labelmap away = phantom.labels;
  away.geometry.origin[2] += 1000;
  EXPECT_EQ(codeOf(away, {}), ErrorCode::NoData);
  Labelmap empty = phantom.labels;
  std::fill(empty.voxels.begin(), empty.voxels.end(), std::uint16_t{0});
  EXPECT_EQ(codeOf(empty, {}), ErrorCode::NoData);
  Labelmap cut = phantom.labels;
  cut.voxels.pop_back();
  EXPECT_EQ(codeOf(cut, {}), ErrorCode::InvalidArgument);
  FeatureTraining training;
  training.channels = 7;
  EXPECT_EQ(codeOf(phantom.labels, training), ErrorCode::InvalidArgument);
}

TEST(FeatureTraining, ForgedFeaturesAreRefused) {
  const BoxPhantom phantom(8);
  FeatureTraining training;
  training.iterations = 1;
  const FeatureModel good = trainFeatures(phantom.field, phantom.labels, kNames, training);
  FeatureModel bad = good;
  bad.latents.pop_back();
  EXPECT_THROW(checkFeatures(bad, phantom.field), Error);
  bad = good;
  bad.codes[0] = NAN;
  EXPECT_THROW(checkFeatures(bad, phantom.field), Error);
  bad = good;
  bad.support.bits.clear();
  EXPECT_THROW(checkFeatures(bad, phantom.field), Error);
  ASSERT_FALSE(good.residual.empty());
  bad = good;
  bad.residual.entries.back() = ClassResidual::packed(4, 0.5f); // of 0 to 3
  EXPECT_THROW(checkFeatures(bad, phantom.field), Error);
  bad = good;
  bad.residual.ends.back() += 1;
  EXPECT_THROW(checkFeatures(bad, phantom.field), Error);
  bad = good;
  bad.residual.voxels.clear();
  bad.residual.ends.clear(); // entries of no voxel
  EXPECT_THROW(checkFeatures(bad, phantom.field), Error);
  bad = good;
  bad.residual.voxels.back() = 8 * 8 * 8;
  EXPECT_THROW(checkFeatures(bad, phantom.field), Error);
}

} // namespace
} // namespace innergs::testing
