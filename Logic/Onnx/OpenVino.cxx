#include "Onnx/OpenVino.h"

#include "Core/Base/PathText.h"
#include "Core/Base/SharedLibrary.h"
#include "Onnx/OpenVinoFunctions.h"

#include <algorithm>
#include <cstdlib>
#include <mutex>
#include <optional>
#include <vector>

namespace innergs {
namespace {

namespace fs = std::filesystem;

constexpr int kOldestYear = 2025, kOldestRelease = 4;

std::vector<fs::path> entriesOf(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code none;
  for (fs::directory_iterator it(folder, none), end; !none && it != end; it.increment(none))
    entries.push_back(it->path());
  std::sort(entries.begin(), entries.end());
  return entries;
}

/// "libopenvino_c.so.2641", "libopenvino_c.2641.dylib", "openvino_c.dll"; of several the last.
std::optional<fs::path> libraryIn(const fs::path& folder) {
  std::optional<fs::path> found;
  for (const fs::path& file : entriesOf(folder)) {
    const std::string name = utf8(file.filename());
    if ((name.starts_with("libopenvino_c.") || name == "openvino_c.dll") &&
        (name.find(".so") != std::string::npos || name.ends_with(".dylib") || name.ends_with(".dll")))
      found = file;
  }
  return found;
}

std::vector<fs::path> foldersBelow(const fs::path& given) {
  std::vector<fs::path> folders;
  for (const char* below : {"", "libs", "openvino/libs", "lib", "runtime/lib/intel64",
                            "runtime/lib/arm64/Release", "runtime/bin/intel64/Release"})
    folders.push_back(given / below);
  return folders;
}

/// Where pip installs packages for a Python whose prefix is given.
std::vector<fs::path> packagesOf(const fs::path& prefix) {
  std::vector<fs::path> folders{prefix / "Lib/site-packages/openvino/libs"};
  for (const char* library : {"lib", "lib64"})
    for (const fs::path& python : entriesOf(prefix / library))
      if (utf8(python.filename()).starts_with("python"))
        folders.push_back(python / "site-packages/openvino/libs");
  return folders;
}

struct Search {
  std::vector<fs::path> files;
  std::string given; // INNERGS_OPENVINO; "": not set
};

Search search() {
  Search result;
  std::vector<fs::path> folders;
  const auto add = [&](const std::vector<fs::path>& more) {
    folders.insert(folders.end(), more.begin(), more.end());
  };
  if (const char* given = std::getenv("INNERGS_OPENVINO"); given && *given) {
    result.given = given;
    const fs::path folder = result.given;
    add(foldersBelow(folder));
    add(packagesOf(folder));
  } else {
    for (const char* environment : {"VIRTUAL_ENV", "CONDA_PREFIX", "PYTHONHOME"})
      if (const char* prefix = std::getenv(environment); prefix && *prefix) add(packagesOf(prefix));
    for (const fs::path& beside : programFolders()) { // 3D Slicer's Python, from its bin or an extension
      folders.push_back(beside);
      for (fs::path up = beside; up.has_relative_path(); up = up.parent_path())
        add(packagesOf(up / "lib/Python"));
    }
  }
  for (const fs::path& folder : folders)
    if (const auto file = libraryIn(folder)) result.files.push_back(*file);
  if (result.given.empty()) result.files.emplace_back(sharedLibraryName("openvino_c")); // the system's
  return result;
}

template <class Function>
bool bind(void* library, const char* name, Function& function) {
  function = reinterpret_cast<Function>(sharedSymbol(library, name));
  return function != nullptr;
}

bool bindAll(void* library, OpenVinoFunctions& f) {
  bool all = true;
#define INNERGS_BIND(name) all = bind(library, "ov_" #name, f.name) && all
  INNERGS_BIND(get_openvino_version);
  INNERGS_BIND(version_free);
  INNERGS_BIND(core_create);
  INNERGS_BIND(core_free);
  INNERGS_BIND(core_read_model);
  INNERGS_BIND(core_compile_model);
  INNERGS_BIND(model_free);
  INNERGS_BIND(compiled_model_free);
  INNERGS_BIND(compiled_model_inputs_size);
  INNERGS_BIND(compiled_model_outputs_size);
  INNERGS_BIND(compiled_model_input_by_index);
  INNERGS_BIND(compiled_model_output_by_index);
  INNERGS_BIND(compiled_model_create_infer_request);
  INNERGS_BIND(port_get_any_name);
  INNERGS_BIND(port_get_partial_shape);
  INNERGS_BIND(port_get_element_type);
  INNERGS_BIND(output_const_port_free);
  INNERGS_BIND(partial_shape_free);
  INNERGS_BIND(tensor_create);
  INNERGS_BIND(tensor_get_shape);
  INNERGS_BIND(tensor_get_element_type);
  INNERGS_BIND(tensor_data);
  INNERGS_BIND(tensor_free);
  INNERGS_BIND(shape_free);
  INNERGS_BIND(infer_request_set_input_tensor_by_index);
  INNERGS_BIND(infer_request_get_output_tensor_by_index);
  INNERGS_BIND(infer_request_infer);
  INNERGS_BIND(infer_request_free);
  INNERGS_BIND(free);
#undef INNERGS_BIND
  return all;
}

/// "2026.4.1-…": whether it is one whose interface is known.
bool isRecent(const std::string& version) {
  const std::size_t dot = version.find('.');
  if (dot == std::string::npos) return false;
  const int year = std::atoi(version.c_str()), release = std::atoi(version.c_str() + dot + 1);
  return year > kOldestYear || (year == kOldestYear && release >= kOldestRelease);
}

OpenVino load() {
  static OpenVinoFunctions functions;
  OpenVino found;
  const Search where = search();
  for (const fs::path& file : where.files) {
    std::string why;
    void* library = openSharedLibrary(file, why);
    if (!library) {
      if (file.has_parent_path()) found.problem = "OpenVINO's " + utf8(file) + " cannot be loaded: " + why;
      continue;
    }
    if (!bindAll(library, functions)) {
      found.problem = utf8(file) + " is not a known version of OpenVINO: install 2025.4 or later.";
      continue;
    }
    OpenVinoFunctions::Version version{};
    if (functions.get_openvino_version(&version) == 0 && version.build) found.version = version.build;
    functions.version_free(&version);
    if (!isRecent(found.version)) {
      found.problem = "OpenVINO " + found.version + " is too old: install 2025.4 or later.";
      continue;
    }
    found.functions = &functions;
    found.library = file;
    found.problem.clear();
    return found;
  }
  if (found.problem.empty())
    found.problem =
        where.given.empty()
            ? "OpenVINO, which runs networks, was not found: install it with 'pip install openvino' and give "
              "the folder of that package in INNERGS_OPENVINO."
            : "There is no OpenVINO in the folder '" + where.given +
                  "' that INNERGS_OPENVINO names: give the folder of the Python package openvino.";
  return found;
}

} // namespace

OpenVino openVino() {
  static std::mutex mutex;
  static OpenVino loaded;
  const std::lock_guard lock(mutex);
  if (!loaded.functions) {
    try {
      loaded = load();
    } catch (const std::exception& error) {
      loaded = {};
      loaded.problem = std::string("OpenVINO cannot be searched for: ") + error.what();
    }
  }
  return loaded;
}

} // namespace innergs
