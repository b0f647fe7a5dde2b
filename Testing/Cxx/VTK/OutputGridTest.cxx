#include "ReconstructFixtures.h"

#include "Core/Image/Region.h"

using namespace innergs;
using namespace innergs::testing;

TEST(ReconstructFilter, PutsTheResultOnTheGridAskedFor) {
  ReconstructionInput input = isotropicInput();
  const GridGeometry& g = input.stacks[0].image.geometry;
  auto filter = quickFilter(input);
  filter->SetOutputSpacing(2, 1.5, 1);
  filter->Update();
  input.outputGrid = withSpacing(g, {2, 1.5, 1});
  expectSame(filter, reconstruct(input, quickSettings()));

  const GridGeometry reference =
      grid(9, 7, 5, {2, 2, 3}, g.centre() - Vec3{6, 5, 4}, obliqueDirection(1.2, true));
  filter->SetReferenceGrid(rasMatrix(reference), 9, 7, 5);
  filter->Update();
  input.outputGrid = reference;
  expectSame(filter, reconstruct(input, quickSettings()));

  filter->SetReferenceImage(filter->GetOutputImage()); // its own geometry
  filter->Update();
  EXPECT_TRUE(closeTo(filter->GetOutputIJKToRASMatrix(), rasMatrix(reference), 1e-9));
  filter->SetReferenceImage(nullptr);
  EXPECT_FALSE(filter->HasReferenceGrid());

  ReconstructionInput straight = posedInput({"Straight", 0, false}, false);
  const GridGeometry& h = straight.stacks[0].image.geometry;
  auto regional = quickFilter(straight);
  const Vec3 c = h.centre(); // LPS
  regional->SetRegion(-c[0] - 5, -c[0] + 4, -c[1] - 6, -c[1] + 3, c[2] - 4, c[2] + 5);
  regional->UseRegionOn();
  regional->Update();
  const Region region{{c[0] - 4, c[1] - 3, c[2] - 4}, {c[0] + 5, c[1] + 6, c[2] + 5}};
  straight.outputGrid = cropped(withSpacing(h, {0.9, 0.9, 0.9}), region); // the finest spacing
  straight.stacks[0] = cropped(straight.stacks[0], region, 2 * h.spacing[2]);
  expectSame(regional, reconstruct(straight, quickSettings()));
}

TEST(ReconstructFilter, FitsOnlyWhatIsInsideATurnedRegion) {
  ReconstructionInput input = isotropicInput();
  Volume& image = input.stacks[0].image;
  const GridGeometry& g = image.geometry;
  const Affine3 frame{obliqueDirection(1.1), g.centre()};
  const Affine3 toBox = inverse(frame);
  const double half[3] = {6, 4, 5};
  const auto beyond = [&](const Vec3& x, double margin) {
    const Vec3 at = toBox(x);
    return std::abs(at[0]) > half[0] + margin || std::abs(at[1]) > half[1] + margin ||
           std::abs(at[2]) > half[2] + margin;
  };
  const auto fitted = [&] {
    auto filter = quickFilter(input);
    filter->SetRegion(-half[0], half[0], -half[1], half[1], -half[2], half[2]);
    filter->SetRegionToRASMatrix(rasMatrix(frame));
    filter->UseRegionOn();
    filter->Update();
    EXPECT_EQ(filter->GetErrorMessage(), "");
    return filter;
  };
  const auto first = fitted();
  std::int64_t changed = 0;
  const double margin = 2 * g.spacing[2];
  const GridGeometry block =
      cropped(g, GridGeometry{{1, 1, 1}, g.centre(), {12, 8, 10}, frame.linear}, margin);
  const Affine3 toBlock = inverse(block.indexToWorld()) * g.indexToWorld();
  for (std::int64_t v = 0; v < g.voxelCount(); ++v) {
    const Vec3 index{double(v % g.size[0]), double(v / g.size[0] % g.size[1]),
                     double(v / g.size[0] / g.size[1])};
    if (!beyond(g.indexToWorld()(index), margin + 1e-6)) continue;
    image.voxels[static_cast<std::size_t>(v)] += 500;
    const Vec3 at = toBlock(index);
    bool within = true;
    for (int a = 0; a < 3; ++a)
      within = within && at[a] > -0.5 && at[a] < double(block.size[a]) - 0.5;
    changed += within;
  }
  EXPECT_GT(changed, 500); // also in the block around the box
  const auto second = fitted();
  EXPECT_TRUE(sameField(*first->GetOutputModel()->GetField(), *second->GetOutputModel()->GetField()));
  EXPECT_EQ(valuesOf(first->GetOutputImage()), valuesOf(second->GetOutputImage()));
  EXPECT_EQ(first->GetOutputImage()->GetNumberOfPoints(),
            cropped(g, GridGeometry{{1, 1, 1}, g.centre(), {12, 8, 10}, frame.linear}).voxelCount());
}
