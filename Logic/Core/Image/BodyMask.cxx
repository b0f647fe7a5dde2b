#include "Core/Image/BodyMask.h"
#include "Core/Base/StopToken.h"
#include "Core/Image/Components.h"
#include "Core/Image/Otsu.h"

namespace innergs {
namespace {

constexpr std::uint8_t outside = 0, foreground = 1;

// Sets to 1 everything that cannot be reached from the slice's border through zeros.
void fillHoles(std::uint8_t* slice, std::int64_t width, std::int64_t height) {
  std::vector<std::uint8_t> air(static_cast<std::size_t>(width * height), 0);
  std::vector<std::int64_t> queue;
  const auto visit = [&](std::int64_t p) {
    if (!slice[p] && !air[p]) {
      air[p] = 1;
      queue.push_back(p);
    }
  };
  for (std::int64_t x = 0; x < width; ++x) {
    visit(x);
    visit(x + width * (height - 1));
  }
  for (std::int64_t y = 0; y < height; ++y) {
    visit(y * width);
    visit(y * width + width - 1);
  }
  while (!queue.empty()) {
    const std::int64_t p = queue.back(), x = p % width, y = p / width;
    queue.pop_back();
    if (x > 0) visit(p - 1);
    if (x + 1 < width) visit(p + 1);
    if (y > 0) visit(p - width);
    if (y + 1 < height) visit(p + width);
  }
  for (std::int64_t p = 0; p < width * height; ++p)
    slice[p] = !air[p];
}

} // namespace

std::vector<std::uint8_t> bodyMask(const Volume& volume, const std::stop_token& stop) {
  const auto& n = volume.geometry.size;
  throwIfStopped(stop);
  const double threshold = foregroundThreshold(volume.voxels);
  std::vector<std::uint8_t> label(volume.voxels.size());
  for (std::size_t p = 0; p < label.size(); ++p)
    label[p] = volume.voxels[p] > threshold ? foreground : outside;

  std::vector<std::uint8_t> all = label;
  std::vector<std::int64_t> best;
  std::size_t count = 0;
  for (std::size_t p = 0; p < label.size(); ++p)
    if (label[p] == foreground) {
      auto component = floodFill(label, n, static_cast<std::int64_t>(p), stop);
      count += component.size();
      if (component.size() > best.size()) best.swap(component);
    }
  if (best.empty()) return std::vector<std::uint8_t>(label.size(), 1); // constant image: everything
  if (2 * best.size() < count) {
    label.swap(all);
  } else {
    label.assign(label.size(), outside);
    for (const std::int64_t p : best)
      label[p] = foreground;
  }
  for (std::int64_t k = 0; k < n[2]; ++k) {
    throwIfStopped(stop);
    fillHoles(label.data() + k * n[0] * n[1], n[0], n[1]);
  }
  return label;
}

} // namespace innergs
