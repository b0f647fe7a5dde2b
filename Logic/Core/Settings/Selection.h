#pragma once

namespace innergs {

/// Which pixels of which slices a Gaussian is evaluated on (any blending). Exact and Method1 (cut-off radius
/// up to 3) cover every pixel that the Gaussian contributes to. Method2 does so while r² ≤ 2 + 2·ln 4.5 (r ≤
/// 2.23; fitted fields use 2.2) and misses some pixels at 3.
enum class Selection {
  Exact,   // the ellipse that the cut-off ellipsoid has in each slice, row by row
  Method1, // 3D ellipsoid projection: a cube of edge 2·3·√λ_max(Σ), the same box on each slice
  Method2  // conditional splatting: on each slice |t − μ_t| ≤ 3√σ_tt a square of half edge
           // 3·√λ_max(Σ_uv|t)·√p(t) around the conditional mean
};
/// "exact", "method1", "method2".
const char* selectionName(Selection selection);

} // namespace innergs
