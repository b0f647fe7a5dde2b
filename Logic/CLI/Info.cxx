#include "CLI/Command.h"
#include "CLI/Options.h"
#include "CLI/ReconstructReport.h"
#include "CLI/Version.h"

#include "Core/Acquisition/SliceOrder.h"
#include "Core/Base/SystemMemory.h"
#include "Core/Device/DevicePlugin.h"
#include "Core/Device/Devices.h"
#include "Core/Image/Orientation.h"
#include "Core/Job/JobInput.h"
#include "Core/Render/Render.h"
#include "IO/DicomSeries.h"
#include "IO/DynamicModelFile.h"
#include "IO/FilePath.h"
#include "IO/ImageReading.h"
#include "IO/ModelFile.h"
#include "IO/Ply.h"
#include "IO/TrackedSweep.h"
#include "Onnx/OpenVino.h"
#include "Text/SentenceEncoder.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <thread>

namespace innergs::cli {
namespace {

using Json = nlohmann::ordered_json;

// A grid's position in both frames.
Json placed(const GridGeometry& geometry) {
  Json info = toJson(geometry);
  const Frame ras{true};
  info["origin_mm_ras"] = ras.turned(geometry.origin);
  info["centre_mm_lps"] = geometry.centre();
  info["centre_mm_ras"] = ras.turned(geometry.centre());
  return info;
}

Json programInfo() {
  Json info = versions();
  info["instruction_sets"] = instructionSets();
  const DeviceList list = otherDevices();
  if (list.devices.empty()) info["devices"] = "CPU only. " + list.problem;
  for (std::size_t n = 0; n < list.devices.size(); ++n) {
    const DeviceInfo& device = list.devices[n];
    info["devices"]["cuda:" + std::to_string(n)] = {{"name", device.name},
                                                    {"compute_capability", device.computeCapability},
                                                    {"memory_bytes", device.totalMemory},
                                                    {"free_memory_bytes", device.freeMemory}};
    if (!device.refused.empty()) info["devices"]["cuda:" + std::to_string(n)]["refused"] = device.refused;
  }
  const OpenVino networks = openVino();
  info["networks"] =
      networks.functions ? "OpenVINO " + networks.version + ", " + utf8(networks.library) : networks.problem;
  const SentenceModel sentences = sentenceModel();
  info["sentence_embedding"] = sentences.embedding ? "loaded" : sentences.problem;
  info["threads"] = std::thread::hardware_concurrency();
  info["available_memory_bytes"] = availableMemory() > 0 ? Json(availableMemory()) : Json();
  return info;
}

Json fieldInfo(const GaussianField& field) {
  Json info{{"kind", "gaussians"},
            {"gaussians", field.size()},
            {"blending", blendingName(field.blending)},
            {"linear_intensity", field.linearIntensity},
            {"cutoff", field.cutoff},
            {"residual_grid", !field.residual.voxels.empty()},
            {"intensity_scale", field.intensityScale},
            {"intensity_offset", field.intensityOffset}};
  if (field.range) info["value_range"] = {field.range->low, field.range->high};
  if (!field.support.voxels.empty()) {
    info["mask"] = placed(field.support.geometry);
    info["mask"]["voxels"] = std::count(field.support.voxels.begin(), field.support.voxels.end(), 1);
    info["fill_value"] = field.fill;
  }
  info["domain"] = placed(field.domain);
  info["domain"]["axes_grow_towards"] = orientationCode(field.domain.direction);
  return info;
}

Json staticInfo(const Model& model, const FeatureModel* features, const std::filesystem::path& path) {
  Json info = fieldInfo(model.field);
  if (isPly(path)) return info;
  info["kind"] = "model";
  info["fit_complete"] = model.complete();
  info["iteration"] = model.iteration;
  if (features) {
    info["features"]["channels"] = features->channels;
    info["features"]["classes"] =
        std::vector<std::string>(features->names.begin() + 1, features->names.end());
  }
  return info;
}

Json dynamicInfo(const DynamicField& field) {
  Json info = fieldInfo(field.canonical);
  info["kind"] = "model of a dynamic scan";
  info["changes_by"] = dynamicKindName(field.kind);
  info["frames"] = field.times.size();
  info["first_time_s"] = field.times.front();
  info["last_time_s"] = field.times.back();
  info["coefficients_in_time"] = coefficientsInTime(field);
  return info;
}

Json modelInfo(const std::filesystem::path& path) {
  const AnyModel read = readAnyModel(path);
  Json info = read.field ? dynamicInfo(*read.field) : staticInfo(*read.model, read.features.get(), path);
  if (!read.notes.empty()) info["notes"] = read.notes;
  return info;
}

Json seriesInfo(const std::vector<DicomEntry>& entries) {
  Json info{{"kind", "DICOM folder"}};
  for (std::size_t n = 0; n < entries.size(); ++n) {
    const DicomEntry& entry = entries[n];
    Json& series = info["series"][std::to_string(n + 1)];
    series = {{"description", entry.description},
              {"images", entry.images},
              {"size", entry.size},
              {"plane", entry.plane},
              {"tilt_degrees", std::round(10 * entry.tilt) / 10},
              {"slice_thickness_mm", entry.thickness > 0 ? Json(entry.thickness) : Json()}};
    if (!entry.detail.empty()) series["detail"] = entry.detail;
  }
  return info;
}

/// Where the slices lie that do not lie on one grid.
void addPoses(Json& info, const LoadedImage& image, const std::filesystem::path& path,
              const ReadOptions& options) {
  std::vector<std::string> remarks = image.remarks;
  if (!image.poses.empty()) {
    info["slices_with_poses"] = image.poses.size();
  } else if (image.tracked) {
    info["tracked_sweep"] = true;
    const NamedTransforms calibration =
        options.calibration.empty() ? NamedTransforms{} : readCalibration(options.calibration);
    const std::string what = innergs::quoted(path);
    if (std::string why = whyNotPlaced(image.sweepFields, calibration, what); !why.empty()) {
      remarks.push_back(std::move(why));
    } else {
      const Stack stack = placedSweep(image.volume, image.sweepFields, calibration, what);
      const Vec3& s = stack.image.geometry.spacing;
      info["slices_with_poses"] = stack.poses.size();
      info["pixel_size_mm"] = {s[0], s[1]};
      info["usual_slice_distance_mm"] = s[2];
      info["box_of_slices"] = placed(dataDomain({&stack, 1}));
      remarks = stack.remarks;
    }
  }
  if (!remarks.empty()) info["remarks"] = remarks;
}

Json imageInfo(const std::filesystem::path& path, ReadOptions options) {
  if (std::filesystem::is_directory(path) && !options.series)
    if (const auto entries = listDicomSeries(path); entries.size() > 1) return seriesInfo(entries);
  if (!options.frame) options.frame = 0;
  const LoadedImage image = loadImage(path, options);
  const Volume& volume = image.volume;
  std::int64_t finite = 0;
  double low = INFINITY, high = -INFINITY, sum = 0;
  for (const float v : volume.voxels) {
    if (!std::isfinite(v)) continue;
    ++finite;
    low = std::min<double>(low, v);
    high = std::max<double>(high, v);
    sum += v;
  }
  Json info{{"kind", "image"}};
  info.update(placed(volume.geometry));
  info["axes_grow_towards"] = orientationCode(volume.geometry.direction);
  info["left_handed"] = determinant(volume.geometry.direction) < 0;
  if (image.sliceThickness > 0) {
    info["slice_thickness_mm"] = image.sliceThickness;
    info["slice_thickness_from"] = image.thicknessFrom;
  }
  if (!image.sliceTimes.empty()) {
    info["slices_acquired"] = sliceOrderText(image.sliceTimes);
    if (const int passes = interleavedPasses(image.sliceTimes); passes > 1)
      info["interleaved_passes"] = passes;
  }
  if (image.frames > 1) {
    info["frames"] = image.frames;
    info["shown_frame"] = *options.frame;
  }
  addPoses(info, image, path, options);
  info["minimum"] = finite ? Json(low) : Json();
  info["maximum"] = finite ? Json(high) : Json();
  info["mean"] = finite ? Json(sum / finite) : Json();
  info["non_finite_voxels"] = static_cast<std::int64_t>(volume.voxels.size()) - finite;
  return info;
}

std::string plain(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_null()) return "unknown";
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_number_float()) return fmt::format("{:g}", value.get<double>() + 0.0); // avoids "-0"
  if (!value.is_array()) return value.dump();
  std::string text;
  for (const auto& item : value)
    text += (text.empty() ? "" : ", ") + (item.is_array() ? "(" + plain(item) + ")" : plain(item));
  return text;
}

