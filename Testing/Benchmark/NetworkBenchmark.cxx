#include "Microbenchmarks.h"

#include "Core/Base/Random.h"
#include "Core/Prediction/ConvolutionNetwork.h"

namespace innergs::bench {
namespace {

constexpr int kSlices = 24, kColumns = 48, kPhases = 4, kLayers = 4; // of a training pair

/// A pass over a training pair, or with its gradients. Items: samples.
void networkPass(benchmark::State& state, const NetworkKernels& kernels, int channels, bool backward) {
  const ConvolutionNetwork network({kPhases, channels, kLayers}, 1);
  const ConvolutionNetwork::Transforms transforms = network.transforms();
  Random random(1);
  std::vector<float> low(std::size_t{kSlices} * kColumns);
  for (float& v : low)
    v = static_cast<float>(random.uniform());
  PatchFeatures features;
  makeFeatures(low.data(), kSlices, kColumns, 0.1f, features);
  ConvolutionNetwork::Workspace work;
  network.forward(features, transforms, kernels, work);
  std::vector<float> byOutput(work.outputs.size(), 0.f), gradient(network.parameters().size(), 0.f);
  for (int s = 0; s < kSlices; ++s)
    for (int c = 0; c < kColumns; ++c)
      byOutput[features.at(s, c) * outputStride(kPhases)] = 1;
  for (auto _ : state) {
    if (backward)
      network.backward(features, byOutput, transforms, kernels, work, gradient);
    else
      network.forward(features, transforms, kernels, work);
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * kSlices * kColumns);
}

} // namespace

void registerNetworkBenchmarks() {
  for (const NetworkKernels& set : networkKernelSets())
    for (const int channels : {16, 32})
      for (const bool backward : {false, true})
        steady(benchmark::RegisterBenchmark(((backward ? "network_backward/" : "network_forward/") +
                                             set.name + "/" + std::to_string(channels))
                                                .c_str(),
                                            networkPass, set, channels, backward));
}

} // namespace innergs::bench
