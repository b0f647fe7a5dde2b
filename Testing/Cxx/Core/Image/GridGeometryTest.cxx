#include "Core/Image/GridGeometry.h"

#include "TestVolumes.h"
#include "ThrownError.h"

#include <gtest/gtest.h>
#include <limits>

using namespace innergs;
using namespace innergs::testing;

namespace {

void expectNear(const Vec3& a, const Vec3& b, double tolerance) {
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(a[axis], b[axis], tolerance) << "axis " << axis;
}

ErrorCode codeOf(const GridGeometry& geometry, std::string* sentence = nullptr) {
  const Error error = test::errorOf([&] { checkGeometry(geometry, "scan.nii"); });
  if (sentence) *sentence = error.what();
  return error.code();
}

} // namespace

TEST(GridGeometry, CentreIsTheMiddleOfTheBox) {
  const GridGeometry g = grid(4, 5, 6, {1, 2, 3}, {10, 20, 30});
  expectNear(g.centre(), {11.5, 24, 37.5}, 1e-12);
  expectNear(g.extent(), {4, 10, 18}, 1e-12);
}

TEST(GridGeometry, AcceptsObliqueAndLeftHandedGrids) {
  EXPECT_NO_THROW(checkGeometry(grid(4, 4, 4, {1, 2, 3}, {0, 0, 0}, obliqueDirection(0.7)), "a"));
  EXPECT_NO_THROW(checkGeometry(grid(4, 4, 4, {1, 2, 3}, {0, 0, 0}, obliqueDirection(0.7, true)), "a"));
}

TEST(GridGeometry, RefusesBrokenGridsWithTheImagesName) {
  std::string sentence;
  GridGeometry g = grid(4, 0, 4);
  EXPECT_EQ(codeOf(g, &sentence), ErrorCode::Geometry);
  EXPECT_NE(sentence.find("scan.nii"), std::string::npos);
  g = grid(4, 4, 4, {1, 0, 1});
  EXPECT_EQ(codeOf(g, &sentence), ErrorCode::Geometry);
  EXPECT_NE(sentence.find("spacing"), std::string::npos);
  EXPECT_EQ(codeOf(grid(4, 4, 4, {1, -1, 1})), ErrorCode::Geometry);
  EXPECT_EQ(codeOf(grid(4, 4, 4, {1, std::numeric_limits<double>::quiet_NaN(), 1})), ErrorCode::Geometry);
  EXPECT_EQ(codeOf(grid(4, 4, 4, {1, 1, 1}, {0, std::numeric_limits<double>::infinity(), 0})),
            ErrorCode::Geometry);
  g = grid(4, 4, 4);
  g.direction[0][1] = 0.1; // shear
  EXPECT_EQ(codeOf(g, &sentence), ErrorCode::Geometry);
  EXPECT_NE(sentence.find("sheared"), std::string::npos);
  g = grid(4, 4, 4);
  g.direction[1] = {1, 0, 0}; // two axes alike
  g.direction[0] = {1, 0, 0};
  EXPECT_EQ(codeOf(g, &sentence), ErrorCode::Geometry);
  EXPECT_NE(sentence.find("singular"), std::string::npos);
  EXPECT_EQ(codeOf(grid(std::int64_t(1) << 40, std::int64_t(1) << 40, 4)), ErrorCode::Geometry);
}

TEST(GridGeometry, WithSpacingKeepsTheBox) {
  const GridGeometry g = grid(10, 12, 5, {1, 1, 4}, {-3, 7, 11}, obliqueDirection(0.4, true));
  const GridGeometry fine = withSpacing(g, {1, 1, 1});
  EXPECT_EQ(fine.size, (std::array<std::int64_t, 3>{10, 12, 20}));
  expectNear(fine.centre(), g.centre(), 1e-9);
  // Voxel edges coincide: index −½ of both.
  expectNear(fine.indexToWorld()({-0.5, -0.5, -0.5}), g.indexToWorld()({-0.5, -0.5, -0.5}), 1e-9);
  EXPECT_THROW(withSpacing(g, {1, 0, 1}), Error);
}

TEST(GridGeometry, CroppedKeepsPatientPositions) {
  const GridGeometry g = grid(10, 12, 5, {1, 2, 4}, {-3, 7, 11}, obliqueDirection(1.1));
  const GridGeometry part = cropped(g, {2, 3, 1}, {4, 5, 2});
  expectNear(part.indexToWorld()({1, 1, 1}), g.indexToWorld()({3, 4, 2}), 1e-9);
  EXPECT_THROW(cropped(g, {8, 0, 0}, {3, 1, 1}), Error);
  EXPECT_THROW(cropped(g, {-1, 0, 0}, {3, 1, 1}), Error);
}

TEST(GridGeometry, DepthIsTheDistanceToTheNearestFace) {
  const GridGeometry g = grid(10, 8, 6, {1, 2, 5}, {3, 4, 5}, obliqueDirection(0.5));
  EXPECT_DOUBLE_EQ(depthInside(g, {4, 3.5, 2.5}), 4.5);
  EXPECT_DOUBLE_EQ(depthInside(g, {4.5, 0, 2.5}), 1);
  EXPECT_DOUBLE_EQ(depthInside(g, {4.5, 3.5, 5.25}), 1.25);
  EXPECT_DOUBLE_EQ(depthInside(g, {4.5, 3.5, -0.75}), -1.25);
}

TEST(GridGeometry, SameGridSeesShiftsAndSizes) {
  const GridGeometry g = grid(10, 12, 5, {1, 2, 4}, {-3, 7, 11}, obliqueDirection(1.1));
  GridGeometry other = g;
  EXPECT_TRUE(sameGrid(g, other));
  other.origin[1] += 5e-4;
  EXPECT_TRUE(sameGrid(g, other));
  other.origin[1] += 5e-3;
  EXPECT_FALSE(sameGrid(g, other));
  other = g;
  other.spacing[2] *= 1.01; // the origin agrees, the far corner does not
  EXPECT_FALSE(sameGrid(g, other));
  other = g;
  other.size[0] = 9;
  EXPECT_FALSE(sameGrid(g, other));
}
