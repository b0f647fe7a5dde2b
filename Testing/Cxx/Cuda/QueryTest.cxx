#include "Executors.h"
#include "RandomFields.h"
#include "TestVolumes.h"
#include "ThrownError.h"

#include "Core/Render/GridRenderer.h"
#include "Core/Render/Kernels.h"
#include "Core/Render/KernelsScalar.h"
#include "Core/Render/Render.h"
#include "Core/Render/RenderPoints.h"
#include "Cuda/Field.h"

using namespace innergs;
using namespace innergs::testing;

namespace {

constexpr double kQueryTolerance = 1e-4;

struct QueryCase {
  const char* name;
  Blending blending;
  bool linear, channel;
};
void PrintTo(const QueryCase& c, std::ostream* out) {
  *out << c.name;
}
const QueryCase kQueryCases[] = {{"Normalised", Blending::Normalised, true, false},
                                 {"NormalisedChannel", Blending::Normalised, true, true},
                                 {"Additive", Blending::Additive, false, false},
                                 {"Alpha", Blending::Alpha, false, false},
                                 {"AlphaChannel", Blending::Alpha, false, true}};

class Queries : public ::testing::TestWithParam<std::tuple<Where, QueryCase>> {
protected:
  GaussianField field() const {
    const QueryCase& c = std::get<1>(GetParam());
    Cloud cloud;
    cloud.low.fill(-12);
    cloud.high.fill(12);
    GaussianField f = randomField(200, cloud, 23, c.blending, c.linear);
    f.cutoff = 2.2;
    return f;
  }
  std::vector<float> values() const {
    std::vector<float> all;
    Numbers random(9);
    for (int i = 0; i < (std::get<1>(GetParam()).channel ? 200 : 0); ++i)
      all.push_back(static_cast<float>(random(-2, 5)));
    return all;
  }
  static SampleGrid oblique(int nx, int ny, int nz) {
    SampleGrid grid;
    grid.indexToModel = {obliqueDirection(0.9, true) * diagonal({0.7, 0.8, 1.3}), {-9, 8, 5}};
    grid.nx = nx;
    grid.ny = ny;
    for (int k = 0; k < nz; ++k)
      grid.z.push_back(k + 0.1 * (k % 3));
    return grid;
  }
  std::vector<float> expectedOn(const GaussianField& f, const SampleGrid& grid,
                                const std::vector<float>& values) const {
    ThreadPool pool(1);
    const KernelSet kernels = scalarKernels(Selection::Exact);
    GridRenderer renderer(grid, kernels, pool);
    std::vector<float> w(grid.bufferSize()), n(w.size()), out;
    renderer.forward(f, values, w.data(), n.data());
    for (int row = 0; row < grid.planes() * grid.ny; ++row)
      for (int x = 0; x < grid.nx; ++x) {
        const std::size_t i = static_cast<std::size_t>(row) * grid.stride() + x;
        out.push_back(f.blending == Blending::Normalised ? n[i] / (w[i] + static_cast<float>(f.epsilon))
                                                         : n[i]);
      }
    return out;
  }
};

TEST_P(Queries, RenderGridsAsTheCpu) {
  INNERGS_EXECUTOR_OR_SKIP(executor, std::get<0>(GetParam()));
  const GaussianField f = field();
  const std::vector<float> channel = values();
  cuda::Field device(std::move(executor), f);
  for (const auto& [nx, ny, nz] : {std::array{33, 29, 7}, std::array{64, 50, 1}, std::array{1, 1, 1}}) {
    const SampleGrid grid = oblique(nx, ny, nz);
    std::vector<float> found(static_cast<std::size_t>(nx) * ny * nz, -1.f);
    device.renderGrid(grid, {}, channel, found.data(), {});
    EXPECT_LE(relativeError(found, expectedOn(f, grid, channel)), kQueryTolerance)
        << nx << "x" << ny << "x" << nz;
  }
}

TEST_P(Queries, AnswerPointsAsTheCpu) {
  INNERGS_EXECUTOR_OR_SKIP(executor, std::get<0>(GetParam()));
  const GaussianField f = field();
  const std::vector<float> channel = values();
  cuda::Field device(std::move(executor), f);
  Numbers random(77);
  for (int count : {1, 500}) {
    std::vector<Vec3> points(count);
    for (Vec3& x : points)
      x = {random(-14, 14), random(-14, 14), random(-14, 14)};
    RenderOptions options;
    options.threads = 1;
    options.values = channel;
    options.scannerUnits = false;
    std::vector<float> found(count, -1.f);
    device.renderPoints(points, channel, found.data(), {});
    EXPECT_LE(relativeError(found, renderPoints(f, points, options)), kQueryTolerance) << count;
  }
}

TEST_P(Queries, StayInsideMaskAndRangeAsTheCpu) {
  INNERGS_EXECUTOR_OR_SKIP(executor, std::get<0>(GetParam()));
  GaussianField f = field();
  const std::vector<float> channel = values();
  f.domain = grid(21, 19, 17, {1.1, 1.2, 1.3}, {-10, -10, -10});
  f.support.geometry = cropped(f.domain, {2, 3, 4}, {15, 12, 10});
  f.support.voxels.assign(15 * 12 * 10, 1);
  std::fill_n(f.support.voxels.begin() + 15 * 12 * 5, 15 * 12 * 2, std::uint8_t{0});
  f.fill = -50;
  f.range = {0.1f, 0.8f};
  RenderOptions cpu, gpu;
  cpu.threads = gpu.threads = 1;
  cpu.values = gpu.values = channel;
  gpu.device = std::make_shared<cuda::Field>(std::move(executor), f);
  const GridGeometry geometry = grid(25, 23, 9, {0.9, 0.9, 1.7}, {-11, -9, -6}, obliqueDirection(0.3));
  const std::vector<float> expected = render(f, geometry, cpu).voxels,
                           found = render(f, geometry, gpu).voxels;
  const float outside = channel.empty() ? -50.f : 0.f;
  const auto filled = [&](const std::vector<float>& v) { return std::count(v.begin(), v.end(), outside); };
  EXPECT_GT(filled(expected), 1000);
  EXPECT_EQ(filled(found), filled(expected));
  EXPECT_LE(relativeError(found, expected), kQueryTolerance);
  if (channel.empty()) {
    for (const float v : found)
      ASSERT_TRUE(v == -50 || (v >= 0.1f && v <= 0.8f)) << v;
  }
  std::vector<Vec3> points;
  Numbers random(3);
  for (int n = 0; n < 400; ++n)
    points.push_back({random(-12, 12), random(-12, 12), random(-12, 12)});
  EXPECT_LE(relativeError(renderPoints(f, points, gpu), renderPoints(f, points, cpu)), kQueryTolerance);
}

TEST_P(Queries, RejectWhatCannotBe) {
  INNERGS_EXECUTOR_OR_SKIP(executor, std::get<0>(GetParam()));
  cuda::Field device(std::move(executor), field());
  const std::vector<float> tooFew(7);
  float out;
  const std::vector<Vec3> point{{0, 0, 0}}, broken{{0, NAN, 0}};
  EXPECT_THROW(device.renderPoints(point, tooFew, &out, {}), Error);
  EXPECT_THROW(device.renderPoints(broken, {}, &out, {}), Error);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(test::codeOf([&] { device.renderPoints(point, {}, &out, stop.get_token()); }),
            ErrorCode::Cancelled);
}

INSTANTIATE_TEST_SUITE_P(Everywhere, Queries,
                         ::testing::Combine(::testing::ValuesIn(kEverywhere),
                                            ::testing::ValuesIn(kQueryCases)),
                         [](const auto& info) {
                           return whereName(std::get<0>(info.param)) + std::get<1>(info.param).name;
                         });

TEST(FieldOnTheHostExecutor, TakesSmallerSlabsWhenMemoryIsShort) {
  Cloud cloud;
  const GaussianField f = randomField(100, cloud, 23);
  SampleGrid grid;
  grid.nx = 64;
  grid.ny = 64;
  for (int k = 0; k < 64; ++k)
    grid.z.push_back(k - 32);
  grid.indexToModel.offset = {-32, -32, 0};
  std::vector<float> whole(64 * 64 * 64), slabs(whole.size());
  cuda::Field(cuda::makeHostExecutor(), f).renderGrid(grid, {}, {}, whole.data(), {});
  cuda::Field(cuda::makeHostExecutor(1 << 20), f).renderGrid(grid, {}, {}, slabs.data(), {});
  EXPECT_EQ(whole, slabs);
  cuda::Field tiny(cuda::makeHostExecutor(1 << 15), f);
  EXPECT_EQ(test::codeOf([&] { tiny.renderGrid(grid, {}, {}, slabs.data(), {}); }), ErrorCode::Memory);
}

/// A plane of n×n points through the middle of a Cloud.
SampleGrid square(int n) {
  SampleGrid grid;
  grid.nx = grid.ny = n;
  grid.z = {0};
  grid.indexToModel.offset = {-n / 2.0, -n / 2.0, 0};
  return grid;
}

TEST(FieldOnTheHostExecutor, IsWholeAfterAnyFailedAllocation) {
  const GaussianField f = randomField(300, {}, 23);
  const int sizes[] = {64, 8, 40};
  std::vector<float> expected[3];
  for (int i = 0; i < 3; ++i) {
    expected[i].resize(sizes[i] * sizes[i]);
    cuda::Field(cuda::makeHostExecutor(), f).renderGrid(square(sizes[i]), {}, {}, expected[i].data(), {});
  }
  bool all = false;
  for (int allocation = 1; !all; ++allocation) {
    SCOPED_TRACE(allocation);
    ASSERT_LT(allocation, 100);
    auto executor = cuda::makeHostExecutor();
    cuda::Executor& memory = *executor;
    cuda::Field field(std::move(executor), f);
    cuda::failAllocations(memory, allocation, 1);
    std::vector<float> found(expected[0].size());
    try {
      field.renderGrid(square(sizes[0]), {}, {}, found.data(), {});
      all = true;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::Memory);
    }
    cuda::failAllocations(memory, 0, 0);
    for (int i : {1, 2, 0}) { // fewer pairs than there was room for, then more
      found.assign(expected[i].size(), -1.f);
      field.renderGrid(square(sizes[i]), {}, {}, found.data(), {});
      EXPECT_EQ(found, expected[i]) << sizes[i];
    }
  }
}

TEST(FieldOnTheHostExecutor, TakesLargerCellsForPointsWhenMemoryIsShort) {
  Cloud cloud;
  cloud.minSigma = 8;
  cloud.maxSigma = 20;
  const GaussianField f = randomField(200, cloud, 23);
  Numbers random(77);
  std::vector<Vec3> points(1000);
  for (Vec3& x : points)
    x = {random(-1, 1), random(-1, 1), random(-1, 1)};
  RenderOptions options;
  options.threads = 1;
  options.scannerUnits = false;
  std::vector<float> found(points.size());
  cuda::Field(cuda::makeHostExecutor(1 << 20), f).renderPoints(points, {}, found.data(), {});
  EXPECT_LE(relativeError(found, renderPoints(f, points, options)), kQueryTolerance);
  cuda::Field tiny(cuda::makeHostExecutor(1 << 16), f);
  EXPECT_EQ(test::codeOf([&] { tiny.renderPoints(points, {}, found.data(), {}); }), ErrorCode::Memory);
}

} // namespace
