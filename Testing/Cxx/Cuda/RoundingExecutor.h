#pragma once
#include "Cuda/HostExecutor.h"
#include "RunOnHost.h"

#include <type_traits>

namespace innergs::cuda {

/// Rounds differently from the CPU, like a device: changes a few of the last bits of the kernels' results.
struct Rounding {
  static constexpr float kUlp = 1.2e-7f;
  inline static std::uint32_t random = 1;

  static float next() { // -1 to 1
    random = random * 1664525u + 1013904223u;
    return static_cast<float>(random >> 8) / (1 << 23) - 1;
  }
  static void change(float* x, std::int64_t count, float share) {
    for (std::int64_t i = 0; i < count; ++i)
      x[i] *= 1 + share * next();
  }
  static void change(Pair* x, const GridView& grid) {
    for (std::int64_t row = 0; row < static_cast<std::int64_t>(grid.nz) * grid.ny; ++row)
      change(&x[row * grid.stride].a, 2 * grid.nx, 3 * kUlp);
  }

  template <class Kernel>
  static void run(const Kernel& kernel, std::int64_t blocks) {
    runOnHost(kernel, blocks);
    if constexpr (std::is_same_v<Kernel, Project>) {
      for (std::int64_t i = 0; i < kernel.count; ++i) {
        Projected& p = kernel.out[i];
        change(p.quadratic, 6, 4 * kUlp);
        change(p.slope, 3, 4 * kUlp);
        change(&p.log2Weight, 1, kUlp);
      }
    } else if constexpr (std::is_same_v<Kernel, Accumulate>) {
      change(kernel.out, kernel.bricks.grid);
    } else if constexpr (std::is_same_v<Kernel, Composite>) {
      change(kernel.out, kernel.tile.tiles.grid);
    } else if constexpr (std::is_same_v<Kernel, Gather> || std::is_same_v<Kernel, SumSlots>) {
      for (std::int64_t i = 0; i < kernel.count; ++i)
        change(&kernel.out[i].m0, 14, 8 * kUlp);
    } else if constexpr (std::is_same_v<Kernel, Chain>) {
      change(kernel.gradient, 16 * kernel.count, 8 * kUlp);
    } else if constexpr (std::is_same_v<Kernel, Update>) {
      change(reinterpret_cast<float*>(kernel.gaussians), 16 * kernel.count, kUlp);
    } else if constexpr (std::is_same_v<Kernel, Densify>) {
      change(reinterpret_cast<float*>(kernel.added), 16 * kernel.chosen, kUlp);
    } else if constexpr (std::is_same_v<Kernel, Relocate>) {
      for (std::int64_t k = 0; k < kernel.count; ++k)
        change(reinterpret_cast<float*>(kernel.gaussians + kernel.replaced[k]), 16, kUlp);
    } else if constexpr (std::is_same_v<Kernel, RelocationKeys>) {
      for (std::int64_t i = 0; i < kernel.count; ++i)
        if (kernel.priority[i] > 1 && kernel.priority[i] < 0xfffffffeu)
          kernel.priority[i] += static_cast<std::int64_t>(1.5f * next());
    }
  }
};

} // namespace innergs::cuda
