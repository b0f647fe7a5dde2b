#pragma once
#include "Core/Alignment/SliceOperator.h"

namespace innergs {

/// Slices that share one pose.
using Packet = std::vector<PlacedSlice*>;

/// Every `count`-th slice; 0: every slice by itself.
std::vector<Packet> packetsOf(std::vector<PlacedSlice>& slices, int count);

/// Gauss-Newton steps of a packet's pose and its slices' gains (kept unless `scales`) towards a volume on the
/// operator's grid. sigma: of the differences, for Cauchy's weights. pool: null if packets are registered
/// in parallel.
void registerPacket(const Packet& packet, const SliceOperator& op, const std::vector<float>& volume,
                    int steps, double sigma, bool scales, ThreadPool* pool = nullptr);

/// Runs packets of one slice in parallel, else the slices of each packet.
void registerPackets(const std::vector<Packet>& packets, const SliceOperator& op,
                     const std::vector<float>& volume, int steps, double sigma, bool scales,
                     ThreadPool& pool);

} // namespace innergs
