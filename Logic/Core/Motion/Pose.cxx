#include "Core/Motion/Pose.h"

namespace innergs {
namespace {

constexpr std::int64_t kGaussiansPerTask = 1024;

/// The product a ⊗ b of quaternions (w, x, y, z).
void product(const float* a, const float* b, float* c) {
  c[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
  c[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
  c[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
  c[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
}

} // namespace

std::vector<float> nodesAt(const DynamicField& field, double time) {
  const std::size_t count = static_cast<std::size_t>(field.motionGrid.nodes()) * MotionGrid::kValues;
  std::vector<float> values(count, 0.f);
  const TimeSpline::Weights w = field.motion.at(time);
  for (int a = 0; a < w.count; ++a) {
    const float* c = field.nodes.data() + static_cast<std::size_t>(w.first + a) * count;
    for (std::size_t v = 0; v < count; ++v)
      values[v] += w.weight[a] * c[v];
  }
  return values;
}

Poser::Poser(const DynamicField& field) : grid_(field.motionGrid), places_(field.canonical.gaussians.size()) {
  for (std::size_t i = 0; i < places_.size(); ++i)
    places_[i] = grid_.place(field.anchors.data() + 3 * i);
}

/// Needed only by backward().
void Poser::listMembers() {
  if (!first_.empty()) return;
  first_.assign(static_cast<std::size_t>(grid_.nodes()) + 1, 0);
  for (const auto& place : places_)
    for (const std::uint32_t node : grid_.corners(place).node)
      ++first_[node + 1];
  for (std::size_t n = 1; n < first_.size(); ++n)
    first_[n] += first_[n - 1];
  members_.resize(first_.back());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const auto c = grid_.corners(places_[i]);
    for (int n = 0; n < 8; ++n)
      members_[next[c.node[n]]++] = {static_cast<std::uint32_t>(i), c.weight[n]};
  }
}

void Poser::pose(const DynamicField& field, std::span<const float> nodes, std::optional<double> ownTime,
                 GaussianField& out, ThreadPool& pool) const {
  const bool moves = ownTime && !field.ownPath.empty();
  const TimeSpline::Weights own = moves ? field.own.at(*ownTime) : TimeSpline::Weights{};
  const std::size_t stride = 3 * places_.size();
  pool.blocks(static_cast<std::int64_t>(places_.size()), kGaussiansPerTask,
              [&](std::int64_t first, std::int64_t last) {
                for (std::int64_t i = first; i < last; ++i) {
                  const Gaussian& from = field.canonical.gaussians[i];
                  Gaussian& to = out.gaussians[i];
                  to = from;
                  const auto v = grid_.at(places_[i], nodes);
                  for (int a = 0; a < 3; ++a)
                    to.mean[a] += v[a];
                  const float turn[4] = {1, 0.5f * v[3], 0.5f * v[4], 0.5f * v[5]};
                  product(turn, from.quaternion, to.quaternion);
                  if (!moves) continue;
                  for (int k = 0; k < own.count; ++k)
                    for (int a = 0; a < 3; ++a)
                      to.mean[a] +=
                          own.weight[k] *
                          field.ownPath[static_cast<std::size_t>(own.first + k) * stride + 3 * i + a];
                }
              });
}

void Poser::backward(const DynamicField& field, std::span<const float> nodeValues, std::span<float> gradient,
                     std::span<float> nodes, ThreadPool& pool) {
  listMembers();
  nodeGradients_.resize(places_.size() * MotionGrid::kValues);
  pool.blocks(static_cast<std::int64_t>(places_.size()), kGaussiansPerTask,
              [&](std::int64_t first, std::int64_t last) {
                for (std::int64_t i = first; i < last; ++i) {
                  float* g = gradient.data() + 16 * i;
                  float* nodeGradient = nodeGradients_.data() + MotionGrid::kValues * i;
                  const float* q = field.canonical.gaussians[i].quaternion;
                  const float* dq = g + 6; // of turn ⊗ q
                  for (int a = 0; a < 3; ++a)
                    nodeGradient[a] = g[a];
                  nodeGradient[3] = 0.5f * (-q[1] * dq[0] + q[0] * dq[1] - q[3] * dq[2] + q[2] * dq[3]);
                  nodeGradient[4] = 0.5f * (-q[2] * dq[0] + q[3] * dq[1] + q[0] * dq[2] - q[1] * dq[3]);
                  nodeGradient[5] = 0.5f * (-q[3] * dq[0] - q[2] * dq[1] + q[1] * dq[2] + q[0] * dq[3]);
                  const auto v = grid_.at(places_[i], nodeValues);
                  const float back[4] = {1, -0.5f * v[3], -0.5f * v[4], -0.5f * v[5]};
                  float canonical[4];
                  product(back, dq, canonical);
                  for (int a = 0; a < 4; ++a)
                    g[6 + a] = canonical[a];
                }
              });
  pool.blocks(grid_.nodes(), 16, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t n = first; n < last; ++n) {
      float sum[MotionGrid::kValues] = {};
      for (std::uint32_t m = first_[n]; m < first_[n + 1]; ++m) {
        const float* nodeGradient =
            nodeGradients_.data() + static_cast<std::size_t>(members_[m].gaussian) * MotionGrid::kValues;
        for (int v = 0; v < MotionGrid::kValues; ++v)
          sum[v] += members_[m].weight * nodeGradient[v];
      }
      for (int v = 0; v < MotionGrid::kValues; ++v)
        nodes[n * MotionGrid::kValues + v] += sum[v];
    }
  });
}

} // namespace innergs
