#include "Core/Job/RequestErrors.h"

namespace innergs {
namespace {

Error invalid(const std::string& sentence) {
  return {ErrorCode::InvalidArgument, sentence};
}

} // namespace

Error noInputError() {
  return invalid("There is no input volume: choose at least one.");
}

Error noMaskError(const std::string& name) {
  return invalid("'" + name + "' has no mask, but other scans have one: choose one for it, or one for all.");
}

Error noReferenceError() {
  return invalid("There is no reference volume to take the output grid from: choose one.");
}

Error outputIsInputError(const std::string& name) {
  return invalid("The output '" + name + "' is an input as well: choose another, inputs are never changed.");
}

Error outputIsMaskError(const std::string& name) {
  return invalid("The output '" + name +
                 "' is the mask or the reference as well: choose another, these are never changed.");
}

} // namespace innergs
