// The engine alone, for benchmark_logic.py: seconds from the voxels of a raw file (float, I fastest) to the
// volume. innergs_mrml_engine FILE SIZE_I SIZE_J SIZE_K SPACING_I SPACING_J SPACING_K GAUSSIANS
#include "Core/Job/ReconstructionJob.h"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>

int main(int argc, char** argv) {
  if (argc != 9) return 2;
  innergs::Stack stack;
  for (int a = 0; a < 3; ++a) {
    stack.image.geometry.size[a] = std::atol(argv[2 + a]);
    stack.image.geometry.spacing[a] = std::atof(argv[5 + a]);
  }
  stack.image.voxels.resize(static_cast<std::size_t>(stack.image.geometry.voxelCount()));
  std::ifstream file(argv[1], std::ios::binary);
  file.read(reinterpret_cast<char*>(stack.image.voxels.data()),
            static_cast<std::streamsize>(stack.image.voxels.size() * sizeof(float)));
  if (!file) return 3;
  const auto begun = std::chrono::steady_clock::now();
  innergs::ReconstructionInput input;
  input.stacks.push_back(std::move(stack));
  innergs::Settings settings;
  settings.gaussians = std::atol(argv[8]);
  innergs::ReconstructionJob job(std::move(input), settings);
  job.onPreview([](const innergs::Volume&) {}); // the logic requests them as well
  const innergs::ReconstructionResult result = job.run();
  std::printf("%.6f\n", std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count());
  return result.volume.voxels.empty();
}
