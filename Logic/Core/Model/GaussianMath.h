#pragma once
#include <cmath>

#if defined(__CUDACC__)
#define INNERGS_HD __host__ __device__
#else
#define INNERGS_HD
#endif

/// The mathematics of one Gaussian, shared by every backend. 3×3 matrices are row-major T[9], symmetric ones
/// T[6] = xx xy xz yy yz zz.
namespace innergs::math {

/// std::min, std::max and std::clamp by value, for host and device.
template <class T>
INNERGS_HD inline T least(T a, T b) {
  return b < a ? b : a;
}
template <class T>
INNERGS_HD inline T most(T a, T b) {
  return a < b ? b : a;
}
template <class T>
INNERGS_HD inline T clamped(T x, T low, T high) {
  return x < low ? low : high < x ? high : x;
}

/// a·b, rounded. Device compilers may fuse a product with a nearby sum, so two kernels could disagree about
/// which rows a Gaussian reaches.
INNERGS_HD inline float product(float a, float b) {
#if defined(__CUDA_ARCH__)
  return __fmul_rn(a, b);
#else
  return a * b;
#endif
}

/// √x to a few units in the last place, for x ≥ 0.
INNERGS_HD inline float roughSqrt(float x) {
#if defined(__CUDA_ARCH__)
  float root;
  asm("sqrt.approx.ftz.f32 %0, %1;" : "=f"(root) : "f"(x));
  return root;
#else
  return std::sqrt(x);
#endif
}

/// 2^x, provided that the result is a normal float.
INNERGS_HD inline float exp2Normal(float x) {
#if defined(__CUDA_ARCH__)
  float power; // 2 units in the last place, like exp2f, which also checks for denormal results
  asm("ex2.approx.ftz.f32 %0, %1;" : "=f"(power) : "f"(x));
  return power;
#else
  return std::exp2(x);
#endif
}

template <class T>
INNERGS_HD inline void multiply(const T* a, const T* b, T* c) { // c = a·b
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      c[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
}

template <class T>
INNERGS_HD inline void transposed(const T* a, T* t) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      t[3 * i + j] = a[3 * j + i];
}

/// s = a·aᵀ as a symmetric matrix.
template <class T>
INNERGS_HD inline void outer(const T* a, T* s) {
  int n = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j)
      s[n++] = a[3 * i] * a[3 * j] + a[3 * i + 1] * a[3 * j + 1] + a[3 * i + 2] * a[3 * j + 2];
}

/// Inverse of a symmetric positive definite matrix; returns its determinant.
template <class T>
INNERGS_HD inline T invertSymmetric(const T* s, T* r) {
  const T a = s[3] * s[5] - s[4] * s[4], b = s[2] * s[4] - s[1] * s[5], c = s[1] * s[4] - s[2] * s[3];
  const T det = s[0] * a + s[1] * b + s[2] * c, k = T(1) / det;
  r[0] = a * k;
  r[1] = b * k;
  r[2] = c * k;
  r[3] = (s[0] * s[5] - s[2] * s[2]) * k;
  r[4] = (s[1] * s[2] - s[0] * s[4]) * k;
  r[5] = (s[0] * s[3] - s[1] * s[1]) * k;
  return det;
}

/// Largest eigenvalue of a symmetric positive semi-definite matrix (trigonometric solution of the cubic).
template <class T>
INNERGS_HD inline T largestEigenvalue(const T* s) {
  const T mean = (s[0] + s[3] + s[5]) / 3, a = s[0] - mean, b = s[3] - mean, c = s[5] - mean;
  const T off = s[1] * s[1] + s[2] * s[2] + s[4] * s[4];
  const T scale = std::sqrt((a * a + b * b + c * c + 2 * off) / 6);
  if (!(scale > 0)) return mean;
  const T det = a * (b * c - s[4] * s[4]) - s[1] * (s[1] * c - s[4] * s[2]) + s[2] * (s[1] * s[4] - b * s[2]);
  const T r = det / (2 * scale * scale * scale);
  return mean + 2 * scale * std::cos(std::acos(r < -1 ? T(-1) : r > 1 ? T(1) : r) / 3);
}

/// Rotation matrix of the quaternion q = (w, x, y, z) of any non-zero length.
template <class T>
INNERGS_HD inline void rotation(const T* q, T* r) {
  const T n = T(1) / std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const T w = q[0] * n, x = q[1] * n, y = q[2] * n, z = q[3] * n;
  r[0] = 1 - 2 * (y * y + z * z), r[1] = 2 * (x * y - w * z), r[2] = 2 * (x * z + w * y);
  r[3] = 2 * (x * y + w * z), r[4] = 1 - 2 * (x * x + z * z), r[5] = 2 * (y * z - w * x);
  r[6] = 2 * (x * z - w * y), r[7] = 2 * (y * z + w * x), r[8] = 1 - 2 * (x * x + y * y);
}

/// The slice-conditional factorisation (paper, Eq. for p(u,v,t) = p(u,v|t)·p(t)) of a covariance in slice
/// coordinates (u, v, t).
template <class T>
struct SliceConditional {
  T shift[2];      // conditional mean = μ_uv + shift·(t − μ_t)
  T covariance[3]; // uu uv vv of Σ_uv − σσᵀ/σ_tt (Schur complement)
  T variance;      // σ_tt
};

template <class T>
INNERGS_HD inline SliceConditional<T> sliceConditional(const T* s) {
  SliceConditional<T> c;
  c.variance = s[5];
  c.shift[0] = s[2] / s[5];
  c.shift[1] = s[4] / s[5];
  c.covariance[0] = s[0] - s[2] * c.shift[0];
  c.covariance[1] = s[1] - s[2] * c.shift[1];
  c.covariance[2] = s[3] - s[4] * c.shift[1];
  return c;
}

