#include "Core/Alignment/PacketRegistration.h"

#include "Core/Alignment/Rigid.h"
#include "Core/Base/Cholesky.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace innergs {
namespace {

constexpr std::int64_t kFewestPixels = 200;                                // of a slice, to be registered
constexpr double kPriorShift = 6, kPriorTurn = 6 * std::numbers::pi / 180; // mm, radians: σ of the motion
constexpr double kPriorGain = 0.5;                                         // σ of the gain's logarithm

/// Where the header puts the middle of the slice.
Vec3 headerCentre(const PlacedSlice& s) {
  return s.toWorld({0.5 * (s.nx - 1), 0.5 * (s.ny - 1), 0});
}

constexpr int kPoseParameters = 6, kParameters = kPoseParameters + 1; // shift, turn; gain

/// The normal equations of one slice's pose and gain.
struct SliceEquations {
  std::array<double, kParameters * kParameters> hessian{}; // lower triangle
  std::array<double, kParameters> gradient{};
  double cost = 0;
  std::int64_t pixels = 0;
};

SliceEquations equationsOf(const PlacedSlice& slice, const SliceOperator& op,
                           const std::vector<float>& volume, const Vec3& centre, double width, bool scales) {
  SliceEquations sum;
  const SliceOperator::Reader reader(op, volume, slice, slice.pose, centre);
  for (int j = 0; j < slice.ny; ++j)
    for (int i = 0; i < slice.nx; ++i) {
      const float given = slice.values[static_cast<std::size_t>(j) * slice.nx + i];
      SliceOperator::Sample seen;
      if (std::isnan(given) || !reader.at(i, j, seen)) continue;
      const double r = slice.gain * seen.value - given, t = r / width;
      const double weight = 1 / (1 + t * t);
      sum.cost += width * width * std::log1p(t * t);
      ++sum.pixels;
      const double row[kParameters] = {slice.gain * seen.shift[0],          slice.gain * seen.shift[1],
                                       slice.gain * seen.shift[2],          slice.gain * seen.turn[0],
                                       slice.gain * seen.turn[1],           slice.gain * seen.turn[2],
                                       scales ? slice.gain * seen.value : 0};
      for (int a = 0; a < kParameters; ++a) {
        for (int b = 0; b <= a; ++b)
          sum.hessian[a * kParameters + b] += weight * row[a] * row[b];
        sum.gradient[a] -= weight * row[a] * r;
      }
    }
  return sum;
}

/// The normal equations of a packet's pose, then each slice's gain.
struct PacketEquations {
  int size;
  std::vector<double> hessian, gradient; // lower triangle

  explicit PacketEquations(std::size_t slices)
      : size(kPoseParameters + static_cast<int>(slices)), hessian(static_cast<std::size_t>(size) * size),
        gradient(size) {}

  double& at(int a, int b) { return hessian[static_cast<std::size_t>(a) * size + b]; }

  void add(const SliceEquations& slice, std::size_t index, double share) {
    const auto place = [&](int a) { return a < kPoseParameters ? a : a + static_cast<int>(index); };
    for (int a = 0; a < kParameters; ++a) {
      for (int b = 0; b <= a; ++b)
        at(place(a), place(b)) += share * slice.hessian[a * kParameters + b];
      gradient[place(a)] += share * slice.gradient[a];
    }
  }
};

/// The weights of a packet's slices relative to the best of them.
std::vector<double> sharesOf(const Packet& packet) {
  double most = 0;
  for (const PlacedSlice* slice : packet)
    most = std::max(most, slice->weight);
  std::vector<double> shares;
  for (const PlacedSlice* slice : packet)
    shares.push_back(most > 0 ? slice->weight / most : 1);
  return shares;
}

} // namespace

std::vector<Packet> packetsOf(std::vector<PlacedSlice>& slices, int count) {
  const std::size_t most = slices.size();
  std::vector<Packet> packets(count > 0 ? std::min<std::size_t>(count, most) : most);
  for (std::size_t k = 0; k < most; ++k)
    packets[k % packets.size()].push_back(&slices[k]);
  return packets;
}

