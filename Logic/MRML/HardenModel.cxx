#include "HardenModel.h"

#include "Core/Base/Error.h"
#include "Core/Model/GaussianMath.h"

#include <vtkMath.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace innergs::mrml {
namespace {

constexpr double kTolerance = 1e-4; // tolerance for matrices stored with few digits

bool isRigid(const Mat3& a) {
  const Mat3 gram = transpose(a) * a;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (!(std::abs(gram[i][j] - (i == j)) <= 1e-6)) return false;
  return determinant(a) > 0;
}

std::vector<const GridGeometry*> gridsOf(const GaussianField& field, const FeatureModel* features) {
  std::vector<const GridGeometry*> grids;
  if (field.domain.voxelCount() > 0) grids.push_back(&field.domain);
  if (!field.support.voxels.empty()) grids.push_back(&field.support.geometry);
  if (!field.residual.voxels.empty()) grids.push_back(&field.residual.geometry);
  if (features) grids.push_back(&features->support.blocks);
  if (features && !features->residual.empty()) grids.push_back(&features->residual.grid);
  return grids;
}

bool keepsRightAngles(const Mat3& linear, const GridGeometry& grid) {
  const Mat3 axes = linear * grid.direction;
  for (int i = 0; i < 3; ++i) {
    const Vec3 a = column(axes, i), b = column(axes, (i + 1) % 3);
    if (!(std::abs(dot(a, b)) <= kTolerance * norm(a) * norm(b))) return false;
  }
  return true;
}

void setColumn(Mat3& matrix, int j, const Vec3& x) {
  for (int i = 0; i < 3; ++i)
    matrix[i][j] = x[i];
}

/// The turning, scaling and mirroring part Q·diag(R) of map·axes = Q·R, seen from outside the axes.
Mat3 withoutShear(const Mat3& map, const Mat3& axes) {
  const Mat3 turned = map * axes;
  Mat3 scaled;
  std::array<Vec3, 3> q;
  for (int j = 0; j < 3; ++j) {
    Vec3 rest = column(turned, j);
    for (int i = 0; i < j; ++i)
      rest = rest - dot(q[i], column(turned, j)) * q[i];
    q[j] = (1 / norm(rest)) * rest;
    setColumn(scaled, j, rest);
  }
  return scaled * inverse(axes);
}

/// What of a map the model's grids can take.
Affine3 takeable(const GaussianField& field, const FeatureModel* features, const Affine3& map) {
  const auto grids = gridsOf(field, features);
  const auto fits = [&](const Mat3& linear) {
    return std::all_of(grids.begin(), grids.end(),
                       [&](const GridGeometry* grid) { return keepsRightAngles(linear, *grid); });
  };
  if (fits(map.linear)) return map;
  const Mat3 linear = withoutShear(map.linear, grids.front()->direction);
  return fits(linear) ? Affine3{linear, map.offset} : Affine3{};
}

void move(GridGeometry& grid, const Affine3& map) {
  grid.origin = map(grid.origin);
  const Mat3 axes = map.linear * grid.direction;
  for (int j = 0; j < 3; ++j) {
    const double stretch = norm(column(axes, j));
    setColumn(grid.direction, j, (1 / stretch) * column(axes, j));
    grid.spacing[j] *= stretch;
  }
}

/// By a linear map of the model frame; slopeMap is its inverse transposed.
void move(Gaussian& g, const Mat3& linear, const Mat3& slopeMap) {
  double q[4], r[9];
  std::copy_n(g.quaternion, 4, q);
  math::rotation(q, r);
  Mat3 root; // of the covariance: its columns are the axes with their lengths
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      root[i][j] = r[3 * i + j] * std::exp(static_cast<double>(g.logScale[j]));
  root = linear * root;
  const Mat3 moved = root * transpose(root);
  double covariance[3][3], variances[3], axes[3][3];
  for (int i = 0; i < 3; ++i)
    std::copy_n(moved[i].begin(), 3, covariance[i]);
  vtkMath::Diagonalize3x3(covariance, variances, axes); // axes form a rotation
  vtkMath::Matrix3x3ToQuaternion(axes, q);
  std::copy_n(q, 4, g.quaternion);
  for (int a = 0; a < 3; ++a)
    g.logScale[a] = static_cast<float>(0.5 * std::log(std::max(variances[a], 1e-34)));
  const Vec3 mean = linear * Vec3{g.mean[0], g.mean[1], g.mean[2]};
  const Vec3 slope = slopeMap * Vec3{g.slope[0], g.slope[1], g.slope[2]};
  for (int a = 0; a < 3; ++a) {
    g.mean[a] = static_cast<float>(mean[a]);
    g.slope[a] = static_cast<float>(slope[a]);
  }
}

} // namespace

HardenedModel harden(const Model& model, const FeatureModel* features, const Affine3& map) {
  if (!(std::abs(determinant(map.linear)) > 1e-9) || !std::isfinite(norm(map.offset)))
    throw Error(ErrorCode::Geometry, "The transform cannot be inverted: correct or remove it.");
  const Affine3 taken = takeable(model.field, features, map);
  HardenedModel result;
  auto moved = std::make_shared<Model>(model);
  GaussianField& field = moved->field;
  const Mat3 frame = field.modelToWorld.linear;
  if (isRigid(taken.linear)) {
    field.modelToWorld = taken * field.modelToWorld;
  } else {
    // A frame whose third axis crosses the moved slices: alpha blending looks along it.
    const Mat3 axes = taken.linear * frame;
    const Vec3 across = cross(column(axes, 0), column(axes, 1));
    const Vec3 first = (1 / norm(column(axes, 0))) * column(axes, 0), third = (1 / norm(across)) * across;
    setColumn(field.modelToWorld.linear, 0, first);
    setColumn(field.modelToWorld.linear, 1, cross(third, first));
    setColumn(field.modelToWorld.linear, 2, third);
    const Mat3 linear = transpose(field.modelToWorld.linear) * axes;
    const Mat3 slopeMap = transpose(inverse(linear));
    for (Gaussian& g : field.gaussians)
      move(g, linear, slopeMap);
    field.modelToWorld.offset = taken(field.modelToWorld.offset);
  }
  if (field.domain.voxelCount() > 0) move(field.domain, taken);
  if (!field.support.voxels.empty()) move(field.support.geometry, taken);
  if (!field.residual.voxels.empty()) move(field.residual.geometry, taken);
  if (features) {
    const auto movedFeatures = std::make_shared<FeatureModel>(*features);
    move(movedFeatures->support.blocks, taken);
    if (!movedFeatures->residual.empty()) move(movedFeatures->residual.grid, taken);
    result.features = movedFeatures;
  }
  moved->optimizer = {};
  moved->finished = field.size();
  moved->settingsKey.clear();
  checkField(field);
  result.model = std::move(moved);
  result.complete = taken == map;
  if (!result.complete) result.rest = map * inverse(taken);
  return result;
}

} // namespace innergs::mrml