void printPlain(const Json& info, const std::string& indent = "") {
  for (const auto& [key, value] : info.items()) {
    std::string label = key;
    std::replace(label.begin(), label.end(), '_', ' ');
    if (value.is_object()) {
      std::cout << indent << label << ":\n";
      printPlain(value, indent + "  ");
    } else {
      std::cout << indent << fmt::format("{:<24} ", label + ":") << plain(value) << "\n";
    }
  }
}

} // namespace

Subcommand addInfo(CLI::App& app) {
  struct InfoOptions {
    std::string file;
    ReadOptions reading;
    std::string calibration;
    bool json = false;
  };
  auto* command = app.add_subcommand("info", "Describes an image or a model; without a file, this program");
  auto o = std::make_shared<InfoOptions>();
  addOption(*command, "file", o->file, "FILE", "Image, DICOM folder, model (.innergs) or Gaussians (.ply)");
  addReading(*command, o->reading);
  addCalibration(*command, o->calibration);
  command->add_flag("--json", o->json, "Print JSON");
  command->footer(
      "Lengths are in mm; positions in patient space, LPS (x to the left, y to the back, z to the head) and\n"
      "RAS (x to the right, y to the front, z to the head), as 3D Slicer and the app show them.\n"
      "Examples:\n  innergs info\n  innergs info scan.nii.gz\n  innergs info head.innergs --json");
  return {command, [o] {
            o->reading.calibration = o->calibration;
            const Json info = o->file.empty()           ? programInfo()
                              : looksLikeModel(o->file) ? modelInfo(o->file)
                                                        : imageInfo(o->file, o->reading);
            if (o->json)
              std::cout << info.dump(2) << "\n";
            else
              printPlain(info);
            return static_cast<int>(Success);
          }};
}

} // namespace innergs::cli