/// The same factorisation applied twice to a precision matrix P, for evaluation by rows:
/// dᵀPd = Pxx(dx + l1·dy + l2·dz)² + b(dy + l3·dz)² + dz²/Σzz.
template <class T>
struct RowForm {
  T pxx, l1, l2, b, l3;
};

template <class T>
INNERGS_HD inline RowForm<T> rowForm(const T* p) {
  RowForm<T> f;
  f.pxx = p[0];
  f.l1 = p[1] / p[0];
  f.l2 = p[2] / p[0];
  f.b = p[3] - p[1] * f.l1;
  f.l3 = (p[4] - p[1] * f.l2) / f.b;
  return f;
}

/// Sums over the voxels x of one Gaussian's ellipsoid, with d = x − mean, q = w·p and q′ = w·(p − p_cut); f
/// and F0 as in Docs/method.md: dL/dI passed to the numerator (F0) and to both numerator and denominator (f).
template <class T>
struct Moments {
  T m0 = 0;     // Σ f q′
  T m1[3] = {}; // Σ f q d
  T m2[6] = {}; // Σ f q ddᵀ
  T n0 = 0;     // Σ F0 q′
  T n1[3] = {}; // Σ F0 q′ d
};

/// The part of the moments that one plane of an alpha-blended slice contributes; dz is constant on it. f =
/// ∂L/∂a, q = a + its cut, d = (dx, dy) in index units.
template <class T>
struct PlaneMoments {
  T m0 = 0, n0 = 0;         // Σ f a, ∂L/∂c
  T s = 0, x = 0, y = 0;    // Σ f q, Σ f q d
  T xx = 0, xy = 0, yy = 0; // Σ f q ddᵀ
};

template <class T>
INNERGS_HD inline void addPlane(const PlaneMoments<T>& p, T dz, Moments<T>& m) {
  m.m0 += p.m0;
  m.n0 += p.n0;
  m.m1[0] += p.x;
  m.m1[1] += p.y;
  m.m1[2] += p.s * dz;
  m.m2[0] += p.xx;
  m.m2[1] += p.xy;
  m.m2[2] += p.x * dz;
  m.m2[3] += p.yy;
  m.m2[4] += p.y * dz;
  m.m2[5] += p.s * dz * dz;
}

/// Converts moments over index coordinates to moments over the model frame; a = d(model)/d(index).
template <class T>
INNERGS_HD inline Moments<T> transformMoments(const Moments<T>& in, const T* a) {
  Moments<T> out;
  out.m0 = in.m0;
  out.n0 = in.n0;
  const T full[9] = {in.m2[0], in.m2[1], in.m2[2], in.m2[1], in.m2[3],
                     in.m2[4], in.m2[2], in.m2[4], in.m2[5]};
  T am[9];
  multiply(a, full, am);
  int n = 0;
  for (int i = 0; i < 3; ++i) {
    out.m1[i] = a[3 * i] * in.m1[0] + a[3 * i + 1] * in.m1[1] + a[3 * i + 2] * in.m1[2];
    out.n1[i] = a[3 * i] * in.n1[0] + a[3 * i + 1] * in.n1[1] + a[3 * i + 2] * in.n1[2];
    for (int j = i; j < 3; ++j)
      out.m2[n++] = am[3 * i] * a[3 * j] + am[3 * i + 1] * a[3 * j + 1] + am[3 * i + 2] * a[3 * j + 2];
  }
  return out;
}

/// ∂(log s) and ∂q from G = ∂L/∂P, P = R·D·Rᵀ, D = diag(e^(−2·logScale)). With M = RᵀGR, a turn by ω about
/// the Gaussian's own axes changes P by R([ω]D − D[ω])Rᵀ, so ∂L/∂ω₀ = 2·M₁₂(D₁ − D₂) and so on. That is
/// exactly 0 between axes of equal length, however a compiler rounds; Adam would turn what remains of
/// cancelled sums into full steps.
template <class T>
INNERGS_HD inline void precisionGradient(const T* g6, const T* logScale, const T* quaternion, T* dLogScale,
                                         T* dQuaternion) {
  T r[9], gr[9], d[3];
  rotation(quaternion, r);
  const T g[9] = {g6[0], g6[1], g6[2], g6[1], g6[3], g6[4], g6[2], g6[4], g6[5]};
  multiply(g, r, gr);
  const auto m = [&](int i, int j) { return r[i] * gr[j] + r[3 + i] * gr[3 + j] + r[6 + i] * gr[6 + j]; };
  for (int k = 0; k < 3; ++k) {
    d[k] = std::exp(-2 * logScale[k]);
    dLogScale[k] = -2 * d[k] * m(k, k);
  }
  const T torque[3] = {2 * m(1, 2) * (d[1] - d[2]), 2 * m(0, 2) * (d[2] - d[0]), 2 * m(0, 1) * (d[0] - d[1])};
  // q changes by ½·q·(0, ω), of length ½|ω||q|.
  const T* q = quaternion;
  const T n = 2 / (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  dQuaternion[0] = n * (-q[1] * torque[0] - q[2] * torque[1] - q[3] * torque[2]);
  dQuaternion[1] = n * (q[0] * torque[0] - q[3] * torque[1] + q[2] * torque[2]);
  dQuaternion[2] = n * (q[3] * torque[0] + q[0] * torque[1] - q[1] * torque[2]);
  dQuaternion[3] = n * (-q[2] * torque[0] + q[1] * torque[1] + q[0] * torque[2]);
}

} // namespace innergs::math