void registerPacket(const Packet& packet, const SliceOperator& op, const std::vector<float>& volume,
                    int steps, double sigma, bool scales, ThreadPool* pool) {
  const double width = 2.385 * sigma; // 95 % as good as least squares where the differences are Gaussian
  const double spread = sigma * sigma * 10; // pixels are not independent
  const std::size_t count = packet.size();
  const std::vector<double> shares = sharesOf(packet);
  std::vector<PlacedSlice> moved;
  Vec3 centre{};
  std::int64_t observed = 0;
  for (const PlacedSlice* slice : packet) {
    moved.push_back(*slice);
    centre = centre + (1 / static_cast<double>(count)) * headerCentre(*slice);
    observed += slice->observed;
  }
  double best = std::numeric_limits<double>::infinity();
  double damping = 1e-3;
  PacketEquations equations(count);
  std::vector<SliceEquations> parts(count);
  for (int step = 0; step <= 2 * steps; ++step) {
    const Affine3 pose = moved.front().pose;
    const auto look = [&](std::int64_t n) {
      parts[n] = equationsOf(moved[n], op, volume, pose(centre), width, scales);
    };
    if (pool)
      pool->run(static_cast<std::int64_t>(count), look);
    else
      for (std::size_t n = 0; n < count; ++n)
        look(static_cast<std::int64_t>(n));
    PacketEquations sum(count);
    double cost = 0, expected = 0, compared = 0;
    std::int64_t pixels = 0;
    for (std::size_t n = 0; n < count; ++n) {
      sum.add(parts[n], n, shares[n]);
      cost += shares[n] * parts[n].cost;
      expected += shares[n] * static_cast<double>(moved[n].observed);
      compared += shares[n] * static_cast<double>(parts[n].pixels);
      pixels += parts[n].pixels;
    }
    if (pixels < std::clamp<std::int64_t>(observed / 2, 1, kFewestPixels) || !(compared > 0)) return;
    cost *= expected / compared;
    // The prior: no motion from where the header puts it.
    const Vec3 turned = rotationVector(pose.linear);
    const Vec3 shifted = pose(centre) - centre;
    cost += spread * (dot(shifted, shifted) / (kPriorShift * kPriorShift) +
                      dot(turned, turned) / (kPriorTurn * kPriorTurn));
    // And no gain, or the values of a nearly empty slice would take any.
    const double gainPrior = scales ? spread / (kPriorGain * kPriorGain) : 0;
    for (const PlacedSlice& slice : moved)
      cost += gainPrior * std::log(slice.gain) * std::log(slice.gain);
    if (cost < best) {
      best = cost;
      for (std::size_t n = 0; n < count; ++n) {
        packet[n]->pose = pose;
        packet[n]->gain = moved[n].gain;
      }
      damping = std::max(1e-4, 0.2 * damping);
      for (int a = 0; a < 3; ++a) {
        sum.at(a, a) += spread / (kPriorShift * kPriorShift);
        sum.gradient[a] -= spread * shifted[a] / (kPriorShift * kPriorShift);
        sum.at(3 + a, 3 + a) += spread / (kPriorTurn * kPriorTurn);
        sum.gradient[3 + a] -= spread * turned[a] / (kPriorTurn * kPriorTurn);
      }
      for (int n = 0; n < static_cast<int>(count); ++n) {
        const int a = kPoseParameters + n;
        sum.at(a, a) += gainPrior;
        sum.gradient[a] -= gainPrior * std::log(moved[n].gain);
      }
      equations = std::move(sum);
    } else {
      damping *= 10;
    }
    if (step == 2 * steps || damping > 10) break;
    PacketEquations solved = equations;
    for (int d = 0; d < solved.size; ++d) {
      double& diagonal = solved.at(d, d);
      diagonal = diagonal > 0 ? diagonal * (1 + damping) : 1;
    }
    std::vector<double>& b = solved.gradient;
    solveCholesky(solved.hessian, b, solved.size, 1);
    if (!std::all_of(b.begin(), b.end(), [](double x) { return std::isfinite(x); })) break;
    const Vec3 shift{b[0], b[1], b[2]}, turn{b[3], b[4], b[5]};
    if (norm(shift) < 1e-3 && norm(turn) < 2e-5 &&
        std::all_of(b.begin() + kPoseParameters, b.end(), [](double x) { return std::abs(x) < 1e-4; }))
      break;
    const Affine3 next = rigidAbout(packet.front()->pose(centre), turn, shift) * packet.front()->pose;
    for (std::size_t n = 0; n < count; ++n) {
      moved[n].pose = next;
      moved[n].gain = packet[n]->gain * std::exp(std::clamp(b[kPoseParameters + n], -0.2, 0.2));
    }
  }
}

void registerPackets(const std::vector<Packet>& packets, const SliceOperator& op,
                     const std::vector<float>& volume, int steps, double sigma, bool scales,
                     ThreadPool& pool) {
  if (packets.front().size() > 1) {
    for (const Packet& packet : packets)
      registerPacket(packet, op, volume, steps, sigma, scales, &pool);
    return;
  }
  pool.run(static_cast<std::int64_t>(packets.size()),
           [&](std::int64_t n) { registerPacket(packets[n], op, volume, steps, sigma, scales); });
}

} // namespace innergs
