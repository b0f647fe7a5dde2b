#include "IO/ModelFile.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "IO/FilePath.h"
#include "IO/ModelMetadata.h"
#include "IO/Ply.h"
#include "IO/Safetensors.h"

#include <cmath>

namespace innergs {

ModelNotes notesOf(const ReconstructionResult& result, const std::string& inputs, const std::string& mask,
                   const std::string& settings) {
  ModelNotes notes{{"Version", INNERGS_VERSION}, {"Inputs", inputs},
                   {"Settings", settings},       {"InstructionSet", result.instructionSet},
                   {"Device", result.device.id}, {"TrainingPSNR", formatted("%.3f", result.trainingPsnr)}};
  if (!mask.empty()) notes["Mask"] = mask;
  if (!std::isnan(result.heldOutPsnr)) { // from a second fit
    notes["HeldOutPSNR"] = formatted("%.3f", result.heldOutPsnr);
    notes["HeldOutSlices"] = std::to_string(result.heldOutSlices);
  }
  return notes;
}

void writeModel(const Model& model, const std::filesystem::path& path, const ModelNotes& notes,
                const FeatureModel* features) {
  std::map<std::string, std::string> more;
  std::vector<TensorToWrite> tensors;
  if (features) addFeatures(*features, model.field, more, tensors);
  writeModelWith(model, path, notes, more, std::move(tensors));
}

Model readModel(const std::filesystem::path& path, ModelNotes* notes, std::optional<FeatureModel>* features) {
  if (features) features->reset();
  if (isPly(path)) {
    Model gaussians;
    gaussians.field = readPly(path);
    gaussians.finished = gaussians.field.size();
    if (notes) notes->clear();
    return gaussians;
  }
  const SafetensorsFile file(path);
  checkFormat(file, path);
  if (isDynamic(file))
    throw Error(ErrorCode::UnsupportedImage,
                quoted(path) +
                    " is a model of a dynamic scan; make the volume of one time from it first (innergs "
                    "interpolate --at).");
  return readModelFrom(file, path, notes, features);
}

} // namespace innergs
