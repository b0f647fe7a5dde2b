#include "Core/Image/BodyMask.h"
#include "Core/Base/Error.h"
#include "Core/Image/Otsu.h"

#include <algorithm>

namespace innergs {
namespace {

constexpr std::size_t stride = 1 << 18; // voxels between looks at the stop token

void throwIfStopped(const std::stop_token& stop) {
  if (stop.stop_requested()) throw Error(ErrorCode::Cancelled, "The body mask was cancelled.");
}

constexpr std::uint8_t outside = 0, foreground = 1, visited = 2, largest = 3;

// Flood fill from `seed` over voxels equal to `from`, 6-connected; returns the voxels reached.
std::vector<std::int64_t> flood(std::vector<std::uint8_t>& label, const std::array<std::int64_t, 3>& n,
                                std::int64_t seed, const std::stop_token& stop) {
  std::vector<std::int64_t> reached{seed};
  label[seed] = visited;
  for (std::size_t head = 0; head < reached.size(); ++head) {
    if (head % stride == 0) throwIfStopped(stop);
    const std::int64_t p = reached[head], i = p % n[0], j = p / n[0] % n[1], k = p / (n[0] * n[1]);
    const auto visit = [&](bool inside, std::int64_t q) {
      if (inside && label[q] == foreground) {
        label[q] = visited;
        reached.push_back(q);
      }
    };
    visit(i > 0, p - 1);
    visit(i + 1 < n[0], p + 1);
    visit(j > 0, p - n[0]);
    visit(j + 1 < n[1], p + n[0]);
    visit(k > 0, p - n[0] * n[1]);
    visit(k + 1 < n[2], p + n[0] * n[1]);
  }
  return reached;
}

// Sets to 1 whatever the border of the slice cannot reach through zeros.
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
  const double threshold = otsuThreshold(volume.voxels);
  std::vector<std::uint8_t> label(volume.voxels.size());
  for (std::size_t p = 0; p < label.size(); ++p)
    label[p] = volume.voxels[p] > threshold ? foreground : outside;

  std::vector<std::int64_t> best;
  for (std::size_t p = 0; p < label.size(); ++p)
    if (label[p] == foreground) {
      auto component = flood(label, n, static_cast<std::int64_t>(p), stop);
      if (component.size() > best.size()) best.swap(component);
    }
  if (best.empty()) return std::vector<std::uint8_t>(label.size(), 1); // constant image: all of it
  for (std::int64_t p : best)
    label[p] = largest;
  for (std::uint8_t& l : label)
    l = l == largest;
  for (std::int64_t k = 0; k < n[2]; ++k) {
    throwIfStopped(stop);
    fillHoles(label.data() + k * n[0] * n[1], n[0], n[1]);
  }
  return label;
}

} // namespace innergs
