#pragma once
#include <filesystem>
#include <string>

namespace innergs {

struct OpenVinoFunctions;

/// OpenVINO (2025.4 or later), which runs networks in ONNX files, is an optional library: `pip install
/// openvino` is enough. It is looked for in the folder that INNERGS_OPENVINO names (the Python package, its
/// libraries, an environment with it), in the active virtual or conda environment, in the Python of 3D Slicer
/// and where the system looks for libraries.
struct OpenVino {
  const OpenVinoFunctions* functions = nullptr; // null: not found
  std::string version;                          // "2026.4.1-…"
  std::filesystem::path library;
  std::string problem; // one sentence if it was not found or cannot be used
};

/// Loads it at the first call that finds it, in about 0.1 s, and keeps it to the end of the program; looks
/// again at every call until then. Never throws. Any thread.
OpenVino openVino();

} // namespace innergs
